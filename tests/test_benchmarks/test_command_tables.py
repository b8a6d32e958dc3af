"""Public tables by one command: three of the seventy-one here, all in the benchmark `command_tables`."""

import pytest

from benchmarks.cases.command.tables import SWITCHES, outcome, summary
from benchmarks.data import SHARED


@pytest.mark.parametrize(
    ("name", "text_columns", "missing_cells"),
    [("iris", 0, 0), ("hepatitis", 13, 167), ("zoo", 1, 0)],
)
def test_a_table_as_it_is_found_is_solved_by_one_command(name, text_columns, missing_cells):
    line = outcome(SHARED / "uci" / f"{name}.csv", 20.0)
    assert line["outcome"] == "proven"
    assert (line["text_columns"], line["missing_cells"]) == (text_columns, missing_cells)
    assert line["errors"] <= line["cart"]["training"]["errors"]
    switches = SWITCHES.get(name, ())
    assert tuple(line["switches"]) == switches
    assert all(switch in line["refusal"] for switch in switches[:1])
    assert f"| {name} |" in summary([line])
