"""The sensing study runs, and its figures hang together."""

import numpy as np
import pytest

from benchmarks.uav.sensing import budget, placement
from benchmarks.uav.sensing import readings as source
from benchmarks.uav.sensing.readings import candidate_wing, installed, mean_strains, readings
from femlib.wing import uav_wing


@pytest.fixture(scope="module", autouse=True)
def _coarse_wing():
    """The wing on a coarse mesh: what is tested here holds on any."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(source, "uav_wing", lambda candidates: uav_wing(candidates=candidates, refinement=0.35))
        _forget()
        yield
    _forget()


def _forget():
    candidate_wing.cache_clear()
    mean_strains.cache_clear()


def test_a_small_study_of_budgets_writes_its_tables(tmp_path):
    text = budget.report("wing", tmp_path, 1, True)
    assert text.count("|") > 50
    assert "True" in text


def test_a_small_placement_has_every_choice_and_its_picture(tmp_path):
    text = placement.report("wing", tmp_path, 1, True)
    assert all(choice in text for choice in placement.CHOICES)
    assert (tmp_path / "placement.png").exists()
    assert "no candidates" in placement.report("published", tmp_path, 1, True)


def test_the_wing_offers_67_candidates_and_20_of_them_are_installed():
    data = readings("wing", 0, True)
    assert len(data.gauges) == 67
    assert len(installed(data)) == 20
    assert len(candidate_wing().gauges.names) == 82


def test_slopes_of_the_readings_are_those_of_the_mean_strains():
    data = readings("wing", 0, True)
    slopes = placement.sensitivities(data)
    assert slopes.shape == (25, 67, 2)
    means = mean_strains("wing")
    grid = means.strain_microstrain[:, means.is_usable].reshape(5, 5, -1) / means.load_factor
    assert np.allclose(slopes[12, :, 1], (grid[2, 3] - grid[2, 1]) / 2)
