"""Dates, per cent, money and digits in groups are read as people write them, in one form a column, or refused."""

import json

import numpy as np
import pandas as pd
import pytest

from octmip import OptimalTreeClassifier
from octmip.formats.columns import Columns, ColumnsError
from octmip.interfaces.cli import main
from octmip.trees.nodes.tree import Leaf, Split


def learned(cells, **settings):
    return Columns.learn(pd.DataFrame({"a": cells}), **settings)


@pytest.mark.parametrize(
    ("cells", "numbers", "note"),
    [
        (["2025-03-04", "2025-03-05"], [20151, 20152], "dates"),
        (["2025-03-04 12:00", "2025-03-05T06:00Z"], [20151.5, 20152.25], "dates"),
        (["13/04/2025", "05/06/2025"], [20191, 20244], "14/03/2025"),
        (["04/13/2025", "06/05/2025"], [20191, 20244], "03/14/2025"),
        (["4.3.2025", "05.03.2025"], [20151, 20152], "14.03.2025"),
        (["2025-03-04", "?"], [20151, np.nan], "dates"),
        (["5%", "7.5 %", "-2%"], [5, 7.5, -2], "per cent"),
        (["5,5%", "1.007,25%"], [5.5, 1007.25], "per cent"),
        (["$1,000.50", "-$5"], [1000.5, -5], "amounts in $"),
        (["$5", "0", "0.00"], [5, 0, 0], "amounts in $"),
        (["5%", "0"], [5, 0], "per cent"),
        (["$1,234", "$950"], [1234, 950], "amounts in $"),
        (["1.234 €", "12,50 €"], [1234, 12.5], "amounts in €"),
        (["1,23,456.5", "12,34,567"], [123456.5, 1234567], "numbers (1,000.5 is 1000.5)"),
        (["1,234,567", "950"], [1234567, 950], "numbers (1,000.5 is 1000.5)"),
        (["5.5 mm", "0", "7mm", "6 mm"], [5.5, 0, 7, 6], "numbers in mm"),
        (["1,248 kg/m³", "950.12 kg/m³", "3kg/m³"], [1248, 950.12, 3], "numbers in kg/m³"),
        (["21.5 °C", "-3 °C", "0 °C"], [21.5, -3, 0], "numbers in °C"),
        (["(1,000.50)", "3", "2.00-"], [-1000.5, 3, -2], "numbers (1,000.5 is 1000.5)"),
        (["1 234", "20'000"], [1234, 20000], "numbers (1,000.5 is 1000.5)"),
    ],
)
def test_what_people_write_is_read_as_numbers_with_a_note(cells, numbers, note):
    columns = learned(cells)
    assert columns.feature_names == ("a",)
    np.testing.assert_array_equal(columns.encode(pd.DataFrame({"a": cells}))[:, 0], numbers)
    assert note in " ".join(columns.changes())
    assert Columns.from_json(json.loads(json.dumps(columns.to_json()))) == columns


@pytest.mark.parametrize(
    ("cells", "sentence"),
    [
        (["03/04/2025", "05/06/2025"], "either number may be the month.*write them as 2025-03-14"),
        (["03/03/2025", "04/04/2025"], "either number may be the month"),
        (["03/04/25", "05/06/25"], "years have two digits"),
        (["1,234", "5,678"], "may be 1234 or 1.234.*without marks"),
        (["1,248 mm", "2,125 mm", "3,555 mm"], "may be 1248 or 1.248.*without marks"),
        (["$5", "€6"], r"different signs \(\$ and €\)"),
        (["5", "6%"], "different signs"),
        (["9" * 400, "1,000.5"], "too large for float64; correct it"),
    ],
)
def test_what_can_be_read_in_two_ways_is_refused_with_its_cure(cells, sentence):
    with pytest.raises(ColumnsError, match=sentence):
        learned(cells)


