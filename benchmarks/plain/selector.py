"""The plain selector: linear Gaussian evidence for each effect of a library, alone and in pairs.

    reading - twin - difference = sum_j size_j s_j + N x + noise,     size_j ~ N(mean_j, (k sd_j)^2), k = 1/3, 1, 3

in every gauge and cell (one test at one load). A signature s_j is wrong by a share of itself at each gauge, which adds
(share size_j)^2 s_j s_j^T to the covariance of that gauge; `N` holds nuisances. What no effect explains has a known
course over the cells and an unknown size at each gauge. A pair holds one of the twelve best single effects.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import logsumexp, ndtr

from benchmarks.plain.readings import Readings, readings_of, with_states
from femlib.arrays import FloatArray, IntArray
from octmip.gap import Campaign
from octmip.gap.diagnosis import library_of
from octmip.gap.effects import in_chain
from octmip.gap.twins import CachedTwin
from octmip.twin import Effect, Twin, amounts_of

PRIOR = {"none": 0.50, "single": 0.38, "pair": 0.07, "unknown": 0.04}
SCALES = (1 / 3, 1.0, 3.0)
SHARES = (0.01, 0.10)
"""Relative error of a signature of the measuring chain, and of the structure."""
UNKNOWN_SIZES = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Over the typical reading of a gauge."""
N_HEADS, N_EXACT = 12, 16
"""Single effects that are tried with all others; those whose signature is taken between 0 and the size found."""
AT_ONCE = 128
"""Sets whose products fit into the processor's cache."""
SEPARABLE, CREDIBLE, Z90 = 3.0, 0.95, 1.645
IDLE = 1e-4
"""Probability below which a hypothesis is not looked at."""
Fit = tuple[FloatArray, FloatArray, FloatArray]
"""Log evidence (n_sets,), sizes and their sds (n_sets, n_members)."""


@dataclass(frozen=True, eq=False)
class PlainCause:
    """One explanation: (effect, place) of each member, (size, low, high) of each at 90 %, names not told apart."""

    members: tuple[tuple[Effect, str], ...]
    sizes: FloatArray
    probability: float
    names: tuple[frozenset[str], ...]
    is_unknown: bool = False


@dataclass(frozen=True, eq=False)
class Selection:
    """Causes, most probable first, the fewest that hold 95 %, and each cell's state."""

    causes: tuple[PlainCause, ...]
    credible: tuple[PlainCause, ...]
    unknown_probability: float
    states: FloatArray


def select(campaign: Campaign, twin: Twin, run: Campaign | None = None, noise_sd: float | None = None) -> Selection:
    """Return the probability of no effect, of every single one, of pairs, and of something unknown."""
    asked = twin if isinstance(twin, CachedTwin) else CachedTwin(twin)
    read = readings_of(campaign, asked, run, noise_sd)
    effects = library_of(twin, campaign).values()
    library = [e for e in effects if not getattr(e, "is_nameless", False)]  # its unknown has courses of its own
    every = [(effect, place) for effect in library for place in effect.places(asked)]
    signatures = _signatures(read, every)
    kept = [k for k, signature in enumerate(signatures) if np.any(np.abs(signature) > 1e-12 * read.typical[:, None])]
    members = [every[k] for k in kept]
    read = with_states(read, signatures[kept], np.array([effect.prior_sd for effect, _ in members]))
    model = _Model(read, members, _signatures(read, members))
    alone = model.evidence(np.arange(len(members))[:, None])
    best = np.argsort(-alone[0])[:N_EXACT]
    model.signatures[best] = _signatures(read, [members[k] for k in best], alone[1][best, 0])
    return _selection(model)


def _signatures(read: Readings, members: Sequence[tuple[Effect, str]], sizes: FloatArray | None = None) -> FloatArray:
    """Return what effects change per unit of size (n_members, n_gauges, n_cells), at 0 or between 0 and a size."""
    found = np.zeros((len(members), *read.residual.shape))
    states = [dict(zip(read.twin.parameters, row, strict=True)) for row in read.states.tolist()]
    for c, (cell, state) in enumerate(zip(read.campaign.cells, states, strict=True)):
        here = read.twin.predict(state, cell.load)[read.order]
        real = np.where(np.abs(here) > 0.01 * read.typical, read.expected[:, c] / np.where(here == 0.0, 1.0, here), 1.0)
        for k, (effect, place) in enumerate(members):
            if sizes is not None and hasattr(effect, "predict") and sizes[k] != 0.0:
                there = effect.predict(read.twin, state, cell.load, sizes[k], place, cell.time)[read.order]
                found[k, :, c] = (there - here) / sizes[k]
            else:
                change = read.twin.signatures(effect, (place,), state, cell.load, cell.time)[0][read.order]
                found[k, :, c] = change * (real if in_chain(effect) and effect.load_power is None else 1.0)
    return found


