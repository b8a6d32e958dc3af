"""Normal residuals in units of the Cholesky factor of their covariance: C = L L', white = L^-1 columns.

The log density of a residual r is -(|L^-1 r|^2 + log det 2 pi C) / 2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError
from scipy.linalg.lapack import dpotrf, dtrtrs

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Whitening:
    """A covariance by its lower Cholesky factor (n, n)."""

    factor: Floats

    @classmethod
    def of(cls, covariance: Floats) -> "Whitening":
        """Return that of a covariance (n, n).

        Raises
        ------
        LinAlgError
            it is not positive definite.
        """
        factor, info = dpotrf(covariance, lower=1)  # scipy's own functions take twice as long for a hundred rows
        if info:
            raise LinAlgError(f"the {info}-th leading minor of a covariance is not positive definite")
        factor.flags.writeable = False
        return cls(factor)

    def of_columns(self, columns: Floats) -> Floats:
        """Return columns (n,) or (n, k) whitened."""
        return np.asarray(dtrtrs(self.factor, columns, lower=1)[0]) if columns.size else np.zeros(columns.shape)

    @property
    def log_volume(self) -> float:
        """Half the log determinant of the covariance."""
        return float(np.log(np.diag(self.factor)).sum())

    def log_density(self, white: Floats) -> float:
        """Return the log density of a residual that is whitened (n,)."""
        return -0.5 * float(white @ white) - self.log_volume - 0.5 * len(white) * float(np.log(2 * np.pi))


def log_normal(covariance: Floats, residual: Floats) -> float:
    """Return the log density of a normal residual (n,)."""
    whitening = Whitening.of(covariance)
    return whitening.log_density(whitening.of_columns(residual))
