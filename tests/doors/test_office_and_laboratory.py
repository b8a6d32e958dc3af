"""Cells of offices and of laboratories: amounts, times with a zone, rows of units, samples beyond a range."""

import numpy as np
import pandas as pd
import pytest

from octmip.errors import DataError
from octmip.formats.columns.times import read_time_texts, time_form_of, zone_in
from octmip.formats.columns.written import form_of, read_texts
from octmip.formats.table import read_table
from octmip.formats.table.units import factor_between
from octmip.gap import function_twin, read_campaign
from octmip.interfaces.cli import main
from octmip.recordings import recording
from tests.doors.test_uff_text import text_of

AMOUNTS = (0.0, -1500.5, 2500.0, 0.0, 1200.25, -7.0)
STYLES = {
    "comma": ('" -   "', '" ({:,.2f})"', '" {:,.2f} "'),
    "accounting": ('" $-   "', '" $({:,.2f})"', '" ${:,.2f} "'),
}


@pytest.mark.parametrize("style", STYLES)
def test_amounts_of_excel_are_their_numbers(style, tmp_path):
    zero, below, above = STYLES[style]
    cells = [zero if a == 0 else below.format(-a) if a < 0 else above.format(a) for a in AMOUNTS]
    (tmp_path / "t.csv").write_text("amount,y\n" + "".join(f"{cell},{k}\n" for k, cell in enumerate(cells)))
    texts = read_table(tmp_path / "t.csv").frame["amount"].tolist()
    np.testing.assert_allclose(read_texts(texts, form_of(sorted(set(texts)))), AMOUNTS)


def test_a_dash_among_words_stays_one(tmp_path):
    (tmp_path / "t.csv").write_text('kind,y\n" -   ",1\n" new ",2\n" old ",3\n')
    assert read_table(tmp_path / "t.csv").frame["kind"].tolist()[1:] == ["new", "old"]
    assert "0" not in read_table(tmp_path / "t.csv").frame["kind"].tolist()


@pytest.mark.parametrize("word", ["kips", "counts", "#", "PSI"])
def test_a_unit_that_nobody_knows_takes_no_other_away(word, tmp_path):
    rows = "".join(f"{100 * k},{k},0.1,{k / 10}\n" for k in range(40))
    (tmp_path / "run.csv").write_text(f"time,load,rate,tip\nms,{word},cm/s,cm\n{rows}")
    run = recording(tmp_path / "run.csv")
    assert [run[name].unit for name in ("load", "rate", "tip")] == [word, "cm/s", "cm"]
    assert run["tip"].time[-1] == pytest.approx(3.9)


@pytest.mark.parametrize("unit", ['"', "'", "#", "$", "N/", "m^", "="])
def test_a_unit_that_is_none_has_no_factor(unit):
    assert factor_between(unit, "mm") is None


ZONED = {"+0000 UTC": "+00:00", "+0200 CEST": "+02:00", "+01:00[Europe/Berlin]": "+01:00", "Z[UTC]": "Z"}


@pytest.mark.parametrize("zone", ZONED)
def test_the_name_of_a_zone_behind_its_offset_says_nothing_more(zone):
    texts, plain = ([f"2025-03-14T15:09:2{k}.5{z}" for k in range(3)] for z in (zone, ZONED[zone]))
    form = time_form_of(texts)
    np.testing.assert_array_equal(read_time_texts(texts, form), read_time_texts(plain, form))
    assert zone_in(texts) == zone_in(plain)


def test_times_of_a_timetable_of_matlab_have_their_unit(tmp_path):
    (tmp_path / "run.csv").write_text("Time,g1\n" + "".join(f"{k / 2:g} min,{k}\n" for k in range(9)))
    np.testing.assert_allclose(recording(tmp_path / "run.csv")["g1"].time, 30.0 * np.arange(9))


@pytest.mark.parametrize("word", ["∞", "-∞", "INF"])
def test_a_sample_beyond_the_range_is_missing(word, tmp_path):
    rows = "".join(f"{k},{word if k == 7 else k}\n" for k in range(20))
    (tmp_path / "run.csv").write_text(f"time,g1\n(s),(V)\n{rows}")
    assert recording(tmp_path / "run.csv")["g1"].notes() == ("1 of 20 samples are invalid and left out",)