class _Model:
    """The linear model: evidence of sets of members, and which members the readings tell apart."""

    def __init__(self, read: Readings, members: Sequence[tuple[Effect, str]], signatures: FloatArray) -> None:
        self.read, self.members, self.signatures = read, members, signatures
        effects = [effect for effect, _ in members]
        self.names = np.array([effect.name for effect in effects])
        self.mean, self.sd = (np.array([getattr(e, what) for e in effects]) for what in ("prior_mean", "prior_sd"))
        bounds = [getattr(e, "bounds", (0.0 if e.is_one_sided else -np.inf, np.inf)) for e in effects]
        self.bounds = np.array(bounds).reshape(-1, 2)
        errors = [SHARES[0] if in_chain(e) else max(SHARES[1], getattr(e, "signature_error", 0.0)) for e in effects]
        self.share = np.array(errors)

    def white(self, columns: FloatArray, more: FloatArray | float = 0.0) -> tuple[FloatArray, float]:
        """Return columns (n, n_gauges, n_cells) of unit noise, covariance added or not, and minus half its log det."""
        root = np.linalg.cholesky(self.read.covariance + more)
        log = -float(np.log(np.diagonal(root, axis1=1, axis2=2)).sum())
        return np.linalg.solve(root, columns[..., None])[..., 0], log

    def bent(self) -> list[FloatArray]:
        """Return the signatures times each load that varies, between -1 and 1: their error may grow with it."""
        applied = np.array([amounts_of(cell.load) for cell in self.read.campaign.cells]).reshape(
            len(self.read.states), -1
        )
        width = np.maximum(np.ptp(applied, axis=0), 1e-300)
        return [
            self.signatures * (2.0 * load - load.max() - load.min()) / w
            for load, w in zip(applied.T, width, strict=True)
            if w > 1e-300
        ]

    def evidence(self, sets: IntArray) -> Fit:
        """Return log evidence (n_sets,), sizes and their sds (n_sets, n_members) of sets of members."""
        columns = [self.read.residual[None], self.read.nuisances, self.signatures, *self.bent()]
        told, log_det = self.white(np.concatenate(columns))
        parts = [self._evidence(sets[k : k + AT_ONCE], told, log_det) for k in range(0, len(sets), AT_ONCE)]
        log, size, spread = (np.concatenate(part) for part in zip(*parts, strict=True))
        return log, size, spread

    def _evidence(self, sets: IntArray, told: FloatArray, log_det: float) -> Fit:
        """Return the evidence of some sets, given the whitened columns and minus half their log det."""
        n, nuisances = sets.shape[1], self.read.nuisances
        first, every = 1 + len(nuisances), len(self.names) * np.arange(len(told) // len(self.names))
        shared = np.broadcast_to(told[:first], (len(sets), *told[:first].shape))
        columns = np.concatenate([shared, *(told[first + sets + k] for k in every)], axis=1)
        products, found = np.einsum("hagc,hbgc->hgab", columns, columns), []
        for scale in product(SCALES, repeat=n):
            sd = np.where(self.mean[sets] == 0.0, scale, 1.0) * self.sd[sets]
            size = np.zeros_like(sd)
            for _ in range(2):  # the error of a signature goes with the size
                gram, log = products, np.full(len(sets), log_det)
                for m in range(n * len(every) if size.any() else 0):
                    wrong, own = (self.share[sets[:, m % n]] * size[:, m % n]) ** 2, gram[..., first + m]
                    grown = 1.0 + wrong[:, None] * own[..., first + m]
                    log -= 0.5 * np.log(grown).sum(axis=1)
                    gram = gram - (wrong[:, None] / grown)[..., None, None] * own[..., :, None] * own[..., None, :]
                log, size, spread = self._sized(gram[..., : first + n, : first + n].sum(axis=1), log, sets, sd)
            found.append((log - n * np.log(len(SCALES)), size, spread))
        logs, sizes, spreads = (np.array([part[k] for part in found]) for k in range(3))
        best = np.argmax(logs, axis=0), np.arange(len(sets))
        return logsumexp(logs, axis=0), sizes[best], spreads[best]

    def _sized(self, gram: FloatArray, log: FloatArray, sets: IntArray, sd: FloatArray) -> Fit:
        """Return log evidence, sizes and sds, given the products of residual, nuisances and members."""
        n = sets.shape[1]
        free = np.ones((len(sets), gram.shape[1] - 1 - n))
        precision, mean = np.concatenate([free, sd**-2], 1), np.concatenate([0.0 * free, self.mean[sets]], 1)
        inner = gram[:, 1:, 1:] + precision[:, :, None] * np.eye(precision.shape[1])
        right = gram[:, 1:, 0] + precision * mean
        covariance = np.linalg.inv(inner)
        at = np.einsum("hab,hb->ha", covariance, right)
        log = log - 0.5 * (gram[:, 0, 0] + np.sum(precision * mean**2, 1) - np.sum(right * at, 1))
        log += 0.5 * (np.log(precision).sum(axis=1) - np.linalg.slogdet(inner)[1])
        low, high = np.moveaxis(self.bounds[sets], 2, 0)
        size, spread = at[:, free.shape[1] :], np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))[:, free.shape[1] :]
        inside = [ndtr((high - m) / s) - ndtr((low - m) / s) for m, s in ((size, spread), (self.mean[sets], sd))]
        log += np.sum(np.log(np.maximum(inside[0], 1e-300)) - np.log(inside[1]), axis=1)
        return log, np.clip(size, low, high), spread

    def unknown(self) -> float:
        """Return the log evidence of what no effect explains: courses over the cells, free at every gauge."""
        read, cells = self.read, self.read.campaign.cells
        of = read.expected / read.typical[:, None]
        times = np.array([cell.time for cell in cells]) / max(1.0, *(cell.time for cell in cells))
        tests = [np.array([cell.test == test for cell in cells]) for test in dict.fromkeys(cell.test for cell in cells)]
        courses = [np.ones_like(of), of, of * np.abs(of), times + 0.0 * of, *(of * at for at in tests[1:])]
        parts = [c[:, :, None] * c[:, None, :] for c in courses] + [np.ones_like(of)[:, :, None] * np.eye(len(cells))]
        columns, none, logs = np.concatenate([read.residual[None], read.nuisances]), np.zeros((1, 0)), []
        for part, size in product(parts, UNKNOWN_SIZES):
            told, log = self.white(columns, (size * read.typical[:, None, None]) ** 2 * part)
            flat = told.reshape(1, len(told), -1)
            logs.append(self._sized(flat @ flat.transpose(0, 2, 1), np.array([log]), none.astype(int), none)[0][0])
        return float(logsumexp(logs) - np.log(len(logs)))

    def changes(self, sets: IntArray, sizes: FloatArray) -> FloatArray:
        """Return what sets change (n_sets, n_readings) in noise sds, but for what nuisances imitate."""
        white, _ = self.white(np.concatenate([self.read.nuisances, self.signatures]))
        flat, n = white.reshape(len(white), -1), len(self.read.nuisances)
        basis = np.linalg.qr(flat[:n].T)[0]
        rest = flat[n:] - (flat[n:] @ basis) @ basis.T
        return np.asarray(np.einsum("hm,hmr->hr", sizes, rest[sets]))


