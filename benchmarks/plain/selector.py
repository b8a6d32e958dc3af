"""The plain selector: linear Gaussian evidence for each effect of a library, alone and in pairs.

    reading - twin - difference = sum_j size_j s_j + N x + noise,     size_j ~ N(mean_j, (k sd_j)^2), k = 1/3, 1, 3

in every gauge and cell (one test at one load). A signature s_j is wrong by a share of itself at each gauge, which adds
(share size_j)^2 s_j s_j^T to the covariance of that gauge; `N` holds nuisances. What no effect explains has a course over
the cells that is known and a size at each gauge that is not. The sum over all hypotheses is exact; there is no search
but that pairs hold one of the twelve best single effects.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from scipy.special import logsumexp, ndtr

from benchmarks.plain.readings import Readings, readings_of, with_states
from femlib.arrays import FloatArray, IntArray
from octmip.gap import Campaign
from octmip.gap.diagnosis import library_of
from octmip.gap.effects import in_chain
from octmip.gap.effects.complete import completed
from octmip.gap.twins.cached import CachedTwin
from octmip.twin import Effect, Twin

PRIOR = {"none": 0.50, "single": 0.38, "pair": 0.07, "unknown": 0.04}
SCALES = (1 / 3, 1.0, 3.0)
SHARES = (0.01, 0.07)
"""Relative error of a signature of the measuring chain, and of the structure."""
UNKNOWN_SIZES = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Over the typical reading of a gauge."""
N_HEADS, N_EXACT = 12, 16
"""Single effects that are tried with all others; those whose signature is taken between 0 and the size found."""
SEPARABLE, CREDIBLE, Z90 = 3.0, 0.95, 1.645
IDLE = 1e-4
"""Probability below which a hypothesis is not looked at."""
PLAUSIBLE = 9.0
"""Prior sds within which an effect may stand for another."""


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
    """Causes, most probable first, the fewest that hold 95 %, the probability of each effect, and each cell's state."""

    causes: tuple[PlainCause, ...]
    credible: tuple[PlainCause, ...]
    unknown_probability: float
    inclusion: Mapping[str, float]
    states: FloatArray


