"""The selector: posterior over sets of the generator's own changes, for one case.

It knows the family's strains and the formula of every change, the priors of names, places and sizes, the noise, what
the commissioning run leaves open, and, of an unknown state, where it is near. What it cannot tell, no diagnosis can.
It reads the means of the cells. Pairs are searched among those that fit best.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind.assets.asset import Asset
from benchmarks.blind.assets.moment import Moment
from benchmarks.blind.cases import Case, mean_readings, moments
from benchmarks.blind.limit.candidates import LEAST, MOST, PATTERNS, Candidate, outside, singles
from benchmarks.blind.limit.evidence import Columns, Integral, integrate, pair_gains, pattern_evidence
from benchmarks.blind.truths import DISCRETE, Truth
from femlib.arrays import FloatArray

KINDS = {"none": 0.30, "single": 0.40, "pair": 0.15, "outside": 0.15}
"""Probability of each kind of case: as they are drawn, and no more than that from what a file looks like."""
N_PAIRS = 100
N_DISCRETE = 25
PATTERN_SIZES = np.geomspace(LEAST, MOST, 12)


@dataclass(frozen=True, eq=False)
class Told:
    """One hypothesis: its candidates (none of them for "outside"), what it says, its log-probability and sizes."""

    members: tuple[int, ...]
    names: tuple[str, ...]
    log: float
    sizes: tuple[float, ...] = ()
    low: float = 0.0
    high: float = 0.0


class Selector:
    """The selector for one case.

    Attributes
    ----------
    candidates
        every single change.
    columns
        of the candidates, whitened.
    told
        all hypotheses, their probabilities in `probability` (n_told,).
    """

    def __init__(self, case: Case, asset: Asset, means: FloatArray, covariance: FloatArray) -> None:
        self.case, self.asset, self.cells = case, asset, moments(case)
        self.root = np.linalg.cholesky(covariance)
        self.base = np.array([m.load * asset.strain(m.state) for m in self.cells])
        self.residual = self._white(means - self.base)
        self.candidates = singles(asset)
        self.n_names = len({c.truth.name for c in self.candidates})
        self.columns = self._columns(self.candidates)
        alone = integrate(self.columns, self.residual)
        self.told = [Told((), (), float(np.log(KINDS["none"]))), *self._singles(alone), *self._pairs(alone)]
        self.told += self._outside()
        log = np.array([told.log for told in self.told])
        self.probability = np.exp(log - np.logaddexp.reduce(log))

    # -- signatures ---------------------------------------------------------------------------------------------------

    def _white(self, change: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.solve(self.root, change.ravel()))

    def moved(self, truths: Sequence[Truth]) -> FloatArray:
        """Return what truths change of the means (n_cells, n_gauges)."""
        return np.asarray(np.array([mean_readings(truths, self.asset, m).mean(axis=0) for m in self.cells]) - self.base)

    def _columns(self, candidates: Sequence[Candidate]) -> Columns:
        first, second = [], []
        for c in candidates:
            there = self.moved((c.truth,))
            if c.most <= c.least or not c.is_signed:
                first.append(there.ravel())
                second.append(np.zeros(there.size))
                continue
            back = self.moved((c.at(-1.0),))
            first.append(0.5 * (there - back).ravel())
            second.append(0.5 * (there + back).ravel())
        a, b = (np.linalg.solve(self.root, np.array(rows).T).T for rows in (first, second))
        least, most, signed = np.array([[c.least, c.most, c.is_signed] for c in candidates], dtype=float).T
        return Columns(a, b, least, most, signed)

    # -- hypotheses ---------------------------------------------------------------------------------------------------

    def _singles(self, alone: Integral) -> list[Told]:
        prior = float(np.log(KINDS["single"]))
        return [
            Told(
                (k,), (c.truth.name,), prior + c.log_prior + float(alone.log[k]), (float(alone.size[k]),),
                float(alone.low[k]), float(alone.high[k]),
            )
            for k, c in enumerate(self.candidates)
        ]  # fmt: skip

    def _pairs(self, alone: Integral) -> list[Told]:
        is_discrete = np.array([c.truth.name in DISCRETE for c in self.candidates])
        gains = np.triu(pair_gains(self.columns.first, self.residual))
        gains[is_discrete], gains[:, is_discrete] = 0.0, 0.0
        best = np.argsort(gains, axis=None)[::-1][:N_PAIRS]
        found = [self._pair(*divmod(int(k), len(gains))) for k in best]
        last = np.flatnonzero(is_discrete)
        for d in last[np.argsort(alone.log[last])[::-1][:N_DISCRETE]]:
            found += self._beside(int(d))
        return [told for told in found if len(set(told.names)) == 2]

    def _pair(self, i: int, j: int) -> Told:
        """Return two changes together, with what they do to each other."""
        a, b = self.candidates[i], self.candidates[j]
        one, two = (_row(self.columns, k) for k in (i, j))
        sizes = self._fitted(one, two)
        both = self._white(self.moved((a.at(sizes[0]), b.at(sizes[1]))))
        cross = (both - _change(one, sizes[0]) - _change(two, sizes[1])) / (sizes[0] * sizes[1])
        # one size at its best, then the other integrated out; the first's own width enters by what the second leaves
        rest = self.residual - _change(one, sizes[0])
        second = integrate(replace(two, first=two.first + sizes[0] * cross), rest)
        slope: FloatArray = one.first[0] + 2.0 * sizes[0] * one.second[0] + sizes[1] * cross
        other = two.first[0] + sizes[0] * cross
        left = slope - other * (slope @ other) / max(float(other @ other), 1e-30)
        width = float(np.sqrt(2.0 * np.pi / max(float(left @ left), 1e-30)))
        moved = _change(one, sizes[0])
        fit = float(self.residual @ moved - 0.5 * moved @ moved)
        log = fit + _log_width(a, sizes[0], width) + float(second.log[0])
        return Told((i, j), (a.truth.name, b.truth.name), self._of_pair(a, b) + log, (sizes[0], float(second.size[0])))

    def _fitted(self, one: Columns, two: Columns) -> list[float]:
        """Return the sizes of two changes together, each within its bounds: least squares, then one by one."""
        pair = np.stack([one.first[0], two.first[0]], axis=1)
        sizes: list[float] = np.linalg.lstsq(pair, self.residual, rcond=None)[0].tolist()
        for k in (0, 1, 0, 1):
            column, other = (one, two) if k == 0 else (two, one)
            rest = self.residual - _change(other, _within(other, sizes[1 - k]))
            slope = column.first[0] + _within(column, sizes[k]) * column.second[0]
            sizes[k] = _within(column, float(slope @ rest / max(float(slope @ slope), 1e-30)))
        return sizes

    def _beside(self, d: int) -> list[Told]:
        """Return a dead gauge or swapped wires beside every other change, which then shows in other channels."""
        truth = self.candidates[d].truth
        gone = _row(self.columns, d).first[0]
        rows = [self._channels(column, truth) for column in (self.columns.first, self.columns.second)]
        rest = integrate(replace(self.columns, first=rows[0], second=rows[1]), self.residual - gone)
        own = float(gone @ self.residual - 0.5 * gone @ gone)
        return [
            Told(
                (d, k), (truth.name, c.truth.name),
                self._of_pair(self.candidates[d], c) + own + float(rest.log[k]), (1.0, float(rest.size[k])),
            )
            for k, c in enumerate(self.candidates)
            if c.truth.name not in DISCRETE
        ]  # fmt: skip

    def _channels(self, white: FloatArray, truth: Truth) -> FloatArray:
        """Return whitened changes (n, n_readings) as a dead gauge or swapped wires show them."""
        change = (self.root @ white.T).T.reshape(len(white), *self.base.shape)
        gauges = [self.asset.gauges.index(g) for g in truth.place.split("/")]
        shown = change.copy()
        shown[..., gauges] = 0.0 if len(gauges) == 1 else change[..., gauges[::-1]]
        return np.asarray(np.linalg.solve(self.root, shown.reshape(len(white), -1).T).T)

    def _of_pair(self, a: Candidate, b: Candidate) -> float:
        """Return the prior: two names of all, in either order."""
        n = self.n_names
        return float(np.log(KINDS["pair"]) + a.log_prior + b.log_prior + np.log(2.0 * n / (n - 1)))

    def _outside(self) -> list[Told]:
        prior = float(np.log(KINDS["outside"]))
        found = []
        for kind in self.asset.outside:
            if kind in PATTERNS:
                log = pattern_evidence(self._pattern(kind), self.residual, PATTERN_SIZES)
                found.append(Told((), ("outside",), prior - float(np.log(len(self.asset.outside))) + log))
                continue
            variants = outside(kind, self.asset)
            integral = integrate(self._columns(variants), self.residual)
            logs = [v.log_prior + log for v, log in zip(variants, integral.log.tolist(), strict=True)]
            found.append(Told((), ("outside",), prior + float(np.logaddexp.reduce(logs))))
        return found

    def _pattern(self, kind: str) -> FloatArray:
        """Return a column (n_readings, n_gauges) for each gauge, as large as the pattern's rms is there."""
        draws = [Truth("outside", 1.0, kind, {"seed": seed, "spot": ""}) for seed in range(8)]
        rms = np.sqrt(np.mean([self.moved((truth,)) ** 2 for truth in draws], axis=0))
        if kind == "patchy_gain":
            rms = rms.mean(axis=1, keepdims=True) * self.base / np.maximum(self.base.mean(axis=1, keepdims=True), 1e-9)
        columns = rms[:, :, None] * np.eye(rms.shape[1])
        return np.asarray(np.linalg.solve(self.root, columns.reshape(-1, rms.shape[1])))


