"""The inference about one linear model: every set of candidates is fitted once, under the errors of its signatures.

These errors are the misfit that a large effect leaves although its name is right. A signature comes from a model: each
gauge's part of it is known to some per cent, and where an effect may act anywhere its places are samples of a
continuum. So a set of candidates j at sizes theta_j is judged under the covariance

    C = C0 + sum_j theta_j^2 (e^2 s_j^2 (A_j A_j') o R + BETWEEN^2 sum_k (c_k S_k - S_j) (c_k S_k - S_j)'),

with s_j the effect's own error, A_j the size of S_j at and about each gauge (where a signature changes its sign it is
no better known than beside), R the correlation of errors (of one gauge, smooth along the structure, and of one kind of
reading: the same at all loads, along each load and bent over it; o multiplies entry by entry), k the nearest places and
c_k the best scale. One scalar e says how good the twin's signatures are; it is summed over `LEVELS`. What grows with an
effect is thus no reason for a second one.
Source: Kennedy and O'Hagan (2001), J. R. Statist. Soc. B 63, section 2 (code inadequacy as a Gaussian of its own);
the sizes are plugged in (empirical Bayes), which for a large effect is exact to the order of their relative error.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from octmip.gap.inference.confounding import VISIBLE
from octmip.gap.inference.evidence import Fit, Members, alike, fits_of, mixed
from octmip.gap.inference.linear_model import LinearModel
from octmip.gap.inference.states import distance, highest, log_box, moved_states
from octmip.gap.inference.whitening import Whitening
from octmip.twin import amounts_of

Floats = NDArray[np.float64]

LEVELS: Mapping[float, float] = {0.0: 0.2, 0.3: 0.4, 1.0: 0.4}
"""Factors on the errors of all signatures of a set, with their probabilities. A twin may be exact; at 3 what no library
holds is named."""
BETWEEN = 0.3
"""Sd of the weight of a neighbouring place: the truth lies anywhere up to half way to it."""
NEARBY = 0.1
"""Length over which the size of a signature is taken, as a share of the structure's extent."""
SMOOTH = 0.5
"""Share of the variance of an error that is smooth along the structure."""
FAINT = 2.0
"""Standard deviations up to which an effect is too faint for its signature's errors to count."""
ALIKE = 0.5
"""Share of its squared length that a neighbour must have in common with the place."""


def is_uncertain(model: LinearModel, members: Members) -> bool:
    """Return whether some signature of a set may be wrong."""
    chosen = [model.inputs.candidates[j] for j in members]
    return any(one.signature_errors.any() or one.n_between > 0 for one in chosen)


def correlation(model: LinearModel) -> Floats:
    """Return R (n, n). One kind of reading alone, wrong as a whole, is a wrong size: that is left out."""
    kind, gauge = model.inputs.frame.kind, model.gauge
    first, *bent = [np.outer(course, course) for course in _courses(model)]
    over_loads = np.sum([np.zeros_like(first), *bent], axis=0)
    common = over_loads + first if kind.max() > 0 else over_loads
    same_kind = kind[gauge][:, None] == kind[gauge]
    own = np.asarray(gauge[:, None] == gauge, dtype=np.float64)
    if model.inputs.twin.gauge_positions is not None:
        own = (1.0 - SMOOTH) * own + SMOOTH * same_kind * model.inputs.difference.smooth[np.ix_(gauge, gauge)]
    return np.asarray(own * (first + over_loads) + same_kind * common)


def _courses(model: LinearModel) -> list[Floats]:
    """Return the courses (n,) of an error over the readings: the same in all, and along each load that varies."""
    applied = np.array([amounts_of(load) for load in model.loads])
    found = [np.ones(model.n)]
    for column in applied.T:
        half = np.ptp(column) / 2.0
        if half > 0.0:
            x = (column - column.min()) / half - 1.0
            found += [x, 1.5 * x**2 - 0.5] if len(np.unique(column)) > 2 else [x]
    return found