def test_each_channel_of_labview_has_its_own_cells_and_time(tmp_path):
    head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tMulti\nTime_Pref\tRelative\n***End_of_Header***\t\n\t\n"
    cells = {"Channels": "2", "Samples": "3\t\t3", "Date": "2025/03/14\t\t2025/03/14"}
    cells |= {"Time": "10:00:00\t\t10:01:00", "Y_Unit_Label": "mm\t\tN", "X0": "0\t\t0", "Delta_X": "1\t\t1"}
    body = "".join(f"{key}\t{value}\n" for key, value in cells.items()) + "***End_of_Header***\t\t\t\n"
    rows = "".join(f"{k}\t{10 * k}\t{k}\t{20 * k}\t\n" for k in range(3))
    (tmp_path / "run.lvm").write_text(f"{head}{body}X_Value\tg1\tX_Value\tforce\tComment\n{rows}")
    run = recording(tmp_path / "run.lvm")
    assert [(run[name].unit, run[name].time[0]) for name in ("g1", "force")] == [("mm", 0.0), ("N", 60.0)]


def test_times_of_uff58_have_the_unit_of_their_axis(tmp_path):
    head, lines = text_of(2, 1, 9, np.random.default_rng(0))
    in_ms = head.replace("NONE                 NONE", "NONE                 ms  ", 1)
    for name, top in (("s.uff", head), ("ms.uff", in_ms)):
        (tmp_path / name).write_text(top + "\n".join(lines) + "\n    -1\n")
    times = [recording(tmp_path / name)["a"].time for name in ("s.uff", "ms.uff")]
    np.testing.assert_allclose(times[1], 1e-3 * times[0])


def test_a_model_that_is_written_takes_no_tables_place(tmp_path, capsys):
    table = tmp_path / "data.lp"
    table.write_text("x,y\n" + "".join(f"{k},{int(k > 5)}\n" for k in range(12)))
    before = table.read_bytes()
    words = ["--label", "y", "--depth", "1", "--method", "flow", "--option", f"write={table}"]
    assert main(["solve", str(table), *words]) == 2
    assert "would be overwritten" in capsys.readouterr().err
    assert table.read_bytes() == before


def test_a_reading_of_a_campaign_is_never_infinite(tmp_path):
    twin = function_twin(lambda p, load: [load["load_factor"]], readings={"g1": "mm"})
    (tmp_path / "c.csv").write_text("test,load_factor,g1\na,1,∞\na,2,3\n")
    with pytest.raises(DataError, match="inf"):
        read_campaign(tmp_path / "c.csv", twin)


@pytest.mark.parametrize("separator", [" ", "\t", ","])
def test_a_quotation_mark_of_r_is_one(separator, tmp_path):
    sizes = ['3/4" pipe', '1" pipe', '1/2"']
    written = ['"' + size.replace('"', '\\"') + '"' for size in sizes]
    rows = [f'"{k}"{separator}{written[k % 3]}{separator}{k / 2}\n' for k in range(9)]
    (tmp_path / "t.txt").write_text(separator.join(('"row"', '"size"', '"x"')) + "\n" + "".join(rows))
    assert read_table(tmp_path / "t.txt").frame["size"].tolist() == [sizes[k % 3] for k in range(9)]


def test_a_backslash_at_the_end_of_a_text_is_one(tmp_path):
    (tmp_path / "t.csv").write_text('folder,x\n"C:\\a\\",1\n"C:\\b\\",2\n')
    assert read_table(tmp_path / "t.csv").frame["folder"].tolist() == ["C:\\a\\", "C:\\b\\"]


def test_a_swiss_apostrophe_groups_digits():
    assert read_texts(["1\u2019234.5", "2\u2019000.25"], form_of(["1\u2019234.5", "2\u2019000.25"])).tolist() == [
        1234.5,
        2000.25,
    ]


def test_a_column_with_the_name_of_an_option_keeps_it(tmp_path, capsys):
    (tmp_path / "t.csv").write_text("leaf_size,z,y\n" + "".join(f"a{k},{k % 5},{k % 2}\n" for k in range(40)))
    assert main(["solve", str(tmp_path / "t.csv"), "--label", "y", "--depth", "1"]) == 2
    assert "--drop leaf_size;" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text", ["9 mars 2025", "9 de marzo de 2025", "9 marzo 2025", "9 de março de 2025", "9. März 2025", "9 mrt. 2025"]
)
def test_a_month_has_its_name_in_seven_languages(text):
    assert (
        read_time_texts([text], time_form_of([text])).tolist() == read_time_texts(["2025-03-09"], "%Y-%m-%d").tolist()
    )


def test_texts_of_one_width_are_the_same_in_csv_and_parquet(tmp_path):
    pytest.importorskip("pyarrow")
    frame = pd.DataFrame({"m": ["Bell  ", "nan   ", None, "x"], "list": [[1], [2], [3], [4]], "n": [1, 2, 3, 4]})
    frame.to_parquet(tmp_path / "t.parquet")
    read = read_table(tmp_path / "t.parquet")
    assert read.frame["m"].tolist()[:2] == ["Bell", "nan"]  # a text, as in a column that is not padded
    assert read.notes == ("blanks at the ends of texts are left out: 'm'",)