def select(campaign: Campaign, twin: Twin, run: Campaign | None = None, noise_sd: float | None = None) -> Selection:
    """Return the probability of no effect, of every single one, of pairs, and of something unknown."""
    asked = twin if isinstance(twin, CachedTwin) else CachedTwin(twin)
    read = readings_of(campaign, asked, run, noise_sd)
    library = completed(library_of(twin, campaign)).values()
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
    begun = sorted((cell.time, cell.load_factor) for cell in read.campaign.cells) if len(read.campaign.load_names) == 1 else []
    steps = [(load - before, time) for (time, load), (_, before) in zip(begun, [(0.0, 0.0), *begun], strict=False)]
    for c, (cell, state) in enumerate(zip(read.campaign.cells, states, strict=True)):
        here = read.twin.predict(state, cell.load)
        for k, (effect, place) in enumerate(members):
            parts = [(cell.load, cell.time)]
            if getattr(effect, "superposes", False) and steps:
                parts = [(step, cell.time - time) for step, time in steps if time <= cell.time]
            if sizes is not None and hasattr(effect, "predict") and sizes[k] != 0.0 and len(parts) == 1:
                change = (effect.predict(read.twin, state, cell.load, sizes[k], place, cell.time) - here) / sizes[k]
            else:
                change = sum(read.twin.signatures(effect, (place,), state, load, time)[0] for load, time in parts)
            found[k, :, c] = change[read.order]
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

    def evidence(self, sets: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return log evidence (n_sets,), sizes and their sds (n_sets, n_members) of sets of members."""
        n, nuisances = sets.shape[1], self.read.nuisances
        told, log_det = self.white(np.concatenate([self.read.residual[None], nuisances, self.signatures]))
        first = 1 + len(nuisances)
        found = []
        for scale in product(SCALES, repeat=n):
            sd = np.where(self.mean[sets] == 0.0, scale, 1.0) * self.sd[sets]
            size = np.zeros_like(sd)
            for _ in range(2):  # the error of a signature goes with the size
                columns = np.concatenate([np.broadcast_to(told[:first], (len(sets), *told[:first].shape)), told[first + sets]], 1)
                gram = np.einsum("hagc,hbgc->hgab", columns, columns)
                log = np.full(len(sets), log_det)
                for m in range(n):
                    own, at = (self.share[sets[:, m]] * size[:, m]) ** 2, first + m
                    grown = 1.0 + own[:, None] * gram[:, :, at, at]
                    log -= 0.5 * np.log(grown).sum(axis=1)
                    gram = gram - (own[:, None] / grown)[..., None, None] * gram[..., at, None] * gram[..., at, :][..., None, :]
                log, size, spread = self._sized(gram.sum(axis=1), log, sets, sd)
            found.append((log - n * np.log(len(SCALES)), size, spread))
        logs, sizes, spreads = (np.array([part[k] for part in found]) for k in range(3))
        best = np.argmax(logs, axis=0), np.arange(len(sets))
        return logsumexp(logs, axis=0), sizes[best], spreads[best]

    def _sized(self, gram: FloatArray, log: FloatArray, sets: IntArray, sd: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return log evidence, sizes and sds, given products of residual, nuisances and members, prior sds of members."""
        n = sets.shape[1]
        free = np.ones((len(sets), gram.shape[1] - 1 - n))
        precision, mean = np.concatenate([free, sd**-2], 1), np.concatenate([0.0 * free, self.mean[sets]], 1)
        inner = gram[:, 1:, 1:] + precision[:, :, None] * np.eye(precision.shape[1])
        right = gram[:, 1:, 0] + precision * mean
        covariance = np.linalg.inv(inner)
        at = np.einsum("hab,hb->ha", covariance, right)
        log = log - 0.5 * (gram[:, 0, 0] + np.sum(precision * mean**2, 1) - np.sum(right * at, 1))
        log += 0.5 * (np.log(precision).sum(axis=1) - np.linalg.slogdet(inner)[1])
        spread, size = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)), at
        spread, size, low, high = spread[:, -n:], size[:, -n:], *np.moveaxis(self.bounds[sets], 2, 0)
        if n == 0:
            return log, np.zeros((len(sets), 0)), np.zeros((len(sets), 0))
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
        logs = []
        for part in parts:
            for size in UNKNOWN_SIZES:
                told, log = self.white(np.concatenate([read.residual[None], read.nuisances]), (size * read.typical[:, None, None]) ** 2 * part)
                flat = told.reshape(1, len(told), -1)
                none = np.zeros((1, 0), dtype=int)
                logs.append(self._sized(flat @ flat.transpose(0, 2, 1), np.array([log]), none, np.zeros((1, 0)))[0][0])
        return float(logsumexp(logs) - np.log(len(logs)))

    @cached_property
    def gram(self) -> FloatArray:
        """Products of the whitened signatures (n_members, n_members), what nuisances imitate taken out."""
        white, _ = self.white(np.concatenate([self.read.nuisances, self.signatures]))
        flat, n = white.reshape(len(white), -1), len(self.read.nuisances)
        basis = np.linalg.qr(flat[:n].T)[0]
        rest = flat[n:] - (flat[n:] @ basis) @ basis.T
        return np.asarray(rest @ rest.T)

    def seen(self, sets: IntArray, sizes: FloatArray) -> list[tuple[int, ...]]:
        """Return of each set the members that stand `SEPARABLE` above the noise beside the other, at least together."""
        length = np.diag(self.gram)[sets]
        alone = np.abs(sizes) * np.sqrt(length)
        beside = alone
        if sets.shape[1] == 2:
            across = self.gram[sets[:, 0], sets[:, 1]][:, None] ** 2 / np.maximum(length[:, ::-1], 1e-300)
            beside = np.abs(sizes) * np.sqrt(np.maximum(length - across, 0.0))
            hidden = np.all(beside < SEPARABLE, axis=1)
            beside = np.where(hidden[:, None] & (alone == alone.max(axis=1, keepdims=True)), alone, beside)
        return [tuple(row[keep].tolist()) for row, keep in zip(sets, beside >= SEPARABLE, strict=True)]

    def alike(self, member: int, others: Sequence[int], size: float) -> set[int]:
        """Return the members that, as large as need be, leave less than `SEPARABLE` of one beside others."""
        gram = self.gram
        for other in others:
            gram = gram - np.outer(gram[other], gram[other]) / max(gram[other, other], 1e-300)
        length = np.maximum(np.diag(gram), 1e-300)
        needed = size * gram[member] / length
        left = size**2 * (length[member] - gram[member] ** 2 / length)
        is_possible = (np.abs(needed - self.mean) < PLAUSIBLE * self.sd) & (needed > self.bounds[:, 0])
        return {member, *np.flatnonzero((left < SEPARABLE**2) & is_possible & (needed < self.bounds[:, 1])).tolist()}


