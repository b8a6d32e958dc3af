"""What each sensor is worth: the optimum without it, and the optimum of the trees that read it.

without   the optimum of the problem without the sensor's features: what the best tree costs if the sensor is missing.
          Where the best tree known does not read it, nothing is lost, and nothing is searched
forced    the least objective of the trees that read it. A split between two leaves of one label reads nothing
role      needed       without > limit: every tree of the near-optimal set reads it
          useless      forced > limit: no tree of the set reads it
          replaceable  some trees of the set read it and others do not

Costs are compared in exact arithmetic, as in the count of trees near the optimum. Where rounding leaves open which side
of the limit the optimum without a sensor lies on, the trees without it are counted.
"""

import enum
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.answer import interruption
from octmip.trees.answer.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.encoding.ranks import Ranks, cut_as_split
from octmip.trees.near_sets.counting import near_optimal
from octmip.trees.near_sets.whole_numbers import whole_problem
from octmip.trees.near_sets.without import Calls, Without, loss_of
from octmip.trees.nodes.tree import Leaf, Node, Split, goes_left
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import refuse_unknown

NO_TREE = math.inf


class Role(enum.StrEnum):
    """What a sensor is to the near-optimal trees."""

    NEEDED = "needed"
    REPLACEABLE = "replaceable"
    USELESS = "useless"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class SensorRole:
    """What one sensor is worth.

    Attributes
    ----------
    sensor
        its name.
    without
        the optimum without it.
    forced
        the least objective of a tree that reads it; +inf where no tree can.
    forced_is_proven
        whether no tree that reads it is better.
    role
        what it is to the near-optimal trees.
    instead
        sensors that the best tree without it reads and the best tree of all does not.
    """

    sensor: str
    without: Without
    forced: float
    forced_is_proven: bool
    role: Role
    instead: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SensorRoles:
    """The sensors of a problem, in its order.

    Attributes
    ----------
    problem
        whose sensors these are.
    solution
        the best tree with all sensors.
    limit
        the most that a near-optimal tree costs, exactly.
    roles
        of every sensor.
    pairs
        the optimum without each two of them, where asked for.
    stop
        FINISHED where everything is proven, else why not.
    seconds
        spent.
    """

    problem: Problem
    solution: Solution
    limit: Fraction
    roles: tuple[SensorRole, ...]
    pairs: tuple[Without, ...]
    stop: Stop
    seconds: float

    @property
    def is_proven(self) -> bool:
        """Whether every claim is proven."""
        losses = [*(role.without for role in self.roles), *self.pairs]
        return (
            self.solution.is_optimal
            and all(loss.is_proven for loss in losses)
            and all(role.forced_is_proven for role in self.roles)
        )


@interruption.whole_call()
def sensor_roles(
    problem: Problem,
    within: float = 0.0,
    limits: Limits = Limits(),  # noqa: B008 - frozen
    *,
    pairs: bool = False,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
) -> SensorRoles:
    """Return what each sensor is worth, one proof for each claim.

    Parameters
    ----------
    problem
        with ``split="axis"``.
    within
        trees up to so much above the optimum count as near-optimal.
    limits
        seconds and nodes of the whole; after Ctrl-C no search begins, and what is known is returned.
    pairs
        also the optimum without each two sensors.
    seed, n_jobs, progress
        of every search.

    Raises
    ------
    ProblemError
        the splits are hyperplanes, `within` is no number of 0 or more, or costs span too many digits.

    Examples
    --------
    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1, feature_names=["g1", "g2"])
    >>> [(one.sensor, str(one.role)) for one in sensor_roles(problem).roles]
    [('g1', 'needed'), ('g2', 'useless')]
    """
    refuse_unknown(problem, "sensor_roles")
    if problem.shape.split != "axis":
        raise ProblemError("sensors are weighed with splits over one feature but split is 'hyperplane'; use 'axis'")
    if not 0 <= within < math.inf:
        raise ProblemError(f"within is {within}; expected a number of 0 or more")
    started = time.perf_counter()
    calls = Calls(problem, limits, seed, n_jobs, progress, started)
    solution = calls.solve(problem, None)
    calls.known.append(loss_of(problem, (), solution))
    try:
        forced, proven = _forced(problem, solution, calls)
    except KeyboardInterrupt:
        interruption.note()
        forced, proven = _known_to_read(problem, calls.known[0]), False
    leaves = (problem.exact_objective(Leaf(label)) for label in range(problem.samples.n_classes))
    read = (cost for cost in forced if isinstance(cost, Fraction))
    limit = min([calls.known[0].cost, *leaves, *read]) + Fraction(within)
    roles = tuple(
        _role(calls.compared(calls.without((sensor,)), limit), calls.known[0], limit, forced[s], proven)
        for s, sensor in enumerate(problem.shape.sensors)
    )
    both = tuple(calls.without(pair) for pair in combinations(problem.shape.sensors, 2)) if pairs else ()
    found = SensorRoles(problem, solution, limit, roles, both, Stop.FINISHED, time.perf_counter() - started)
    if found.is_proven:
        return found
    return replace(found, stop=Stop.INTERRUPTED if interruption.is_heard() else calls.stop)


