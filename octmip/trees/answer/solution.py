"""The result of every solver: one tree, one bound, and why it stopped."""

import enum
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any

from octmip.errors import ProblemError, SolverError
from octmip.input.messages import InWords
from octmip.trees.answer.interruption import is_heard
from octmip.trees.nodes.tree import Node, depth, first_lines, n_splits


class Stop(enum.StrEnum):
    """Reason for which a solver stopped.

    >>> Stop.TIME == "time"
    True
    """

    OPTIMAL = "optimal"  # the bound meets the objective
    FINISHED = "finished"  # a heuristic did all it had set out to do; no proof
    GAP = "gap"  # the gap asked for is reached
    TIME = "time"
    NODES = "nodes"
    MEMORY = "memory"
    NUMERICS = "numerics"  # all that arithmetic allows is done; the bound holds but does not prove the tree optimal
    INTERRUPTED = "interrupted"


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits at which a solver stops early. Reaching one is no error: best tree and bound come back.

    Attributes
    ----------
    seconds
        wall time [s].
    gap
        relative gap ``(objective - bound) / objective`` that is good enough.
    nodes
        search nodes.
    memory
        bytes that the solver's own tables may take.

    Examples
    --------
    >>> problem = Problem([[0], [1], [2]], ["a", "b", "a"], depth=2)
    >>> solve(problem, limits=Limits(seconds=60.0)).stop
    <Stop.OPTIMAL: 'optimal'>
    """

    seconds: float = math.inf
    gap: float = 0.0
    nodes: float = math.inf
    memory: float = 8 * 2.0**30

    def __post_init__(self) -> None:
        for name in ("seconds", "gap", "nodes", "memory"):
            value = getattr(self, name)
            if not isinstance(value, Real) or not float(value) >= 0:  # nor NaN
                raise ProblemError(f"limit {name} is {value}; expected a number of 0 or more")

    def remaining(self, started: float, n_nodes: int = 0) -> "Limits":
        """Return the limits less the seconds since `started` (of `time.perf_counter`) and the nodes already spent.

        No second is left to a call that was interrupted.
        """
        seconds = 0.0 if is_heard() else self.seconds - (time.perf_counter() - started)
        return replace(self, seconds=max(0.0, seconds), nodes=max(0.0, self.nodes - n_nodes))


@dataclass(frozen=True, slots=True)
class Progress:
    """A solver's state while it runs: seconds since its start, best objective, proven bound, nodes.

    >>> Progress(seconds=2.0, objective=15.0, bound=12.0, n_nodes=300).bound
    12.0
    """

    seconds: float
    objective: float
    bound: float
    n_nodes: int


ProgressCallback = Callable[[Progress], None]


def relative_gap(objective: float, bound: float) -> float:
    """Return ``(objective - bound) / objective``: 0 when they meet, +inf without a tree or without a proof."""
    if bound >= objective:
        return 0.0
    if math.isinf(objective) or math.isinf(bound):
        return math.inf
    return (objective - bound) / max(abs(objective), 1e-300)


def is_tolerable(tolerance: float, least_saving: float) -> bool:
    """Whether a bound within this tolerance of an objective proves its tree optimal: 0, or less than can be saved.

    `least_saving` is `Problem.least_saving`, or `Problem.least_saving` of the tree's objective; it may
    underflow to 0.
    """
    return tolerance == 0 or 0 < tolerance < least_saving


def closing_tolerance(objective: float, bound: float, least_saving: float, rounding: float | None = None) -> float:
    """Return how far a bound is from the objective of a tree that a finished search found; -1 if too far for a proof.

    The distance is rounding alone. It proves the tree optimal if `is_tolerable`, the `rounding` of the objective
    included, by which the tree may cost more than it says (None: half a unit in its last place); beyond, two trees may
    have been taken for equal.
    """
    distance = max(0.0, objective - bound)
    while objective - distance > bound:
        distance = math.nextafter(distance, math.inf)
    hidden = distance + (math.ulp(objective) / 2 if rounding is None else rounding)
    return distance if is_tolerable(hidden, least_saving) else -1.0


@dataclass(frozen=True, slots=True, repr=False)
class Solution(InWords):
    """A tree with its objective and the bound below which no tree of the problem lies.

    Attributes
    ----------
    tree
        the best tree found, None without one (then `objective` is +inf).
    objective
        ``sum_i weights_i * costs[label_i, predicted_i] + leaf_penalty * complexity``.
    bound
        proven lower bound of the objective of every tree in `scope`; -inf without a proof.
    stop
        why the solver stopped.
    seconds
        wall time [s].
    n_nodes
        search nodes (0 where the notion has none).
    solver, version
        what computed it.
    seed
        of its random choices.
    tolerance
        how far `bound` may stand from `objective` and still meet it: 0 where weights and costs are integers,
        always below the problem's `least_saving` (a solver that cannot keep that says `Stop.NUMERICS`, not optimal).
    details
        what else the solver has to say (ties broken, strictness, model size); JSON values only.

    Examples
    --------
    >>> solution = solve(Problem([[0], [1], [2]], ["a", "b", "a"], depth=1))
    >>> solution.objective, solution.bound, solution.is_optimal
    (1.0, 1.0, True)
    """

    tree: Node | Any  # None is rare: a program that a checker of types reads need not ask for it each time
    objective: float
    bound: float
    stop: Stop
    seconds: float
    n_nodes: int
    solver: str
    version: str
    seed: int
    tolerance: float = 0.0
    details: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if math.isnan(self.objective) or math.isnan(self.bound):
            raise SolverError(
                f"{self.solver} returned objective {self.objective} and bound {self.bound}; NaN is no proof"
            )
        if (self.tree is None) != (self.objective == math.inf):
            has = "without" if self.tree is None else "with"
            raise SolverError(f"{self.solver} returned objective {self.objective} {has} a tree; expected +inf iff none")
        object.__setattr__(self, "details", dict(self.details))

    def with_bound(self, bound: float) -> "Solution":
        """Return the solution with a bound that is known besides, where that one is higher."""
        if bound <= self.bound:
            return self
        closer = replace(self, bound=min(bound, self.objective))
        is_proven = closer.meets_bound and closer.stop is not Stop.INTERRUPTED
        return replace(closer, stop=Stop.OPTIMAL) if is_proven else closer

    def __str__(self) -> str:
        """Return objective, bound and proof, the solver, and the tree, features and classes by their index."""
        return "\n".join(self._said() if self.tree is None else (*self._said(), "", *first_lines(self.tree)))

    def __repr__(self) -> str:
        """Return objective, bound and proof, the size of the tree and the solver on one line."""
        return f"Solution({'; '.join(self._said())})"

    def _said(self) -> tuple[str, str]:
        """Return what was proven, and by whom, a line each."""
        found = f"{self.solver} {self.version}, {self.seconds:.3g} s, stop: {self.stop}"
        if self.tree is None:
            return f"no tree found, bound {self.bound:.6g}", found
        proof = "proven optimal" if self.meets_bound else f"gap {100 * self.gap:.3g} %"
        if math.isinf(self.bound):
            proof = "no proof"
        elif self.scope:
            proof += f" among {self.scope}"
        splits = f"{n_splits(self.tree)} split" + ("" if n_splits(self.tree) == 1 else "s")
        head = f"objective {self.objective:.6g}, bound {self.bound:.6g}: {proof}"
        return head, f"depth {depth(self.tree)}, {splits}; {found}"

    @property
    def gap(self) -> float:
        """Relative gap between objective and bound; 0 when they meet within `tolerance`."""
        return 0.0 if self.meets_bound else relative_gap(self.objective, self.bound)

    @property
    def scope(self) -> str:
        """The trees that the bound is about, in words, where these are not all trees of the problem; "" for all."""
        scope = str(self.details.get("scope", "all"))
        return "" if scope.startswith("all") else scope

    @property
    def meets_bound(self) -> bool:
        """Whether the bound proves that no tree in `scope` is better (by more than `tolerance`)."""
        is_said = self.tree is not None and self.stop is not Stop.NUMERICS
        return is_said and self.bound >= self.objective - self.tolerance

    @property
    def is_optimal(self) -> bool:
        """Whether the bound proves that no tree of the problem is better (by more than `tolerance`)."""
        return self.meets_bound and not self.scope


class ProofError(SolverError):
    """The proof log that was asked for cannot be written; the solution without it is `solution`."""

    def __init__(self, message: str, solution: Solution) -> None:
        super().__init__(message)
        self.solution = solution
