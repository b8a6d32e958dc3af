"""The reading of a failed gauge, imputed."""

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.sensing import Imputation


def test_filling_is_the_regression_on_the_others():
    rng = np.random.default_rng(3)
    means = 500.0 + np.outer(np.arange(4) * 60.0, np.linspace(1.0, 0.5, 8))
    readings = means[rng.integers(0, 4, 400)] + rng.normal(0, 8.0, (400, 8))
    imputation = Imputation.fit(readings)
    gap = readings.copy()
    gap[:, 2] = np.nan
    others = np.delete(readings, 2, axis=1)
    design = np.column_stack([np.ones(len(others)), others])
    slope, *_ = np.linalg.lstsq(design, readings[:, 2], rcond=None)
    assert np.allclose(imputation.impute(gap)[:, 2], design @ slope)
    assert np.allclose(imputation.impute(np.full((1, 8), np.nan)), readings.mean(axis=0))
    assert (imputation.impute(readings) == readings).all()
    with pytest.raises(DataError, match=r"\(400, 3\); expected \(n, 8\)"):
        imputation.impute(readings[:, :3])