WORDS = (
    *("5more|4", "1.2.3|1.2.4", "2, 3|4, 5", "A-1|A-2", "x%|y%"),
    *("1st|2nd|3rd", "2wd|4wd", "(1)|(2)|(3)", "1-|2-|3-", "5 mm|5 cm|6 cm", "5%|7#"),
)


def test_each_column_is_named_with_its_own_form():
    found = Columns.learn(pd.DataFrame({"a": ["5%", "7%"], "b": ["$5", "$7"], "c": [1.0, 2.0]})).changes()
    assert [words.rpartition(" (")[0] for words in found] == [
        "1 column ('a') read as per cent",
        "1 column ('b') read as amounts in $",
    ]


@pytest.mark.parametrize("cells", [words.split("|") for words in WORDS])
def test_words_with_digits_stay_words(cells):
    assert learned(cells).columns[0].kind == "values"


@pytest.mark.parametrize(
    ("trained", "later", "sentence"),
    [
        (["5%", "7%"], [0.05, 0.07], "the number 0.05; expected per cent"),
        (["5 mm", "6 mm", "7 mm"], [5.0, 7.0, 6.0], "the number 5; expected numbers in mm"),
        (["5 mm", "6 mm", "7 mm"], ["5 cm", "7 cm", "6 cm"], "'5 cm'; expected numbers in mm"),
        (["5%", "7%"], ["$5", "$7"], "'.5'; expected per cent"),
        ([5.0, 7.0], ["5%", "7%"], "holds text such as '5%'; expected numbers"),
        ([5.0, 7.0], ["110", "um/m"], "holds text such as 'um/m'; expected numbers"),
        (["13/04/2025", "05/06/2025"], ["04/13/2025"] * 2, "expected dates .14 March 2025: 14/03/2025"),
        (["2025-01-01", "2025-01-02"], [20089, 20090], "the number 20089; expected dates"),
        ([1.0, 2.0], pd.to_datetime(["2025-01-01", "2025-01-02"]), "holds dates .*expected plain numbers"),
        (
            pd.to_datetime(["2025-01-01", "2025-01-02"]),
            pd.to_timedelta([1, 2], "D"),
            "durations in days .*; expected dates",
        ),
    ],
)
def test_later_tables_are_read_in_the_form_of_training_alone(trained, later, sentence):
    with pytest.raises(ColumnsError, match=sentence):
        learned(trained).encode(pd.DataFrame({"a": later}))


def test_dates_of_pandas_and_in_texts_are_the_same_number():
    stamps, texts = pd.to_datetime(["2025-01-01", "2025-01-02"]), ["2025-01-01", "2025-01-02T00:00"]
    assert (
        learned(stamps).encode(pd.DataFrame({"a": texts})) == learned(texts).encode(pd.DataFrame({"a": stamps}))
    ).all()


def test_an_ambiguous_later_table_is_read_in_the_order_of_training():
    columns = learned(["13/04/2025", "05/06/2025"])
    assert columns.encode(pd.DataFrame({"a": ["03/04/2025"]})).tolist() == [[20181]]


def test_a_threshold_is_said_as_people_write_it():
    split = Split(0, 20151.0, Leaf(0), Leaf(1))
    assert learned(["2025-03-04", "2025-03-05"]).left_words(split) == "a <= 2025-03-04"
    assert learned(["2025-03-04", "2025-03-05"]).left_words(Split(0, 20151.5, Leaf(0), Leaf(1))) == (
        "a <= 2025-03-04 12:00"
    )
    assert learned(["5%", "7%"]).left_words(Split(0, 6.0, Leaf(0), Leaf(1))) == "a <= 6%"


# Types of pandas that `tests/doors/frames.py` has not, and what their times are as numbers

