"""Hyperplanes: splits over several features, kept a band of mu away from the samples.

    a_jm     coefficient of feature j at node m, on transformed features x = (feature - shift) * scale
    b_m      offset;   d_m  1 if node m splits;   s_jm  1 if node m reads feature j
    left     a_m'x_i + mu <= b_m          right    a_m'x_i >= b_m

Real normals: each feature is scaled to a range of 1, sum_j |a_jm| <= 1, and mu is a number chosen from the data. A
model with mu > 0 does not hold every tree: its bound speaks about the mu-separated ones. The rule for mu:
    the widest band that the starting tree still fits into, but at most 0.005 (Bertsimas & Dunn's value) and at least
    1e-4, which is a hundred times what HiGHS may be off (feasibility + 2 integrality) at tolerance 1e-7 and finer.
Features of extreme size are first multiplied by a power of two, which is exact, so that no range overflows; a split
whose coefficients on the problem's own features are beyond float64 cannot be made into a tree and is not read.
Integer normals (`Shape.integer_normals` = M): a_jm whole, |a_jm| <= M. When all features are decimal numbers of few
digits, scaling by a power of ten makes a'x whole; then mu = 1 loses nothing and the bound speaks about every tree.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.mip.blocks.heap import Heap, Placed
from octmip.trees.mip.blocks.scope import Scope
from octmip.trees.mip.rows import Columns, Rows, Term
from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split
from octmip.trees.question.problem import Problem

MU_LARGEST, MU_SMALLEST = 5e-3, 1e-4
MOST_DIGITS = 6  # of decimal features that are made whole
MODERATE = 300  # powers of two of feature values that need no scaling: sums and products of them stay in float64
MOST_COMMON = 900  # power of two that coefficients may be multiplied by without products beyond float64
LARGEST_REACH = 1e6  # whole a'x beyond it would drown mu = 1 in HiGHS's tolerances

Band = tuple[NDArray[np.bool_], NDArray[np.bool_]]


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """The transformed features in which hyperplanes are written.

    Attributes
    ----------
    x
        (n_samples, n_features) transformed features, |x| <= half their range.
    shift, scale
        (n_features,) ``x = (feature * 2^-exponent - shift) * scale``.
    exponent
        (n_features,) 0 unless a feature is of extreme size; the same for all where coefficients are whole.
    coefficient
        largest |a|; 1 for real normals.
    is_integer
        whether coefficients are whole.
    reach
        largest |a'x|.
    is_exact
        whether every a'x is whole, so that mu = 1 loses nothing.
    """

    x: NDArray[np.float64]
    shift: NDArray[np.float64]
    scale: NDArray[np.float64]
    exponent: NDArray[np.int64]
    coefficient: float
    is_integer: bool
    reach: float
    is_exact: bool

    def scope(self, mu: float) -> Scope:
        """Return the trees that a bound for a strictness mu speaks about."""
        unit = "the widest feature" if self.is_integer else "each feature, the sizes of coefficients summing to 1"
        trees = (
            f"mu-separated trees: every sample that a leaf keeps lies outside a band of {mu:.3g} at each split, "
            f"in units of the range of {unit}"
        )
        if self.is_exact:
            trees = f"all trees with whole coefficients up to {self.coefficient:g}"
        kind = "integer" if self.is_integer else "real"
        return Scope(trees, tolerance_for(mu), {"mu": mu, "normals": kind, "is_strictness_exact": self.is_exact})

    def normal_of(self, split: Split | HyperplaneSplit) -> NDArray[np.float64]:
        """Return the coefficients (n_features,) of a split on the transformed features."""
        normal = np.zeros(self.x.shape[1])
        coefficients = (1.0,) if isinstance(split, Split) else split.coefficients
        normal[list(split.features)] = coefficients
        if self.is_integer:
            return normal
        # Mantissas and powers of two apart: coefficients of features of extreme size differ by any power.
        (normal, power), (scale, unit) = np.frexp(normal), np.frexp(self.scale)
        normal = np.divide(normal, scale, out=np.zeros_like(normal), where=scale > 0)
        power = np.where(normal != 0, power - unit + self.exponent, np.iinfo(np.int32).min)
        normal = np.ldexp(normal, np.maximum(power - power.max(), -2000))
        return np.asarray(normal / max(float(np.abs(normal).sum()), 1e-300))

    def coefficients_of(self, normal: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return the coefficients (n_features,) on the problem's own features; None if float64 does not hold them."""
        if self.is_integer:
            return normal
        most, least = int(self.exponent.max()), int(self.exponent.min())
        common = max(min((most + least) // 2, MOST_COMMON), -MOST_COMMON)
        with np.errstate(over="ignore", under="ignore"):
            coefficients = np.ldexp(normal * self.scale, common - self.exponent)
        is_lost = (normal != 0) & ((np.abs(coefficients) < np.finfo(float).tiny) | ~np.isfinite(coefficients))
        return None if is_lost.any() else np.asarray(coefficients)


def space_of(problem: Problem, *, centred: bool = True) -> Space:
    """Return the space that the hyperplanes of a problem are written in.

    Parameters
    ----------
    centred
        real normals: features in [-1/2, 1/2], which halves the big M; False: in [0, 1], as printed.
    """
    shape = problem.shape
    exponent = _extreme_exponents(problem.samples.features)
    if shape.integer_normals is not None:
        exponent = np.full_like(exponent, exponent.max())
    features = np.ldexp(problem.samples.features, -exponent)
    low, high = features.min(axis=0), features.max(axis=0)
    if shape.integer_normals is None:
        scale = np.divide(1.0, high - low, out=np.zeros_like(low), where=high > low)
        shift = low / 2 + high / 2 if centred else low
        reach = 0.5 if centred else 1.0
        return Space((features - shift) * scale, shift, scale, exponent, 1.0, False, reach, False)
    largest = float(shape.integer_normals)
    digits = None if exponent.any() else _decimal_digits(features)
    widest = np.sort(high - low)[::-1][: shape.max_split_size].sum()
    if digits is not None and largest * widest * 10.0**digits <= LARGEST_REACH:
        whole = np.round(features * 10.0**digits)
        shift = np.floor((whole.min(axis=0) + whole.max(axis=0)) / 2)
        x = whole - shift
        reach = largest * float(np.sort(np.abs(x).max(axis=0))[::-1][: shape.max_split_size].sum())
        return Space(
            x, shift / 10.0**digits, np.full(len(low), 10.0**digits), exponent, largest, True, max(reach, 1.0), True
        )
    scale = np.full(len(low), 1.0 / max(float((high - low).max()), 1e-300))
    shift = low / 2 + high / 2
    reach = largest * widest * float(scale[0]) / 2
    return Space((features - shift) * scale, shift, scale, exponent, largest, True, max(reach, 1e-3), False)


def _extreme_exponents(features: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the power of two (n_features,) of each feature's largest size, 0 where that is moderate."""
    exponent = np.frexp(np.abs(features).max(axis=0))[1].astype(np.int64)
    return np.where(np.abs(exponent) > MODERATE, exponent, 0)


def _decimal_digits(features: NDArray[np.float64]) -> int | None:
    """Return the number of decimal digits after which all features end, None when that is more than `MOST_DIGITS`."""
    for digits in range(MOST_DIGITS + 1):
        scaled = np.round(features * 10.0**digits)
        if (scaled / 10.0**digits == features).all() and np.abs(scaled).max() < 2.0**52:
            return digits
    return None


@dataclass(frozen=True, slots=True, eq=False)
class Hyperplanes:
    """The hyperplane splits of a formulation as columns."""

    problem: Problem
    space: Space
    mu: float
    a: Columns  # (n_features, n_branches)
    s: Columns  # (n_features, n_branches)
    b: Columns  # (n_branches,)
    d: Columns  # (n_branches,)
    a_hat: Columns | None  # (n_features, n_branches); None for integer normals
    group: Columns | None  # (n_groups, n_branches): which of allowed_splits a node reads from

    @property
    def scope(self) -> Scope:
        """The trees that a bound speaks about."""
        return self.space.scope(self.mu)

    def add_routing(self, rows: Rows, m: int, samples: NDArray[np.int64], left: Term, right: Term) -> None:
        """Add that what flows left (right) at node m lies left (right) of its band; big M, once per node."""
        a, b, x = self.a[:, m - 1][None, :], self.b[[m - 1]], self.space.x[samples]
        wide = 2 * self.space.reach
        rows.add("left", -np.inf, wide, (a, x), (b, -1.0), (left[0], left[1] * (wide + self.mu)))
        rows.add("right", -wide, np.inf, (a, x), (b, -1.0), (right[0], right[1] * -wide))

    def first(self, m: int) -> Columns:
        """Return the column d_m, as `Thresholds.first` returns those that sum to it."""
        return self.d[[m - 1]]

    def feature_columns(self, m: int) -> dict[int, int]:
        """Return, by feature, the column that is 1 when node m reads it."""
        return {j: int(self.s[j, m - 1]) for j in range(self.problem.samples.n_features)}

    def set(self, values: NDArray[np.float64], placed: Placed, bands: Mapping[int, Band]) -> bool:
        """Write the splits of a tree into `values`; False when one has no band of mu.

        `bands`: for each split the samples (n_samples,) that the model keeps left, and right, of its band.
        """
        for m, split in placed.splits.items():
            normal = self.space.normal_of(split) * (-1 if m in placed.flipped else 1)
            width, offset = fit(normal, self.space.x, bands[m])
            if width < self.mu:
                return False
            t = m - 1
            values[self.a[:, t]], values[self.b[t]], values[self.d[t]] = normal, offset, 1
            values[self.s[:, t]] = normal != 0
            if self.a_hat is not None:
                values[self.a_hat[:, t]] = np.abs(normal)
            if self.group is not None:
                assert self.problem.shape.allowed_splits is not None
                groups = self.problem.shape.allowed_splits
                values[self.group[[set(split.features) <= set(g) for g in groups].index(True), t]] = 1
        return True

    def splits(self, values: NDArray[np.float64]) -> dict[int, Split | HyperplaneSplit]:
        """Return the split of each branch node, read at mid-band: left when ``a'x < b - mu / 2``."""
        found: dict[int, Split | HyperplaneSplit] = {}
        for t in range(len(self.d)):
            normal = values[self.a[:, t]] * (values[self.s[:, t]] > 0.5)
            normal = np.round(normal) if self.space.is_integer else normal * (np.abs(normal) >= 1e-9)
            middle = float(values[self.b[t]]) - self.mu / 2
            if values[self.d[t]] > 0.5 and normal.any():
                split = split_at(self.problem, self.space, normal, middle)
                if split is not None:
                    found[t + 1] = split
            elif values[self.d[t]] > 0.5 and middle > 0:  # 0'x < b: a split that sends everything left
                j = int(values[self.s[:, t]].argmax())
                offset = float(self.problem.samples.features[:, j].max())
                found[t + 1] = HyperplaneSplit((j,), (1.0,), offset, Leaf(0), Leaf(0))
        return found


DIGITS = (6, 9, 12, 17)
"""Digits of coefficients, the fewest first; 17 are all that float64 has."""


def split_at(problem: Problem, space: Space, normal: NDArray[np.float64], middle: float) -> HyperplaneSplit | None:
    """Return a split of the problem's own features, its offset midway between the nearest samples.

    None where float64 does not hold it.

    Parameters
    ----------
    normal, middle
        coefficients (n_features,) and offset on the transformed features.
    """
    features = np.flatnonzero(normal)
    on_own = space.coefficients_of(normal)
    if on_own is None:
        return None
    is_left = space.x @ normal < middle
    for digits in DIGITS:  # as few as part the samples alike: people read them
        coefficients = np.array([float(f"{coefficient:.{digits}g}") for coefficient in on_own[features]])
        totals = np.zeros(problem.samples.n_samples)
        with np.errstate(over="ignore", invalid="ignore"):
            for j, coefficient in zip(features, coefficients, strict=True):  # in the order of `tree.goes_left`
                totals += coefficient * problem.samples.features[:, j]
        if is_left.all() or not is_left.any() or totals[is_left].max() < totals[~is_left].min():
            break
    if not np.isfinite(totals).all():
        return None
    if is_left.all() or not is_left.any():
        offset = float(totals.max()) if is_left.all() else math.nextafter(float(totals.min()), -math.inf)
        if not math.isfinite(offset):
            return None
    else:
        offset = midpoint(float(totals[is_left].max()), float(totals[~is_left].min()))
    return HyperplaneSplit(tuple(map(int, features)), tuple(map(float, coefficients)), offset, Leaf(0), Leaf(0))


def fit(normal: NDArray[np.float64], x: NDArray[np.float64], band: Band) -> tuple[float, float]:
    """Return the width of the empty band between two sides (negative when they overlap) and its right edge."""
    totals = x @ normal
    left, right = band
    low = float(totals[left].max()) if left.any() else -math.inf
    high = float(totals[right].min()) if right.any() else math.inf
    if math.isinf(high):  # nothing to keep right: as far right as samples lie
        high = float(totals.max())
        return math.inf, high
    return high - low, high


def add_hyperplanes(
    rows: Rows,
    problem: Problem,
    heap: Heap,
    space: Space,
    mu: float,
    max_splits: int | None,
    *,
    penalty: float,
) -> Hyperplanes:
    """Add the columns of hyperplane splits and all rows on them but the samples'."""
    features, branches = range(problem.samples.n_features), heap.branches
    usable = np.array(usable_features(problem))[:, None]
    largest = usable * space.coefficient
    a = rows.columns("a", (features, branches), -largest, largest, integer=space.is_integer)
    s = rows.columns("s", (features, branches), 0.0, usable, cost=penalty, integer=True)
    b = rows.columns("b", (branches,), -space.reach, space.reach)
    d = rows.columns("d", (branches,), integer=True)
    flat_a, flat_s, flat_d = a.reshape(-1, 1), s.reshape(-1, 1), np.tile(d, len(features))[:, None]
    rows.add("read_above", -np.inf, 0, (flat_a, 1.0), (flat_s, -space.coefficient))
    rows.add("read_below", 0, np.inf, (flat_a, 1.0), (flat_s, space.coefficient))
    rows.add("read_if_split", -np.inf, 0, (flat_s, 1.0), (flat_d, -1.0))
    rows.add("split_reads", 0, np.inf, (s.T, 1.0), (d[:, None], -1.0))
    a_hat = None
    if not space.is_integer:
        a_hat = rows.columns("a_hat", (features, branches))
        rows.add("size_above", 0, np.inf, (a_hat.reshape(-1, 1), 1.0), (flat_a, -1.0))
        rows.add("size_below", 0, np.inf, (a_hat.reshape(-1, 1), 1.0), (flat_a, 1.0))
        rows.add("normal_size", -np.inf, 0, (a_hat.T, 1.0), (d[:, None], -1.0))
    rows.add("offset_above", -np.inf, 0, (b[:, None], 1.0), (d[:, None], -space.reach))
    rows.add("offset_below", 0, np.inf, (b[:, None], 1.0), (d[:, None], space.reach))
    if len(branches) > 1:
        parent = np.array([m // 2 - 1 for m in branches[1:]])
        rows.add("parent_splits", -np.inf, 0, (d[1:, None], 1.0), (d[parent][:, None], -1.0))
    if problem.shape.max_split_size < problem.samples.n_features:
        rows.add("split_size", -np.inf, 0, (s.T, 1.0), (d[:, None], -float(problem.shape.max_split_size)))
    if max_splits is not None:
        rows.add("max_splits", -np.inf, max_splits, (s.reshape(1, -1), 1.0))
    group = _add_groups(rows, problem, heap, s, d)
    return Hyperplanes(problem, space, mu, a, s, b, d, a_hat, group)


def usable_features(problem: Problem) -> list[bool]:
    """Return whether a split may read each feature: not constant, affordable, in some group of allowed_splits."""
    shape = problem.shape
    varies = problem.samples.features.min(axis=0) < problem.samples.features.max(axis=0)
    affordable = shape.sensor_costs[shape.sensor_index] <= shape.sensor_limit
    return [bool(varies[j] and affordable[j] and shape.is_allowed((j,))) for j in range(problem.samples.n_features)]


def _add_groups(rows: Rows, problem: Problem, heap: Heap, s: Columns, d: Columns) -> Columns | None:
    """Add that a node reads features of one group of allowed_splits only: s_jm <= sum of g_qm over groups q with j."""
    if problem.shape.allowed_splits is None:
        return None
    group = rows.columns("group", (range(len(problem.shape.allowed_splits)), heap.branches), integer=True)
    rows.add("one_group", 0, 0, (group.T, 1.0), (d[:, None], -1.0))
    member = np.array(
        [[j in g for g in problem.shape.allowed_splits] for j in range(problem.samples.n_features)], dtype=float
    )
    for t in range(s.shape[1]):
        rows.add("read_in_group", -np.inf, 0, (s[:, [t]], 1.0), (group[:, t][None, :], -member))
    return group


def choose_mu(space: Space, placed: Placed, heap: Heap) -> float:
    """Return the strictness mu by the rule of the module."""
    if space.is_exact:
        return 1.0
    widths = [MU_LARGEST]
    for m, split in placed.splits.items():
        width, _ = fit(space.normal_of(split), space.x, all_samples_band(placed, heap, m))
        widths.append(width * (1 - 1e-6))
    return max(min(widths), MU_SMALLEST)


def tolerance_for(mu: float) -> float:
    """Return the feasibility tolerance that HiGHS needs for a strictness mu."""
    return 1e-6 if mu >= 1e-3 else 1e-9


def all_samples_band(placed: Placed, heap: Heap, m: int) -> Band:
    """Return masks of the samples below the left and the right child of node m."""
    left, right = (np.isin(placed.position, heap.leaves_under(child)) for child in (2 * m, 2 * m + 1))
    return left, right