def _role(
    without: Without, best: Without, limit: Fraction, forced: Fraction | float, forced_is_proven: bool
) -> SensorRole:
    if without.least > limit:
        role = Role.NEEDED
    elif without.cost > limit or (forced > limit and not forced_is_proven):
        role = Role.UNKNOWN
    else:
        role = Role.USELESS if forced > limit else Role.REPLACEABLE
    instead = tuple(name for name in without.read if name not in best.read)
    return SensorRole(without.sensors[0], without, float(forced), forced_is_proven, role, instead)


def _known_to_read(problem: Problem, best: Without) -> list[Fraction | float]:
    """Return the cost of the best tree for the sensors that it reads, no tree for the others."""
    return [best.cost if name in best.read else NO_TREE for name in problem.shape.sensors]


def _forced(problem: Problem, solution: Solution, calls: Calls) -> tuple[list[Fraction | float], bool]:
    """Return the least objective of the trees that read each sensor, exact or infinite, and whether all are proven."""
    shape = problem.shape
    if interruption.is_heard():
        return _known_to_read(problem, calls.known[0]), False
    if sum(shape.sensor_costs) > shape.sensor_limit:
        return _forced_by_sets(problem, solution, calls)
    tree = solution.tree
    whole = whole_problem(problem, tree, by_sets=False)
    every = np.arange(problem.samples.n_samples)
    trees = [_reading(problem, whole.ranks, tree, sensor, every, shape.depth) for sensor in range(len(shape.sensors))]
    known = [whole.most + 1 if t is None else whole.units(problem.exact_objective(t)) for t in trees]
    # A sensor that no tree is known to read asks for all trees: first those of the others, then it.
    first = [min(cost, max([c for c in known if c <= whole.most], default=cost)) for cost in known]
    found, stop = _least(whole.native.readers, [cost + 1 for cost in first], calls)
    open_ones = [s for s, cost in enumerate(known) if cost > whole.most and found[s] is None]
    if open_ones and stop is None:
        wanted = [whole.most + 1 if s in open_ones else 0 for s in range(len(known))]
        more, stop = _least(whole.native.readers, wanted, calls)
        found = [more[s] if s in open_ones else found[s] for s in range(len(known))]
    costs = [cost if units is None else units for units, cost in zip(found, known, strict=True)]
    return [NO_TREE if cost > whole.most else whole.cost(cost) for cost in costs], stop is None


def _least(
    readers: Callable[..., tuple[list[int | None], str | None, int]], known: list[int], calls: Calls
) -> tuple[list[int | None], str | None]:
    limits = calls.remaining
    found, stop, _ = readers(known, replace(limits, gap=0.0), calls.n_jobs)
    if stop == Stop.INTERRUPTED:
        interruption.note()
    if stop is not None:
        calls.stop = Stop(stop)
    return found, stop