def _selection(model: _Model) -> Selection:
    """Return the causes: hypotheses that cannot be told apart are one."""
    names, n = model.names, len(model.names)
    kinds, kind, count = np.unique(names, return_inverse=True, return_counts=True)
    log_place = -np.log(len(kinds) * count[kind])
    alone = model.evidence(np.arange(n)[:, None])
    heads = np.argsort(-(alone[0] + log_place))[:N_HEADS]
    pairs = np.array([(i, j) for i in heads for j in range(n) if names[i] != names[j] and not (j in heads and j < i)])
    pairs = pairs.reshape(-1, 2)
    both, none = model.evidence(pairs), model.evidence(np.zeros((1, 0), dtype=int))
    log = np.concatenate([
        np.log(PRIOR["none"]) + none[0], np.log(PRIOR["single"]) + log_place + alone[0],
        np.log(2.0 * PRIOR["pair"]) + log_place[pairs].sum(axis=1) + both[0], [np.log(PRIOR["unknown"]) + model.unknown()],
    ])  # fmt: skip
    probability = np.exp(log - logsumexp(log))
    sizes, spreads = ([*none[k], *alone[k], *both[k]] for k in (1, 2))
    told = [(), *((k,) for k in range(n)), *map(tuple, pairs.tolist())]
    seen = [(), *model.seen(np.arange(n)[:, None], alone[1]), *model.seen(pairs, both[1])]
    causes = [PlainCause((), np.zeros((0, 3)), float(probability[-1]), (), is_unknown=True)]
    left = np.argsort(-probability[:-1], kind="stable").tolist()
    while left and probability[left[0]] > IDLE:
        head = next(k for k in (left[0], *range(len(told))) if told[k] == seen[left[0]])
        members, size, spread = told[head], sizes[head], spreads[head]
        beside = [[other for other in members if other != k] for k in members]
        groups = [model.alike(*one) for one in zip(members, beside, size, strict=True)]
        same = {k for k in left if seen[k] == members or _is_same(seen[k], groups)}
        causes.append(
            PlainCause(
                tuple(model.members[k] for k in members), np.stack([size, size - Z90 * spread, size + Z90 * spread], 1),
                float(probability[list(same)].sum()), tuple(frozenset(names[sorted(g)].tolist()) for g in groups),
            )
        )  # fmt: skip
        left = [k for k in left if k not in same]
    causes.sort(key=lambda cause: -cause.probability)
    before = np.cumsum([0.0, *(cause.probability for cause in causes)])
    credible = tuple(cause for cause, sum_ in zip(causes, before, strict=False) if sum_ < CREDIBLE)
    held = [{names[k] for k in members} for members in seen]
    inclusion = {str(one): float(probability[:-1][[one in names_ for names_ in held]].sum()) for one in kinds}
    return Selection(tuple(causes), credible, float(probability[-1]), inclusion, model.read.states)


def _is_same(members: tuple[int, ...], groups: Sequence[set[int]]) -> bool:
    if not groups or len(members) != len(groups):
        return False
    return any(all(k in g for k, g in zip(members, order, strict=True)) for order in (groups, groups[::-1]))
