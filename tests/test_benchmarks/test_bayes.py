"""The Bayes limit against cases that have a closed form."""

import numpy as np
import pytest
from scipy.stats import norm

from benchmarks.uav.bayes import bayes_limit


def test_two_states_err_at_the_normal_tail_of_half_their_distance() -> None:
    means = np.array([[0.0, 0.0], [3.0, 4.0]])  # 5 apart
    limit = bayes_limit(means, np.array([0.0, 20.0]), 2.0, np.random.default_rng(1), n_draws=50_000)
    expected = norm.cdf(-5.0 / 2 / 2.0)
    assert limit.error_rate == pytest.approx(expected, abs=4 * limit.error_rate_se)
    assert limit.mae == pytest.approx(20 * expected, abs=4 * limit.mae_se)


def test_readings_without_information_leave_the_median() -> None:
    means = np.zeros((5, 3))
    levels = np.array([0.0, 20.0, 40.0, 60.0, 80.0])
    limit = bayes_limit(means, levels, 1.0, np.random.default_rng(2), n_draws=2_000)
    assert limit.error_rate == pytest.approx(0.8)
    assert limit.mae == pytest.approx(24.0)  # mean distance of 0, 20, 40, 60, 80 from their median
