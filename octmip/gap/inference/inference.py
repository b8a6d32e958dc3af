"""The inference about one linear model: every set of candidates is fitted and judged once."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from octmip.gap.inference.confounding import VISIBLE
from octmip.gap.inference.evidence import Fit, Members, alike, fits_of, group_fits
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.signature_error import (
    Judgement,
    Reduced,
    SignatureError,
    error_of,
    propagated_signatures,
    propagates,
    reduced,
    weighed_errors,
    with_errors,
    with_propagated,
)

Floats = NDArray[np.float64]

PASSES = 2
"""Fits of the sizes, each under the errors of the one before."""


class Inference:
    """Fits and judgements of sets of a linear model's candidates; each is made once and kept.

    Sets are fitted together where they can be: one by one they cost several times as much.

    Attributes
    ----------
    model
        the linear model.
    """

    def __init__(self, model: LinearModel) -> None:
        self.model = model
        self._fits: dict[Members, Fit] = {}
        self._propagated: dict[Members, Floats] = {}
        self._errors: dict[int, SignatureError] = {}
        self._judgements: dict[Members, Judgement] = {}
        self._allowing: dict[Members, Inference] = {}
        self._identifiable: dict[Members, Members] = {}

    def fit(self, members: Sequence[int]) -> Fit:
        """Return the exact evidence of a set, summed over the scale mixture, with the moments of the sizes."""
        return self.fits([tuple(members)])[0]

    def fits(self, sets: Sequence[Members]) -> list[Fit]:
        """Return `fit` of every set."""
        new = [members for members in dict.fromkeys(sets) if members not in self._fits]
        for group in alike(self.model.inputs.priors, new):
            self._fits.update(zip(group, group_fits(self.model, group), strict=True))
        return [self._fits[members] for members in sets]

    def judge(self, sets: Sequence[Members]) -> list[Judgement]:
        """Return every set under the errors of its own signatures."""
        new = [members for members in dict.fromkeys(sets) if members not in self._judgements]
        for members, own in zip(new, self.fits(new), strict=True):
            self._judgements[members] = Judgement(own, 0.0, np.zeros((self.model.n, 0)))
        for _ in range(PASSES if new else 0):  # most sets are asked for again
            self._judge_again(new)
        return [self._judgements[members] for members in sets]

    def _judge_again(self, sets: Sequence[Members]) -> None:
        """Judge sets under errors as large as their sizes were fitted last."""
        found = {members: self._errors_of(members, range(len(members))) for members in sets}
        roots = {m: own for m, own in found.items() if own[0].shape[1] or own[1] or propagates(self.model, m)}
        priors = self.model.inputs.priors
        for group in alike(priors, list(roots)):
            parts = [self._reduced(members, roots[members][0]) for members in group]
            gram, projection = np.array([p.gram for p in parts]), np.array([p.projection for p in parts])
            for members, own, part in zip(group, fits_of(priors, group, gram, projection), parts, strict=True):
                root, beside = roots[members]
                self._judgements[members] = Judgement(own, part.log_shift + beside, root)

    def _errors_of(self, members: Members, of: Sequence[int]) -> tuple[Floats, float]:
        """Return the errors of some members of a set, given by position, and what all others weigh beside them."""
        size = self._judgements[members].fit.size
        left = self.model.whitened.residual - self._signatures(members) @ size
        return weighed_errors(size[list(of)], [self._error(members[k]) for k in of], left, self.model.inputs.frame.kind)

    def _signatures(self, members: Members) -> Floats:
        if members not in self._propagated:
            self._propagated[members] = propagated_signatures(self.model, members)
        return self._propagated[members]

    def _reduced(self, members: Members, root: Floats) -> Reduced:
        return reduced(self.model, self._signatures(members), root)

    def _error(self, candidate: int) -> SignatureError:
        if candidate not in self._errors:
            self._errors[candidate] = error_of(self.model, candidate)
        return self._errors[candidate]

    def allowing(self, members: Members) -> "Inference":
        """Return the inference under the errors of a set's signatures, which are propagated through its members.

        Itself, with all that it keeps, where nothing changes.
        """
        if members not in self._allowing:
            root = self.judge([members])[0].root
            own = with_propagated(self.model, members)
            own = with_errors(own, root) if root.shape[1] else own
            self._allowing[members] = self if own is self.model else Inference(own)
        return self._allowing[members]

    def visibilities(self, members: Members) -> Floats:
        """Return d' (n_members,) of each member from its own absence, the others refitted, under the others' errors.

        A member's own errors grow with its size and vanish with it: they blur how large it is, not whether it acts.
        """
        size = self.judge([members])[0].fit.size
        precision = np.diag((3.0 * self.model.inputs.priors.sd[list(members)]) ** -2)
        left = []
        for k in range(len(members)):
            others = np.arange(len(members)) != k
            gram = self._reduced(members, self._errors_of(members, np.flatnonzero(others).tolist())[0]).gram
            cross = gram[others, k]
            within = (gram + precision)[np.ix_(others, others)]
            left.append(gram[k, k] - cross @ np.linalg.solve(within, cross))
        return np.asarray(np.abs(size) * np.sqrt(np.maximum(left, 0.0)))

    def identifiable(self, members: Members) -> Members:
        """Return the members that stand d' = 4 above the noise, the faintest removed one at a time."""
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
