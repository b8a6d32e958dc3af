"""The benchmark families: each loads and names its cases; the table says what the lines say."""

import pytest

from benchmarks.blind.__main__ import main as blind_main
from benchmarks.case import Case
from benchmarks.cases import calibration_beside
from benchmarks.cases.exact import boundaries, large
from benchmarks.data import SHARED, numeric_sets, published, synthetic_uav
from benchmarks.registry import FAMILIES, family
from benchmarks.rivals import RIVALS
from benchmarks.tables import race_table

needs_data = pytest.mark.skipif(
    not SHARED.exists(), reason=f"the data sets beside the repository ({SHARED}) are absent"
)


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
    assert cases[0].build().n_samples > 1


@pytest.mark.parametrize("way", large.WAYS)
def test_large_tables_are_measured_with_memory_and_predictions(way):
    line = large.measured(400, 3, way, 1.0)
    assert line["megabytes"] >= line["table_megabytes"] > 0
    assert line["predictions_per_second"] > 0
    assert 0 <= line["objective"] < 200
    assert line["outcome"] in {"proven", "greedy", "finished", "optimal", "time"}


def test_boundaries_have_an_exponent_of_their_proven_sizes():
    lines = list(boundaries.results(5.0, [1], [400, 1600]))
    assert [line["size"] for line in lines[::2]] == [f"{boundary}, 400 rows" for boundary in boundaries.BOUNDARIES]
    lines = [line | {"cpu_seconds": line["n"] ** 1.5, "objective": 7.0} for line in lines]
    assert boundaries.summary(lines).splitlines()[2] == "| a tree | 8e+03 | 6.4e+04 | 1.50 |"


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


def test_the_synthetic_set_is_the_one_described():
    table = synthetic_uav("B")
    assert table.features.shape == (1750, 20)
    assert set(table.labels) == {0, 1, 2, 3, 4}


@needs_data
def test_the_published_strains_follow_the_recipe():
    table = published("mu2", 0)
    assert table.features.shape == (1750, 20)
    assert set(table.labels) == {0, 20, 40, 60, 80}


def line(solver, seconds, outcome="proven", objective=3.0, **more):
    timing = {"cpu_seconds": seconds, "wall_seconds": seconds}
    return {"size": "s", "seed": 0, "solver": solver, "threads": 1, "limit": 60.0, "outcome": outcome} | (
        timing | {"objective": objective} | more
    )


def test_the_table_shows_ratios_and_their_mean():
    table = race_table([line("octmip", 0.1), line("pycontree", 2.0)])
    assert "| s | 0 | 3 | 0.1 | 2 | 20 |" in table
    assert "more than 0.1 s: 20." in table


def test_the_table_says_where_the_peer_was_stopped_or_ours_is_slower():
    stopped = race_table([line("octmip", 0.1), line("pycontree", 61.0, "not proven", 4.0)])
    assert ">610" in stopped
    assert "61 (4, not proven)" in stopped
    assert "0.02 s: s." in race_table([line("octmip", 0.5), line("pycontree", 0.1)])


def test_the_table_shows_a_disagreement():
    assert "DISAGREE: 3, 4" in race_table([line("octmip", 0.1), line("pycontree", 2.0, objective=4.0)])


@pytest.mark.parametrize(("arguments", "message"), [
    (["--cases", "0"], "--cases is 0; expected 1 or more"),
])  # fmt: skip
def test_a_plan_that_cannot_be_is_refused(arguments, message, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["blind", *arguments])
    with pytest.raises(SystemExit):
        blind_main()
    assert message in capsys.readouterr().err


@needs_data
def test_shares_of_ours_of_cart_and_of_a_forest_are_compared_on_new_rows(monkeypatch):
    monkeypatch.setattr(calibration_beside, "TABLES", ("iris",))
    lines = list(calibration_beside.results(1.0, [1]))
    assert [line["learner"] for line in lines] == list(calibration_beside.LEARNERS)
    assert all(line["n_training"] + line["n_new"] == 150 for line in lines)
    assert all(0 <= line["ece"] < 0.2 and line["brier"] < 0.3 and line["wrong"] < 0.2 for line in lines)
    assert "| iris | 75 |" in calibration_beside.summary(lines)
