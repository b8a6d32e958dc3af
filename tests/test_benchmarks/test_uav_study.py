"""The UAV study in small: every method answers, the rows say what they must, the files are whole."""

import json
from pathlib import Path

import pytest

from benchmarks.uav import report, study
from femlib.dataset import Recipe, build_dataset, simulated_strains
from femlib.wing import uav_wing

TASKS = (
    study.Task("axis", ("all",), (2,), study.METHODS),
    study.Task("axis", ("two",), (2,), ("cart", "search", "exact")),
    study.Task("two features", ("two",), (1,), ("search", "exact", "oct_h")),
    study.Task("budget 2", ("all",), (2,), ("cart", "search", "exact")),
    study.Task("risk", ("all",), (2,), ("cart", "search", "exact")),
)


def test_no_method_is_below_the_proven_optimum(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn, write = {}, report.write_figure  # all pictures are made, one is drawn: that takes as long as all solves
    monkeypatch.setattr(report, "write_figure", lambda folder, name, figure: drawn.update({name: figure}))
    wing = uav_wing(refinement=0.25)
    data = build_dataset(simulated_strains(wing), Recipe(samples_per_state=8), seed=1)
    outcomes = study.run_study(data, study.StudyLimits(10.0, 0.3), seed=1, n_jobs=1, tasks=TASKS)
    report.write_results(tmp_path, wing, simulated_strains(wing), None, data, outcomes, 0.0)
    assert {"wing", "strain", "tree_mu1", "partition_mu2_two_features"} <= set(drawn)
    write(tmp_path, "strain", drawn["strain"])
    assert {path.suffix for path in tmp_path.glob("strain.*")} == {".svg", ".png"}
    rows = json.loads((tmp_path / "table.json").read_text())
    proven = {_task(row): row["objective"] for row in rows if row["method"] == "exact"}
    assert all(row["objective"] >= proven[_task(row)] for row in rows)
    assert all(row["bound"] is None or row["bound"] <= proven[_task(row)] for row in rows)
    assert all(row["is_optimal"] for row in rows if row["method"] == "exact")


def _task(row: dict[str, object]) -> tuple[object, ...]:
    return row["task"], row["label"], row["depth"], row["gauge_set"]
