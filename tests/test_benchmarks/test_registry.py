"""The benchmark families: each loads and names its cases; the table says what the lines say."""

import csv
import statistics
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from benchmarks.blind.__main__ import main as blind_main
from benchmarks.case import Case
from benchmarks.cases.command.tables import SWITCHES, outcome, summary
from benchmarks.cases.exact import option_prices
from benchmarks.data import SHARED, numeric_sets
from benchmarks.registry import FAMILIES, family
from benchmarks.rivals import RIVALS
from benchmarks.tables import Line, race_table

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "docs" / "results" / "data" / "benchmarks"

needs_data = pytest.mark.skipif(
    not SHARED.exists(), reason=f"the data sets beside the repository ({SHARED}) are absent"
)


@pytest.mark.long("exact_uci")
@needs_data
@pytest.mark.parametrize("name", FAMILIES)
def test_a_family_names_its_cases_or_yields_results(name):
    module = family(name)
    if hasattr(module, "results"):
        return
    cases = list(module.cases())
    assert cases
    assert all(isinstance(case, Case) for case in cases)
    assert len({(case.size, case.seed) for case in cases}) == len(cases)
    assert {solver for case in cases for solver in case.solvers} <= set(RIVALS)
    assert cases[0].build().samples.n_samples > 1


def test_an_unknown_family_is_refused_with_the_known_ones():
    with pytest.raises(SystemExit, match="exact_uci"):
        family("exact_uic")


@needs_data
def test_a_set_is_numeric_or_left_out_for_a_reason():
    names, left_out = numeric_sets()
    assert {"iris", "wine", "breast-cancer-wisconsin-diagnostic"} <= set(names)
    assert left_out["abalone"] == "columns of text"
    assert left_out["ct-bank"].startswith("the same samples")
    assert not set(names) & set(left_out)


def line(solver, seconds, outcome="proven", objective=3.0, **more):
    timing = {"cpu_seconds": seconds, "wall_seconds": seconds}
    return {"size": "s", "seed": 0, "solver": solver, "threads": 1, "limit": 60.0, "outcome": outcome} | (
        timing | {"objective": objective} | more
    )


def test_the_table_shows_ratios_and_their_mean():
    table = race_table([line("octmip", 0.1), line("pycontree", 2.0)])
    assert "| s | 0 | 3 | 0.1 | 2 | 20 |" in table
    assert "more than 0.1 s: 20." in table


def test_a_table_fails_where_proven_objectives_differ():
    with pytest.raises(ValueError, match="s differ: 3 by octmip, 4 by pycontree"):
        race_table([line("octmip", 0.1), line("pycontree", 2.0, objective=4.0)])
    assert "| 3 |" in race_table([line("octmip", 0.1), line("pycontree", 2.0, "not proven", objective=4.0)])


def timed(rows: Iterable[dict[str, str]]) -> Iterator[Line]:
    """Yield the lines of a data file with their seconds as numbers."""
    for row in rows:
        yield {key: float(cell) if key.endswith("_seconds") and cell else cell for key, cell in row.items()}


@needs_data
def test_larger_leaves_are_proven_on_a_public_table_and_their_prices_told():
    lines = list(option_prices.results(10.0, [1], ["wine"], only="leaf size"))
    assert {line["outcome"] for line in lines} == {"proven"}
    assert [line["objective"] for line in lines if line["option"] == "leaf size 20"] == [6.0, 3.0]
    assert "| leaf size 20 | " in option_prices.summary(lines)


def test_no_two_proven_objectives_of_the_sparse_trees_differ():
    with (RESULTS / "sparse-trees.csv").open() as file:
        lines = [{"size": row["case"], "seed": 0, "threads": 1} | row for row in timed(csv.DictReader(file))]
    race_table([line for line in lines if line["outcome"] == "proven"], peer="fastsmalltree")


def test_pages_say_how_much_faster_depth_3_is_as_the_data_have_it():
    with (RESULTS / "beside-the-peers.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["case"].endswith("depth 3") and " " not in row["pycontree"]]
    assert not [row for row in rows if "DISAGREE" in row["optimum"]]
    ratios = [float(row["ratio"]) for row in rows if row["ratio"] and float(row["pycontree"]) > 0.1]
    mean = round(statistics.geometric_mean(ratios))
    for page in ("README.md", "docs/index.md"):
        assert f"depth 3 proven {mean} times as fast as pycontree" in (ROOT / page).read_text()
    assert f"At depth 3 the mean is {mean}." in (ROOT / "docs/benchmarks.md").read_text()


def test_a_plan_that_cannot_be_is_refused(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["blind", "--cases", "0"])
    with pytest.raises(SystemExit):
        blind_main()
    assert "--cases is 0; expected 1 or more" in capsys.readouterr().err


# Public tables by one command: three of the seventy-one here, all in the benchmark `command_tables`


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
