"""The inference about one linear model: every set of candidates is fitted once, under the errors of its signatures."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from octmip.gap.inference.confounding import VISIBLE
from octmip.gap.inference.evidence import Fit, Members, alike, fits_of, mixed
from octmip.gap.inference.linear_model import LinearModel, with_covariance, with_signatures
from octmip.gap.inference.signature_error import LEVELS, between, correlation, is_uncertain, own_error, propagated

Floats = NDArray[np.float64]

USUAL_LEVEL = float(np.sqrt(sum(share * level**2 for level, share in LEVELS.items())))
"""Root mean square of the levels of errors before any reading."""


class Inference:
    """Fits of sets of a linear model's candidates; each is made once and kept.

    Attributes
    ----------
    model
        the linear model.
    """

    def __init__(self, model: LinearModel) -> None:
        self.model = model
        self._fits: dict[Members, Fit] = {}
        self._between: dict[int, Floats] = {}
        self._allowing: dict[Members, Inference] = {}
        self._identifiable: dict[Members, Members] = {}

    @cached_property
    def _correlation(self) -> Floats:
        return correlation(self.model)

    def fit(self, members: Sequence[int]) -> Fit:
        """Return the evidence of a set, summed over scales of its sizes and levels of its errors, and its sizes."""
        return self.fits([tuple(members)])[0]

    def fits(self, sets: Sequence[Members]) -> list[Fit]:
        """Return `fit` of every set: one by one they cost several times as much."""
        new = [members for members in dict.fromkeys(sets) if members not in self._fits]
        for group in alike(self.model.inputs.priors, new):
            self._fits.update(zip(group, self._under(group, [None] * len(group))[0], strict=True))
        uncertain = [members for members in new if is_uncertain(self.model, members)]
        for group in alike(self.model.inputs.priors, uncertain):
            self._fits.update(zip(group, self._at_level(group, 1.0)[0], strict=True))
            self._fits.update(zip(group, self._over_levels(group), strict=True))
        return [self._fits[members] for members in sets]

    def _over_levels(self, group: Sequence[Members]) -> list[Fit]:
        """Return the fits of sets summed over the levels of their errors, which are as large as their last sizes."""
        by_level = [(*self._at_level(group, level), np.log(share)) for level, share in LEVELS.items()]
        logs = np.array([shifts + log_share for _, shifts, log_share in by_level]).T
        return [mixed([fits[k] for fits, _, _ in by_level], own, list(LEVELS)) for k, own in enumerate(logs)]

    def _at_level(self, group: Sequence[Members], level: float) -> tuple[list[Fit], Floats]:
        return self._under(group, [self._errors(m, self._fits[m].size, level) for m in group])

    def _under(self, group: Sequence[Members], errors: Sequence[Floats | None]) -> tuple[list[Fit], Floats]:
        """Return the fits of sets under added covariances, and what these change of the log of no effect."""
        parts = [self._reduced(members, error) for members, error in zip(group, errors, strict=True)]
        gram, projection = np.array([part[0] for part in parts]), np.array([part[1] for part in parts])
        return fits_of(self.model.inputs.priors, group, gram, projection), np.array([part[2] for part in parts])

    def _reduced(self, members: Members, error: Floats | None) -> tuple[Floats, Floats, float]:
        """Return the Gram matrix (m, m) and projections (m,) of a set under an added covariance, and log p0' / p0."""
        model, own = self.model, propagated(self.model, members)
        if error is None:
            white = model.whiten(own)
            return white.T @ white, white.T @ model.whitened.residual, 0.0
        factor = linalg.cholesky(model.covariance + error, lower=True, overwrite_a=True, check_finite=False)
        stacked = np.column_stack([own, model.residual])
        white = linalg.solve_triangular(factor, stacked, lower=True, overwrite_b=True, check_finite=False)
        columns, left = white[:, :-1], white[:, -1]
        before = model.whitened.residual
        shift = 0.5 * float(before @ before - left @ left)
        shift -= float(np.log(np.diag(factor)).sum() - np.log(np.diag(model.factor)).sum())
        return columns.T @ columns, columns.T @ left, shift

    def _errors(self, members: Members, size: Floats, level: float) -> Floats | None:
        """Return the covariance (n, n) of the errors of some signatures at these sizes; None of none."""
        model, n = self.model, self.model.n
        if not is_uncertain(model, members):
            return None
        sized = list(zip(members, size.tolist(), strict=True))
        root = np.hstack([np.zeros((n, 0)), *(theta * self._beside(j) for j, theta in sized)])
        if not level and not root.shape[1]:
            return None
        parts = np.array([theta * own_error(model, j) for j, theta in sized]).reshape(-1, n).T
        return np.asarray(level**2 * (parts @ parts.T) * self._correlation + root @ root.T)

    def _beside(self, candidate: int) -> Floats:
        if candidate not in self._between:
            self._between[candidate] = between(self.model, candidate)
        return self._between[candidate]

    def errors(self, members: Members) -> Floats | None:
        """Return the covariance (n, n) of a set's errors at the level that bears the readings best; None of none."""
        own = self.fit(members)
        return self._errors(members, own.size, own.level)

    def error_of(self, candidate: int, size: float) -> Floats | None:
        """Return the covariance (n, n) of the errors of one signature at a size, in full; None of none."""
        return self._errors((candidate,), np.array([size]), max(LEVELS))

    def allowing(self, members: Members) -> "Inference":
        """Return the inference under the errors of a set's signatures, which are propagated through its members.

        Itself, with all that it keeps, where nothing changes.
        """
        if members not in self._allowing:
            own, error = self.model, self.errors(members)
            moved = propagated(own, members)
            if not np.array_equal(moved, own.signatures[:, list(members)]):
                own = with_signatures(own, members, moved)
            own = own if error is None else with_covariance(own, error)
            self._allowing[members] = self if own is self.model else Inference(own)
        return self._allowing[members]

    def visibilities(self, members: Members) -> Floats:
        """Return d' (n_members,) of each member from its own absence, the others refitted, under the others' errors.

        These count at `USUAL_LEVEL` or more, even where a lower level fits best: beside a large effect a small one may
        be no more than what the large one's signature is wrong by. A member's own errors grow with its size and vanish
        with it: they blur how large it is, not whether it acts.
        """
        fit = self.fit(members)
        size, level = fit.size, max(fit.level, USUAL_LEVEL)
        precision = np.diag((3.0 * self.model.inputs.priors.sd[list(members)]) ** -2)
        left = []
        for k in range(len(members)):
            others = np.arange(len(members)) != k
            beside = tuple(members[i] for i in np.flatnonzero(others))
            gram = self._reduced(members, self._errors(beside, size[others], level))[0]
            cross = gram[others, k]
            within = (gram + precision)[np.ix_(others, others)]
            left.append(gram[k, k] - cross @ np.linalg.solve(within, cross))
        return np.asarray(np.abs(size) * np.sqrt(np.maximum(left, 0.0)))

    def identifiable(self, members: Members) -> Members:
        """Return the members at `VISIBLE` or more from their own absence, the faintest removed one at a time."""
        if members not in self._identifiable:
            self._identifiable[members] = self._without_idle(members)
        return self._identifiable[members]

    def _without_idle(self, members: Members) -> Members:
        while members:
            visible = self.visibilities(members)
            faintest = int(np.argmin(visible))
            if visible[faintest] >= VISIBLE:
                break
            members = (*members[:faintest], *members[faintest + 1 :])
        return members