TIMES = pd.Series(pd.to_datetime(["2025-03-04 00:00", None, "2025-03-05 12:00"]))
MONTHS = pd.PeriodIndex(["2025-03", None, "2025-05"], freq="M")
PANDAS = {
    "bool": (pd.Series([True, False, True]), [1, 0, 1]),
    "boolean": (pd.Series([True, None, False], dtype="boolean"), [1, np.nan, 0]),
    "bool[pyarrow]": (pd.Series([True, None, False], dtype="bool[pyarrow]"), [1, np.nan, 0]),
    "object of numbers": (pd.Series([1, None, "3"], dtype=object), [1, np.nan, 3]),
    "convert_dtypes": (pd.Series([1, None, 3], dtype=object).convert_dtypes(), [1, np.nan, 3]),
    "ordered months": (pd.Series(pd.Categorical(MONTHS, ordered=True)), [0, np.nan, 1]),
    "datetime with tz": (TIMES.dt.tz_localize("Etc/GMT-6"), [20150.75, np.nan, 20152.25]),
    "datetime as category": (TIMES.astype("category"), [20151, np.nan, 20152.5]),
    "timestamp[pyarrow]": (TIMES.astype("timestamp[us][pyarrow]"), [20151, np.nan, 20152.5]),
    "duration[pyarrow]": ((TIMES - TIMES[0]).astype("duration[us][pyarrow]"), [0, np.nan, 1.5]),
    "period": (pd.Series(MONTHS), [20148, np.nan, 20209]),
}
TEXTS = {
    "object with pd.NA": pd.Series(["u", pd.NA, "v"], dtype=object),
    "large_string[pyarrow]": pd.Series(["u", None, "v"]).astype("large_string[pyarrow]"),
    "convert_dtypes": pd.Series(["u", None, "v"], dtype=object).convert_dtypes(),
    "category of string": pd.Series(["u", None, "v"], dtype="string").astype("category"),
}


@pytest.mark.parametrize("kind", PANDAS)
def test_every_dtype_of_numbers_and_times_becomes_one_feature(kind):
    cells, numbers = PANDAS[kind]
    frame = pd.DataFrame({"a": cells})
    np.testing.assert_array_equal(Columns.learn(frame).encode(frame)[:, 0], numbers)
    model = OptimalTreeClassifier(max_depth=1).fit(frame, ["p", "p", "q"])
    assert model.predict(frame).shape == (3,)


@pytest.mark.parametrize("kind", TEXTS)
def test_every_dtype_of_text_becomes_questions_with_its_missing_readings(kind):
    frame = pd.DataFrame({"a": TEXTS[kind]})
    columns = Columns.learn(frame)
    assert columns.feature_names == ("a is u", "a is v", "a is missing")
    assert columns.encode(frame).tolist() == [[1, 0, 0], [0, 0, 1], [0, 1, 0]]
    assert (OptimalTreeClassifier(max_depth=2).fit(frame, ["p", "q", "p"]).predict(frame) == ["p", "q", "p"]).all()


def test_a_threshold_on_dates_is_a_date_where_no_column_is_text(tmp_path, capsys):
    rows = [f"2025-01-{k:02},{'late' if k > 15 else 'early'}" for k in range(1, 29)]
    data = tmp_path / "t.csv"
    data.write_text("\n".join(["day,y", *rows]) + "\n")
    assert main(["solve", str(data), "--label", "y", "--depth", "1"]) == 0
    assert "day <= 2025-01-15\n" in capsys.readouterr().out


MONTH_NAMES = [
    "January February March April May June July August September October November December",
    "Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec",
    "Januar Februar März April Mai Juni Juli August September Oktober November Dezember",
    "Jan Feb Mär Apr Mai Jun Jul Aug Sep Okt Nov Dez",
    "jan feb mrz apr mai jun jul aug sep okt nov dez",
]


@pytest.mark.parametrize("form", ["14 {} 2025", "{} 14, 2025", "2025-{}-14", "14. {} 2025 00:00"])
@pytest.mark.parametrize("names", MONTH_NAMES)
def test_each_month_has_its_number_in_both_languages(names, form):
    table = pd.DataFrame({"t": [form.format(name) for name in names.split()]})
    days = [(pd.Timestamp(2025, month, 14) - pd.Timestamp(1970, 1, 1)).days for month in range(1, 13)]
    assert Columns.learn(table).encode(table)[:, 0].tolist() == days
