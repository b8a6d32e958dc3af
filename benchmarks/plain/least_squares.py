"""The plainest rival: least squares by scipy for no, one and two effects, BIC between them, a chi-squared of the rest.

    chi2 = sum (mean - F(sizes) - difference)^2 / variance,    BIC = chi2 + k log n

F, difference and variance are those of the plain selector, and what effects change is wrong by `ERROR` of itself in
the rest. The least BIC names the effects; where a chi-squared of n - k degrees exceeds the least of all in less than
`FITS` of all cases, nothing explains.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import chi2

from benchmarks.plain.asked import Asked, Member
from femlib.arrays import FloatArray
from octmip.gap import Campaign
from octmip.gap.inference.candidates import bounds_of
from octmip.twin import Twin

FITS, ERROR, N_PAIRS, WIDE, Z90 = 0.01, 0.03, 24, 3.0, 1.645
"""Chance of the rest; error of a change; pairs that are fitted; sds in which a size is looked for; those of 90 %."""


@dataclass(frozen=True)
class Fitted:
    """Members, their sizes with 90 % intervals (k, 3), and the whitened rest (n,)."""

    members: tuple[Member, ...]
    sizes: FloatArray
    rest: FloatArray

    @property
    def chi2(self) -> float:
        """Return the squares of the rest."""
        return float(self.rest @ self.rest)

    @property
    def bic(self) -> float:
        """Return the criterion."""
        return self.chi2 + len(self.members) * float(np.log(len(self.rest)))

    @property
    def chance(self) -> float:
        """Return the chance of as great a rest."""
        return float(chi2.sf(self.chi2, max(1, len(self.rest) - len(self.members))))


def fits_of(campaign: Campaign, twin: Twin, run: Campaign) -> list[Fitted]:
    """Return the fits of no effect, of every single one and of the best with every other, the least criterion first."""
    asked = Asked.of(campaign, twin, run)
    members = asked.members
    none, singles = _fitted(asked, ()), [_fitted(asked, (one,)) for one in members]
    changes = np.array([none.rest - one.rest for one in singles])
    pairs = [(j, k) for j, k in combinations(range(len(members)), 2) if members[j][0] is not members[k][0]]
    left = [np.linalg.lstsq(changes[[j, k]].T, none.rest)[1].sum() or np.inf for j, k in pairs]
    best = [pairs[k] for k in np.argsort(left, kind="stable")[:N_PAIRS]]
    doubles = [_fitted(asked, (members[j], members[k])) for j, k in best]
    return sorted([none, *singles, *doubles], key=lambda fit: fit.bic)


def _fitted(asked: Asked, members: tuple[Member, ...]) -> Fitted:
    sd = np.array([effect.prior_sd for effect, _ in members])
    low, high = np.array([bounds_of(effect) for effect, _ in members]).reshape(-1, 2).T
    ends = np.maximum(low / np.maximum(sd, 1e-300), -WIDE), np.minimum(high / np.maximum(sd, 1e-300), WIDE)
    root = np.sqrt(asked.variance)

    def rest(shares: FloatArray) -> FloatArray:
        return np.asarray((asked.mean - asked.reading(members, shares * sd)) / root).ravel()

    if not members:
        return Fitted((), np.zeros((0, 3)), rest(np.zeros(0)))
    start = np.clip([e.prior_mean for e, _ in members] / sd, ends[0] + 1e-3, ends[1] - 1e-3)
    found = least_squares(rest, start, bounds=ends, diff_step=np.full(len(sd), 0.05), max_nfev=8)
    jacobian = np.asarray(found.jac)
    spread = np.sqrt(np.diag(np.linalg.pinv(jacobian.T @ jacobian)))
    sizes = np.stack([(found.x + z * spread) * sd for z in (0.0, -Z90, Z90)], axis=1)
    change = (asked.reading(members, found.x * sd) - asked.reading((), ())) / root
    return Fitted(members, sizes, np.asarray(found.fun) / np.sqrt(1.0 + (ERROR * change.ravel()) ** 2))
