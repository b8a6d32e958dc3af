"""A failed gauge: detection with its rate, and the reading imputed."""

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.sensing import FaultDetector, Imputation


def gauges(n: int = 400, n_gauges: int = 8) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return readings of redundant gauges, levels of damage, and the gauges' mean at each level."""
    rng = np.random.default_rng(3)
    means = 500.0 + np.outer(np.arange(4) * 60.0, np.linspace(1.0, 0.5, n_gauges))
    level = rng.integers(0, 4, n)
    return means[level] + rng.normal(0, 8.0, (n, n_gauges)), level, means


def test_filling_is_the_regression_on_the_others():
    readings, _, _ = gauges()
    imputation = Imputation.fit(readings)
    gap = readings.copy()
    gap[:, 2] = np.nan
    others = np.delete(readings, 2, axis=1)
    design = np.column_stack([np.ones(len(others)), others])
    slope, *_ = np.linalg.lstsq(design, readings[:, 2], rcond=None)
    assert np.allclose(imputation.impute(gap)[:, 2], design @ slope)
    assert np.allclose(imputation.impute(np.full((1, 8), np.nan)), readings.mean(axis=0))
    assert (imputation.impute(readings) == readings).all()


@pytest.fixture(scope="module")
def detector() -> FaultDetector:
    """Return a detector over the redundant gauges."""
    return FaultDetector(gauges()[2], 8.0, tuple(f"g{j}" for j in range(8)))


def test_the_false_alarm_rate_is_the_stated_one(detector):
    healthy = detector.draw(20_000, np.random.default_rng(5))
    assert detector.is_alarm(healthy).mean() == pytest.approx(0.01, abs=0.003)  # four standard errors


def test_the_surprise_is_the_predictive_density(detector):
    reading = detector.draw(1, np.random.default_rng(7))[0]
    z = (reading - detector.means) / 8.0
    density = np.exp(-0.5 * z**2) / np.sqrt(2 * np.pi)
    others = np.delete(density, 3, axis=1).prod(axis=1)
    predictive = (others / others.sum()) @ density[:, 3]
    assert detector.surprise(reading[None])[0, 3] == pytest.approx(-np.log(predictive))


def test_a_named_gauge_is_taken_out_and_a_missing_one_is_no_alarm(detector):
    readings = detector.draw(50, np.random.default_rng(8))
    readings[:, 4] = 0.0
    assert np.isnan(detector.without_failed(readings)[:, 4]).all()
    gap = detector.draw(500, np.random.default_rng(9))
    gap[:, 4] = np.nan
    assert detector.is_alarm(gap).mean() < 0.04
    with pytest.raises(DataError):
        detector.surprise(readings[:, :3])
