"""The risk study runs from the command, and its figures hang together."""

import pytest

from benchmarks.data import SHARED
from benchmarks.uav.risk.decisions import decision_rows, report, state_rows
from femlib.dataset import Recipe, build_dataset, published_strains

STRAINS = SHARED / "uav" / "strains.csv"
needs_strains = pytest.mark.skipif(not STRAINS.exists(), reason="the published strains are not beside the project")


@needs_strains
def test_a_small_study_writes_its_table(tmp_path):
    assert "| decisions | mu2 | unweighted | 1 of 1 |" in report("published", tmp_path, 1, True)


@needs_strains
def test_weighing_halves_what_is_missed_and_every_row_is_proven():
    data = build_dataset(published_strains(STRAINS), Recipe(samples_per_state=20), seed=1)
    for found in (decision_rows(data, 1, 2), state_rows(data, 1, 2)):
        rows = [row for row in found if row.task == "mu2"]
        assert all(row.solution.is_optimal for row in rows)
        plain, weighted = (next(row for row in rows if row.price == price) for price in (2.0, 11.0))
        assert weighted.train.missed_critical <= plain.train.missed_critical / 2
        assert weighted.train.false_alarm > plain.train.false_alarm