def _forced_by_sets(problem: Problem, solution: Solution, calls: Calls) -> tuple[list[Fraction | float], bool]:
    """Return the same under a budget of sensors: sets of trees, each twice as wide, until every sensor is read."""
    shape = problem.shape
    least: dict[str, Fraction | float] = dict.fromkeys(shape.sensors, NO_TREE)
    most = float(problem.samples.weights.sum() * problem.costs.max()) + shape.leaf_penalty * 2**shape.depth
    margin = max(problem.least_saving if math.isfinite(problem.least_saving) else most, most / 256)
    while True:
        counted = near_optimal(
            problem,
            within=margin,
            limits=calls.remaining,
            by_sets=True,
            most_predictions=0,
            incumbent=solution,
            n_jobs=calls.n_jobs,
        )
        least |= counted.least_reading
        if not counted.is_complete:
            calls.stop = counted.stop
            return [least[name] for name in shape.sensors], False
        if all(math.isfinite(cost) for cost in least.values()) or margin > most:
            return [least[name] for name in shape.sensors], True
        margin *= 2


def _reading(
    problem: Problem, ranks: Ranks, node: Node, sensor: int, rows: NDArray[np.int64], depth: int
) -> Node | None:
    """Return a good tree that reads a sensor: the given one, or one with its best cut in place of one lowest split."""
    if isinstance(node, Split) and problem.shape.sensor_index[node.feature] == sensor:
        return node
    candidates = []
    if depth >= 1 and (isinstance(node, Leaf) or depth == 1):
        candidates.append(_best_stump(problem, ranks, sensor, rows))
    if isinstance(node, Split):
        is_left = goes_left(node, problem.samples.features, rows)
        left = _reading(problem, ranks, node.left, sensor, rows[is_left], depth - 1)
        right = _reading(problem, ranks, node.right, sensor, rows[~is_left], depth - 1)
        candidates += [None if left is None else replace(node, left=left)]
        candidates += [None if right is None else replace(node, right=right)]
    found = [tree for tree in candidates if tree is not None]
    return min(found, key=lambda tree: _cost(problem, tree, rows), default=None)


def _cost(problem: Problem, node: Node, rows: NDArray[np.int64]) -> float:
    if isinstance(node, Leaf):
        return float(problem.class_costs(rows)[node.label])
    assert isinstance(node, Split)
    is_left = goes_left(node, problem.samples.features, rows)
    sides = _cost(problem, node.left, rows[is_left]) + _cost(problem, node.right, rows[~is_left])
    return sides + problem.shape.leaf_penalty


def _best_stump(problem: Problem, ranks: Ranks, sensor: int, rows: NDArray[np.int64]) -> Node | None:
    """Return the best split of some samples by a sensor's features into leaves of different labels."""
    shape = problem.shape
    best: tuple[float, Node] | None = None
    each = problem.samples.weights[rows, None] * problem.costs[problem.samples.codes[rows]]
    for column in [c for c in range(ranks.n_columns) if shape.sensor_index[ranks.feature(c)] == sensor]:
        feature = ranks.feature(column)
        own = ranks.column(column)[rows]
        order = np.argsort(own, kind="stable")
        values = own[order].astype(np.int64)
        k = np.flatnonzero(np.diff(values) > 0) + 1
        k = k[(k >= shape.leaf_size) & (len(rows) - k >= shape.leaf_size)]
        if len(k) == 0 or not shape.is_allowed((feature,)):
            continue
        sums = each[order].cumsum(axis=0)
        left, right = sums[k - 1], sums[-1] - sums[k - 1]
        pairs = left[:, :, None] + right[:, None, :] + np.where(np.eye(problem.samples.n_classes) == 1, np.inf, 0.0)
        at, a, b = (int(i) for i in np.unravel_index(pairs.argmin(), pairs.shape))
        if best is None or pairs[at, a, b] < best[0]:
            best = float(pairs[at, a, b]), cut_as_split(ranks, column, int(values[k[at] - 1]), Leaf(a), Leaf(b))
    return None if best is None else best[1]
