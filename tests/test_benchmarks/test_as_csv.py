"""A data file is the table that its command prints, cell by cell."""

import io

import pytest

from benchmarks.as_csv import main, tables_of

PRINTED = """words
| set | `errors` |
|---|---:|
| a, b | **27** |
| c \\| d | 3 |

| one |
| - |
"""


def test_each_table_is_a_head_and_its_rows_without_marks():
    assert tables_of(PRINTED) == [[["set", "errors"], ["a, b", "27"], ["c | d", "3"]], [["one"]]]


def test_the_table_of_a_number_is_printed_as_csv(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO(PRINTED))
    main([])
    assert capsys.readouterr().out == 'set,errors\n"a, b",27\nc | d,3\n'


@pytest.mark.parametrize("number", ["0", "3"])
def test_a_number_without_a_table_is_refused(number, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO(PRINTED))
    with pytest.raises(SystemExit, match=f"holds 2 tables in Markdown; expected table {number}"):
        main([number])