def _row(columns: Columns, k: int) -> Columns:
    at = slice(k, k + 1)
    return Columns(columns.first[at], columns.second[at], columns.least[at], columns.most[at], columns.is_signed[at])


def _within(column: Columns, size: float) -> float:
    """Return the nearest size that a change may have."""
    amount = float(np.clip(abs(size), column.least[0], column.most[0]))
    if size < 0.0 and column.is_signed[0] > 0.5:
        return -amount
    return amount if size > 0.0 else float(column.least[0])


def _change(column: Columns, size: float) -> FloatArray:
    return np.asarray(size * column.first[0] + size**2 * column.second[0])


def _log_width(candidate: Candidate, size: float, width: float) -> float:
    """Return the log of the prior mass within the width of a size's likelihood."""
    if candidate.most <= candidate.least:
        return 0.0
    density = 1.0 / (abs(size) * np.log(candidate.most / candidate.least))
    return float(np.log(min(1.0, density * width) * (0.5 if candidate.is_signed else 1.0)))


def held_change(selector: Selector, told: Told, held: Moment) -> FloatArray:
    """Return what a hypothesis adds to the readings (n_gauges,) at another moment."""
    asset = selector.asset
    truths = [selector.candidates[k].at(size) for k, size in zip(told.members, told.sizes, strict=True)]
    return np.asarray(mean_readings(truths, asset, held)[0] - held.load * asset.strain(held.state))