def own_error(model: LinearModel, candidate: int) -> Floats:
    """Return s_j A_j (n,): what a signature may be wrong by at each reading."""
    inputs, gauge, own = model.inputs, model.gauge, model.signatures[:, candidate]
    share = np.broadcast_to(inputs.candidates[candidate].signature_errors, len(inputs.twin.gauges))
    wrong = share[list(inputs.order)][gauge]
    if inputs.twin.gauge_positions is None or not wrong.any():
        return np.asarray(wrong * own)
    kind = inputs.frame.kind
    near = inputs.frame.along(NEARBY) * (kind[:, None] == kind)
    squares = np.zeros((len(inputs.averages), len(inputs.order)))
    squares[model.average, gauge] = own**2
    about = np.sqrt(squares @ near / near.sum(axis=0))[model.average, gauge]
    return np.asarray(wrong * np.maximum(np.abs(own), about))


def between(model: LinearModel, candidate: int) -> Floats:
    """Return BETWEEN (c_k S_k - S_j) (n, r) of the neighbours k of a candidate j."""
    if not model.inputs.candidates[candidate].n_between:
        return np.zeros((model.n, 0))
    near, own = neighbours(model, candidate), model.signatures
    return np.asarray(BETWEEN * (scales_of(model, near, candidate) * own[:, near] - own[:, [candidate]]))


def neighbours(model: LinearModel, candidate: int) -> list[int]:
    """Return the places of the same effect whose signatures are most like the candidate's, most alike first."""
    name = model.inputs.priors.name
    others = np.flatnonzero((name == name[candidate]) & (np.arange(len(name)) != candidate))
    common = model.white[:, others].T @ model.white[:, candidate]
    share = common * np.abs(common) / np.maximum(model.lengths[others] * model.lengths[candidate], 1e-300)
    near = np.argsort(-share, kind="stable")[: model.inputs.candidates[candidate].n_between]
    return [int(k) for k in others[near[share[near] > ALIKE]]]


def scales_of(model: LinearModel, near: Sequence[int], candidate: int) -> Floats:
    """Return c_k (n_near,), the best scale of each neighbour k as an imitation of a candidate."""
    return np.asarray(model.white[:, near].T @ model.white[:, candidate] / model.lengths[near])


USUAL_LEVEL = float(np.sqrt(sum(share * level**2 for level, share in LEVELS.items())))
"""Root mean square of the levels of errors before any reading."""


Reduced = tuple[Floats, Floats, float]
"""Of a set of candidates: Gram matrix (m, m), projections (m,), and the log of p0 under their errors over p0."""


