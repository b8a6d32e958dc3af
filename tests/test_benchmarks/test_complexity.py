"""The complexity study in small: lines are kept and not mixed up, and the tables say what the lines say."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.uav.bayes import BayesLimit
from benchmarks.uav.complexity import lines as kept_lines
from benchmarks.uav.complexity.cells import Cell, bayes_limits, pair_limits, paper_cells, problem_of, study_cells
from benchmarks.uav.complexity.report import write_complexity
from benchmarks.uav.complexity.tables import complexity_table, overfitting, paper_table
from femlib.dataset import MeanStrains, Recipe, build_dataset, study_states_percent
from octmip.trees import _native

SMALL = Recipe(samples_per_state=6)
PAIRS = {"mu1": 0.2, "mu2": 17.0}
LIMITS = {"mu1": BayesLimit(0.0, 0.1, 0.0, 0.0), "mu2": BayesLimit(0.5, 13.0, 0.0, 0.0)}


@pytest.fixture(scope="module")
def means() -> MeanStrains:
    """Return the strains of five gauges along a made-up beam: no wing has to be built."""
    states = study_states_percent()
    first, second = np.linspace(150, 10, 5), np.array([0, 5, 15, 40, 20])
    loss = states / 100 / (1 - 0.8 * states / 100)
    strain = 600 + 3 * (loss[:, :1] * first + loss[:, 1:] * second)
    return MeanStrains(states, strain, 3.0, tuple(f"g{k:02d}" for k in range(1, 6)), np.ones(5, bool), "a beam", "")


def some_cells() -> list[Cell]:
    grid = [cell for cell in study_cells([0]) if cell.depth == 3 and cell.split_size in (1, 2)]
    return grid + [cell for cell in paper_cells([0]) if cell.gauge_set == "two"]


def test_a_small_study_runs_goes_on_from_what_it_kept_and_is_written(means: MeanStrains, tmp_path: Path) -> None:
    cells, kept = some_cells(), tmp_path / "lines.jsonl"
    first = kept_lines.run(cells[:3], means, 1, 1, kept, SMALL)
    lines = kept_lines.run(cells, means, 1, 1, kept, SMALL)
    written = [json.loads(line) for line in kept.read_text().splitlines()]
    assert len(written) == len(cells)
    assert all(lines[cell] == first[cell] for cell in cells[:3])
    again = kept_lines.run(cells, means, 1, 1, kept, SMALL)
    assert again == lines
    assert len(kept.read_text().splitlines()) == len(cells)
    write_complexity(tmp_path, lines, bayes_limits(means), ["errors", "mae"])
    pairs = pair_limits(means, lines)
    assert all(pairs[label] >= limit.mae for label, limit in bayes_limits(means).items())
    assert {"complexity.md", "complexity_errors_train.svg", "complexity_mae_test.png"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_a_line_of_other_readings_restarts_or_core_is_not_taken(
    means: MeanStrains, tmp_path: Path, monkeypatch
) -> None:
    cells, kept = [Cell("mu1", "all", 3, 2, "errors", 0)], tmp_path / "lines.jsonl"
    kept_lines.run(cells, means, 1, 1, kept, SMALL)
    kept_lines.run(cells, means, 2, 1, kept, SMALL)
    kept_lines.run(cells, means, 1, 1, kept, Recipe(samples_per_state=5))
    other_core = tmp_path / "core.so"
    other_core.write_bytes(b"another")
    monkeypatch.setattr(_native, "__file__", str(other_core))
    kept_lines.run(cells, means, 1, 1, kept, SMALL)
    keys = [json.loads(line)["key"] for line in kept.read_text().splitlines()]
    assert len(set(keys)) == 4


def test_the_mae_of_a_tree_trained_for_it_is_its_objective_per_reading(means: MeanStrains) -> None:
    cell = Cell("mu2", "all", 3, 1, "mae", 0)
    data = build_dataset(means, SMALL, seed=0)
    problem = problem_of(cell, data, data.gauges)
    assert problem.costs.max() == 80
    assert problem.costs[0, 1] == 20
    assert (np.diag(problem.costs) == 0).all()
    line = kept_lines.run([cell], means, 1, 1, None, SMALL)[cell]
    assert (
        line["train_mae"]
        <= kept_lines.run([Cell("mu2", "all", 3, 1, "errors", 0)], means, 1, 1, None, SMALL)[
            Cell("mu2", "all", 3, 1, "errors", 0)
        ]["train_mae"]
    )


def made_up(train: float, test: float, seeds: int = 2, **cell: object) -> dict[Cell, dict[str, float]]:
    base = {"label": "mu2", "gauge_set": "all", "depth": 3, "split_size": 4, "objective": "errors"} | cell
    return {
        Cell(**base, seed=seed): {"train_mae": train + seed, "test_mae": test, "seed": seed} for seed in range(seeds)
    }


def test_the_grid_shows_means_over_seeds_and_stars_what_is_below_the_bayes_limit() -> None:
    lines = made_up(12.0, 17.0) | made_up(18.0, 20.0, split_size=1)
    table = complexity_table(lines, "errors", LIMITS)
    assert "| 3 | 18.50 / 20.00 | - | 12.50* / 17.00 | - | 13.00 |" in table
    sentence = overfitting(lines | made_up(0.0, 0.5, label="mu1"), "errors", LIMITS)[1]
    assert "1: nowhere" in sentence
    assert "4: from depth 3" in sentence
    assert "12.50 in training, 17.00 unseen" in sentence


def test_the_papers_figures_are_met_as_they_stand_or_as_a_ratio_to_the_axis_figure() -> None:
    axis = made_up(20.0, 21.0, seeds=1, split_size=1)
    assert "errors: ratio 0.60, yes (paper 0.69)" in paper_table(axis | made_up(12.0, 17.0, seeds=1), LIMITS, PAIRS)
    assert "errors: ratio 0.75, no (paper 0.69)" in paper_table(axis | made_up(15.0, 17.0, seeds=1), LIMITS, PAIRS)
    assert "| 11 | 17 |" in " ".join(
        paper_table(axis | made_up(11.0, 17.0, seeds=1), LIMITS, PAIRS).replace(".00", "").split()
    )
