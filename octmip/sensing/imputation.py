"""Imputation: the reading of a gauge that is known to have failed, from what the others say.

With mean m and covariance C of the training readings, missing gauges a and those at hand b, it is the conditional mean
of a normal distribution,

    x_a = m_a + C_ab C_bb^+ (x_b - m_b).

Which gauge has failed is what `octmip.monitor.Watch` tells.

Source: T. W. Anderson, An Introduction to Multivariate Statistical Analysis (2003), theorem 2.5.1.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Imputation:
    """Mean (n_features,) and covariance (n_features, n_features) of training readings.

    >>> gauges = Imputation.fit(np.array([[1.0, 2.0], [2.0, 4.0], [3.0, 6.1]]))
    >>> gauges.impute(np.array([[2.5, np.nan]])).round(1)
    array([[2.5, 5.1]])
    """

    mean: Floats
    covariance: Floats

    @classmethod
    def fit(cls, features: Floats) -> "Imputation":
        """Return the imputation learnt from features (n_samples, n_features) without missing readings."""
        return cls(features.mean(axis=0, dtype=np.float64), np.atleast_2d(np.cov(features, rowvar=False)))

    def impute(self, features: Floats) -> Floats:
        """Return features (n, n_features) with every NaN replaced; a row without any reading becomes the mean.

        Raises
        ------
        DataError
            the features have another number of columns.
        """
        if features.ndim != 2 or features.shape[1] != len(self.mean):
            raise DataError(f"features has shape {features.shape}; expected (n, {len(self.mean)}); give every feature")
        out, is_missing = features.copy(), np.isnan(features)
        patterns, of_row = np.unique(is_missing, axis=0, return_inverse=True)
        for k, gone in enumerate(patterns):
            if not gone.any():
                continue
            rows = np.flatnonzero(of_row.ravel() == k)
            slope = self.covariance[np.ix_(gone, ~gone)] @ np.linalg.pinv(self.covariance[np.ix_(~gone, ~gone)])
            known = features[np.ix_(rows, ~gone)] - self.mean[~gone]
            out[np.ix_(rows, gone)] = self.mean[gone] + known @ slope.T
        return out