def _selection(model: _Model) -> Selection:
    """Return the causes: hypotheses whose changes cannot be told apart are one, under the name of the simplest."""
    names, n = model.names, len(model.names)
    kinds, kind, count = np.unique(names, return_inverse=True, return_counts=True)
    log_place = -np.log(len(kinds) * count[kind])
    sets = [np.zeros((1, 0), dtype=int), np.arange(n)[:, None]]
    fits = [model.evidence(s) for s in sets]
    heads = np.argsort(-(fits[1][0] + log_place))[:N_HEADS]
    pairs = {(min(i, j), max(i, j)) for i in heads for j in range(n) if names[i] != names[j]}
    sets.append(np.array(sorted(pairs)).reshape(-1, 2))
    fits.append(model.evidence(sets[2]))
    priors = [np.log(PRIOR[kind] * (m or 1)) for m, kind in enumerate(("none", "single", "pair"))]
    logs = [p + log_place[s].sum(axis=1) + fit[0] for p, s, fit in zip(priors, sets, fits, strict=True)]
    log = np.concatenate([*logs, [np.log(PRIOR["unknown"]) + model.unknown()]])
    probability = np.exp(log - logsumexp(log))
    unknown = float(probability[-1])
    told = [tuple(members) for s in sets for members in s.tolist()]
    sizes, spreads = ([row for fit in fits for row in fit[k]] for k in (1, 2))
    changes = np.concatenate([model.changes(s, fit[1]) for s, fit in zip(sets, fits, strict=True)])
    causes, left = [PlainCause((), np.zeros((0, 3)), unknown, (), is_unknown=True)], np.argsort(-probability[:-1])
    while len(left) and probability[left[0]] > IDLE:
        is_same = np.linalg.norm(changes[left] - changes[left[0]], axis=1) < SEPARABLE
        same, left = left[is_same], left[~is_same]
        head = min(same, key=lambda k: len(told[k]))  # the first of the fewest, which is the most probable of these
        alike = [set(told[k]) for k in same if len(told[k]) == len(told[head])]
        beside = [set(told[head]) - {member} for member in told[head]]
        groups = [frozenset(str(names[k]) for s in alike if others < s for k in s - others) for others in beside]
        bounds = [sizes[head] + z * spreads[head] for z in (0.0, -Z90, Z90)]
        members = tuple(model.members[k] for k in told[head])
        causes.append(PlainCause(members, np.stack(bounds, axis=1), float(probability[same].sum()), tuple(groups)))
    causes.sort(key=lambda cause: -cause.probability)
    before = np.cumsum([0.0, *(cause.probability for cause in causes)])
    credible = tuple(cause for cause, sum_ in zip(causes, before, strict=False) if sum_ < CREDIBLE)
    return Selection(tuple(causes), credible, unknown, model.read.states)
