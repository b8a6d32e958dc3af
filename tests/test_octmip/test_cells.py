"""Cells of CSV text: where a row stands and what counts as a number, the same for tables of samples and campaigns."""

import csv

import pytest

from octmip.errors import DataError
from octmip.formats.table import read_table
from octmip.gap import read_campaign
from octmip.input.cells import CsvRows, plain_number
from tests.test_octmip.beam_twin import Beam, measured
from tests.test_octmip.test_gap_campaign import lines_of, with_cell


def test_a_row_knows_its_first_and_its_last_line():
    rows = CsvRows([(3, 'a,"b\n'), (4, 'c",d\n'), (7, "e\n")])
    assert [(row, rows.first, rows.last) for row in rows] == [(["a", "b\nc", "d"], 3, 4), (["e"], 7, 7)]


def test_a_quotation_left_open_is_an_error_of_the_row_in_which_it_opens():
    rows = CsvRows([(1, "a\n"), (2, '"b\n'), (3, "c\n")], strict=True)
    assert next(rows) == ["a"]
    with pytest.raises(csv.Error):
        next(rows)
    assert (rows.first, rows.last) == (2, 3)


@pytest.mark.parametrize("cell", ["1_000", "١٢", "0x10", "two", "", "True"])
def test_what_is_no_plain_number_is_none_in_samples_nor_in_campaigns(tmp_path, cell):
    assert plain_number(cell) is None
    if not cell:  # means "not recorded" in a campaign
        return
    (tmp_path / "data.csv").write_text(f'x,y\n1,a\n"{cell}",b\n')
    with pytest.raises(DataError, match="is no number") as refused:
        read_table(tmp_path / "data.csv").numbers(["x"])
    assert "line 3, column 'x'" in str(refused.value)
    lines = with_cell(lines_of(measured(1, repeats=3)), 3, "g05", "?")
    (tmp_path / "campaign.csv").write_text("\n".join(lines).replace("?", f'"{cell}"') + "\n")
    with pytest.raises(DataError, match="row 4, column g05"):
        read_campaign(tmp_path / "campaign.csv", Beam())