class Inference:
    """Fits of sets of a linear model's candidates; each is made once and kept.

    Attributes
    ----------
    model
        the linear model.
    """

    def __init__(self, model: LinearModel) -> None:
        self.model = model
        self._plain: dict[Members, Fit] = {}
        self._fits: dict[Members, Fit] = {}
        self._traces: dict[int, tuple[Floats, Floats]] = {}
        self._allowing: dict[Members, Inference] = {}
        self._identifiable: dict[Members, Members] = {}
        self._stands: dict[Members, tuple[float, float]] = {}

    @cached_property
    def _most(self) -> Floats:
        return highest(self.model.inputs)

    @cached_property
    def _correlation(self) -> Floats:
        return correlation(self.model)

    def fit(self, members: Sequence[int]) -> Fit:
        """Return the evidence of a set, summed over scales of its sizes and levels of its errors, and its sizes."""
        return self.fits([tuple(members)])[0]

    def fits(self, sets: Sequence[Members]) -> list[Fit]:
        """Return `fit` of every set: one by one they cost several times as much."""
        new = [members for members in dict.fromkeys(sets) if members not in self._fits]
        plain = dict(zip(new, self.plain(new), strict=True))
        uncertain = [m for m in new if is_uncertain(self.model, m) and self._alone(plain[m]).max() > FAINT]
        self._fits |= plain
        for group in alike(self.model.inputs.priors, uncertain):
            self._fits.update(zip(group, self._over_levels(group), strict=True))
        return [self._fits[members] for members in sets]

    def plain(self, sets: Sequence[Members]) -> list[Fit]:
        """Return the fit of every set as if its signatures had no errors."""
        new = [members for members in dict.fromkeys(sets) if members not in self._plain]
        for group in alike(self.model.inputs.priors, new):
            self._plain.update(zip(group, self._fitted(group, [self._reduced(m, None) for m in group]), strict=True))
        return [self._plain[members] for members in sets]

    def _alone(self, fit: Fit) -> Floats:
        """Return by how many standard deviations each member (n_members,) of a set moves the readings alone."""
        return np.asarray(np.abs(fit.size) * np.sqrt(self.model.lengths[list(fit.members)]))

    def is_idle(self, members: Members) -> bool:
        """Return whether one effect is too faint to be seen even if its signature has no errors, which only blur it."""
        return len(members) == 1 and float(self._alone(self.plain([members])[0])[0]) < VISIBLE

    def _over_levels(self, group: Sequence[Members]) -> list[Fit]:
        """Return the fits of sets summed over the levels of their errors, these of the sizes without errors."""
        by_set = [[self._reduced(m, e) for e in self._errors(m, self._plain[m].size, *LEVELS)] for m in group]
        fits = [self._fitted(group, at_level) for at_level in zip(*by_set, strict=True)]
        logs = np.array([[shift for _, _, shift in levels] for levels in by_set]) + np.log([*LEVELS.values()])
        return [mixed(own, log, list(LEVELS)) for own, log in zip(zip(*fits, strict=True), logs, strict=True)]

    def _fitted(self, group: Sequence[Members], reduced: Sequence[Reduced]) -> list[Fit]:
        gram, projection = np.array([part[0] for part in reduced]), np.array([part[1] for part in reduced])
        return fits_of(self.model.inputs.priors, group, gram, projection)

    def _reduced(self, members: Members, error: Floats | None) -> Reduced:
        """Return the Gram matrix (m, m) and projections (m,) of a set under an added covariance, and log p0' / p0."""
        model, index = self.model, list(members)
        if error is None:
            white = model.white[:, index]
            return white.T @ white, model.projection[index], 0.0
        whitening = Whitening.of(model.covariance + error)
        white = whitening.of_columns(np.column_stack([model.signatures[:, index], model.residual]))
        columns, left = white[:, :-1], white[:, -1]
        shift = 0.5 * float(model.left @ model.left - left @ left) - whitening.log_volume + model.whitening.log_volume
        return columns.T @ columns, columns.T @ left, shift

    def _errors(self, members: Members, size: Floats, *levels: float) -> list[Floats | None]:
        """Return the covariance (n, n) of the errors of some signatures at these sizes by level; None of none."""
        if not is_uncertain(self.model, members):
            return [None] * len(levels)
        own, beside = zip(*(self._errors_of(j) for j in members), strict=True)
        wrong = np.array(own).T * size
        root = np.hstack([theta * columns for columns, theta in zip(beside, size, strict=True)])
        of_gauges, of_places = (wrong @ wrong.T) * self._correlation, root @ root.T
        return [level**2 * of_gauges + of_places if level or root.size else None for level in levels]

    def _errors_of(self, candidate: int) -> tuple[Floats, Floats]:
        """Return what one signature may be wrong by at each reading, and what lies between it and its neighbours."""
        if candidate not in self._traces:
            self._traces[candidate] = own_error(self.model, candidate), between(self.model, candidate)
        return self._traces[candidate]

    def stand(self, members: Members) -> tuple[float, float]:
        """Return how far the states that a set prefers lie from the model's, and its log evidence inside the box."""
        if members not in self._stands:
            away = distance(self.moved(members), self.model.states) if self.model.inputs.groups else 0.0
            self._stands[members] = away, self.model.log_none + self.fit(members).log_factor + self.log_box(members)
        return self._stands[members]

    def moved(self, members: Members) -> Floats:
        """Return the states (n_cells, n_parameters) that a set prefers."""
        return moved_states(self.model, self.fit(members), self._most)

    def log_box(self, members: Members) -> float:
        """Return the log of the share of a set's states that are possible."""
        return log_box(self.model, self.fit(members), self._most)

    def errors(self, members: Members) -> Floats | None:
        """Return the covariance (n, n) of a set's errors at the level that bears the readings best; None of none."""
        own = self.fit(members)
        return self._errors(members, own.size, own.level)[0]

    def error_of(self, candidate: int, size: float) -> Floats | None:
        """Return the covariance (n, n) of the errors of one signature at a size, in full; None of none."""
        return self._errors((candidate,), np.array([size]), max(LEVELS))[0]

    def allowing(self, members: Members) -> "Inference":
        """Return the inference under the errors of a set's signatures; itself, with all that it keeps, of none."""
        if members not in self._allowing:
            error = self.errors(members)
            self._allowing[members] = self if error is None else Inference(self.model.with_covariance(error))
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
            gram = self._reduced(members, self._errors(beside, size[others], level)[0])[0]
            left.append(1.0 / np.linalg.inv(gram + precision)[k, k] - precision[k, k])  # what the others leave
        return np.asarray(np.abs(size) * np.sqrt(np.maximum(left, 0.0)))

    def identifiable(self, members: Members) -> Members:
        """Return the members at `VISIBLE` or more from their own absence, the faintest removed one at a time."""
        if members not in self._identifiable:
            self._identifiable[members] = self._without_idle(members)
        return self._identifiable[members]

    def visible(self, members: Members) -> Floats:
        """Return how far members are from their own absence; infinite of a constant that is open.

        What a change of that stands out of is a prior, no noise.
        """
        inputs = self.model.inputs
        is_open = [inputs.candidates[j].name in inputs.open for j in members]
        return np.where(is_open, np.inf, self.visibilities(members))

    def _without_idle(self, members: Members) -> Members:
        while members:
            visible = self.visible(members)
            if np.isfinite(visible).all() and self.is_idle(members):
                return ()
            faintest = int(np.argmin(visible))
            if visible[faintest] >= VISIBLE:
                break
            members = (*members[:faintest], *members[faintest + 1 :])
        return members


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A hypothesis with its weight and where it was judged.

    Attributes
    ----------
    members
        candidates.
    has_unknown
        whether the unknown acts beside them.
    log_weight
        log of prior times evidence.
    inference
        in which it was judged.
    words
        what the unknown looks like.
    probability
        posterior probability, once all hypotheses are known.
    """

    members: Members
    has_unknown: bool
    log_weight: float
    inference: Inference
    words: str = ""
    probability: float = 0.0

    @property
    def model(self) -> LinearModel:
        """The linear model about the states at which it was judged."""
        return self.inference.model

    @property
    def fit(self) -> Fit:
        """The sizes."""
        return self.inference.fit(self.members)

    @property
    def allowing(self) -> LinearModel:
        """The linear model under the errors of the hypothesis' own signatures."""
        return self.inference.allowing(self.members).model

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of its effects, each once."""
        candidates = self.model.inputs.candidates
        return tuple(dict.fromkeys(candidates[j].name for j in self.members))

    def times(self, log_factor: float, probability: float = 0.0) -> "Judged":
        """Return the hypothesis with its weight multiplied, and with a probability."""
        weight = self.log_weight + log_factor  # not by `replace`: there are thousands
        return Judged(self.members, self.has_unknown, weight, self.inference, self.words, probability)
