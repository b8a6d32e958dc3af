"""The native core: see octmip/trees/native/src/lib.rs.

Every solver takes problem, incumbent, limits, threads, seed, switches, progress, in this order, then its own by name.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding.ranks import NodeRow

class Limits(Protocol):
    """Limits of a call, as `octmip.trees.answer.solution.Limits` has them."""

    @property
    def seconds(self) -> float: ...
    @property
    def gap(self) -> float: ...
    @property
    def nodes(self) -> float: ...
    @property
    def memory(self) -> float: ...

class Found:
    """The best tree of a search as a node table, what no tree costs less than, and nodes or evaluated cuts."""

    rows: list[NodeRow]
    objective: int
    bound: int
    stop: str
    n_nodes: int

class FoundBelow:
    """The best tree below a cost (None: there is none), what no tree costs less than, and evaluated cuts."""

    rows: list[NodeRow] | None
    bound: float
    stop: str
    n_nodes: int

class Accepted:
    """What an accepted log proves, its number of lines, the line of its claim."""

    bound: float
    n_lines: int
    claim_line: int

class Refused:
    """Where and why a log is refused."""

    line: int
    reason: str

class ProvenBelow:
    """Claim, body and bound of a log of numbers."""

    claim: int
    body: str
    bound: float

class Counted:
    """All trees up to a cost; `cuts` of the root as `octmip.trees.near_sets.near_set.Cut` by name, `open` features."""

    leaves: list[NearEntry]
    cuts: list[dict[str, Any]]
    open: list[int]
    stop: str
    n_nodes: int

class Problem:
    """A problem over dense ranks with integer costs, checked."""

    def __new__(
        cls,
        *,
        ranks: RankTable,
        n_ranks: list[int],
        labels: NDArray[np.uint32],
        weights: NDArray[np.int64],
        costs: NDArray[np.int64],
        penalty: int,
        depth: int,
        leaf_size: int,
        sensor_of_feature: list[int],
        sensor_cost: list[float],
        sensor_limit: float,
        allowed: list[bool],
        planes: Mapping[str, Any] | None = None,
    ) -> Problem: ...

class Question:
    """What is asked, in float64 as given, for the checker of proof logs."""

    def __new__(
        cls,
        *,
        features: NDArray[np.float64],
        labels: NDArray[np.uint32],
        weights: NDArray[np.float64],
        costs: NDArray[np.float64],
        depth: int,
        is_hyperplane: bool,
        split_size: int,
        leaf_size: int,
        leaf_penalty: float,
        sensor_of_feature: list[int],
        sensor_cost: list[float],
        sensor_limit: float,
        allowed_splits: list[list[int]] | None,
    ) -> Question: ...
    def digests(self) -> tuple[str, str]:
        """Return the sha256 of samples, labels and weights, and that of all the rest."""

    def check(self, log: str, n_threads: int) -> Accepted | Refused:
        """Return what a log proves, or why it fails."""

class RegressionQuestion:
    """A regression problem in float64 as given, for the checker of proof logs and their writer."""

    def __new__(
        cls,
        *,
        features: NDArray[np.float64],
        targets: NDArray[np.float64],
        weights: NDArray[np.float64],
        slopes: tuple[int, int, int] | None,
        depth: int,
        leaf_size: int,
        leaf_penalty: float,
        sensor_of_feature: list[int],
        sensor_cost: list[float],
        sensor_limit: float,
    ) -> RegressionQuestion:
        """Take the problem; `slopes` is `octmip.trees.question.losses.exact_sums.Slopes`, None: squared errors."""

    def identity(self) -> tuple[str, str, str]:
        """Return the error by its name, the sha256 of samples, targets and weights, and that of all the rest."""

    def check(self, log: str) -> Accepted | Refused:
        """Return what a log proves, or why it fails."""

    def prove(self, scale: tuple[int, int, int, int], wanted: int) -> ProvenBelow | None:
        """Return a log that proves `wanted`, or what the best tree costs; None if it was stopped.

        `scale` is `octmip.trees.evidence.proof_log.LogScale`.
        """

class NearProblem:
    """A problem whose trees are counted, its costs whole numbers."""

    def __new__(
        cls,
        problem: Problem,
        costs: Mapping[str, Any],
        above: list[int],
        is_narrow: bool,
        by_sets: bool,
    ) -> NearProblem:
        """Take the problem.

        `costs` by name: class and weight of each sample, cost of each label for each class, number of labels, penalty,
        and by how many binary digits a unit of `problem` is larger (`shift`). `above`: columns that rank missing
        readings above others.
        """

    def count(self, limit: int, limit_values: Limits, n_threads: int, progress: NativeProgress | None) -> Counted:
        """Return all trees up to a cost."""

    def trees(self, wanted: Sequence[Any]) -> list[list[NodeRow]] | None:
        """Return trees, each asked for by an `octmip.trees.near_sets.near_set.Wanted`."""

    def readers(
        self, known: list[int], limit_values: Limits, n_threads: int
    ) -> tuple[list[int | None], str | None, int]:
        """Return the least cost of a tree that reads each sensor if below `known`, stop if early, evaluated cuts."""

    def predictions(self, limit: int, most: int, seconds: float) -> int | None:
        """Return the number of distinct predictions, None if some node has more than `most` or time is out."""

NearEntry = tuple[int, int, int]  # cost, sensors as bits, number of trees
NativeProgress = Callable[[float, int, int, int], None]  # seconds, objective, bound, nodes
__version__: str

class RankTable:
    """Dense ranks of every feature, held once by the core and by all problems that are made of it."""

    def __init__(self, ranks: NDArray[np.uint32]) -> None:
        """Copy ranks (n_features, n_samples)."""
        ...

    def column(self, feature: int) -> NDArray[np.uint32]:
        """Return a copy of the ranks (n_samples,) of a feature."""
        ...

    def array(self) -> NDArray[np.uint32]:
        """Return a copy of all ranks (n_features, n_samples)."""
        ...

    def of_rows(self, rows: NDArray[np.int64]) -> RankTable:
        """Return the ranks of some samples."""
        ...

def dense_ranks(features: NDArray[np.float64] | NDArray[np.float32]) -> tuple[RankTable, list[int]]:
    """Return ranks (n_features, n_samples) of features (n_samples, n_features), and each feature's distinct values."""

def reached_nodes(
    rows: NDArray[np.float64] | NDArray[np.float32],
    *,
    feature: list[int],
    threshold: list[float],
    children: list[list[int]],
    missing: list[bool | None],
    depth: int,
) -> NDArray[np.uint32] | None:
    """Return the node that each row (n_samples, n_features), C-contiguous, ends at after as many steps as levels.

    `missing`: whether a missing reading goes right, by node. None comes back where a reading is missing and its split
    has no side for it.
    """

def search(
    problem: Problem,
    incumbent: list[NodeRow] | None,
    limit_values: Limits,
    n_threads: int,
    seed: int,
    progress: NativeProgress | None = None,
    *,
    n_restarts: int,
    n_perturbations: int,
    submit: tuple[Callable[[Any, Any], Any], int] | None = None,
) -> Found:
    """Return a tree of low objective; the incumbent is a tree to begin with.

    `submit`: gives a turn of a restart and the limits that are left to somebody with a `TurnSolver` and returns a
    future, with the number of turns that are asked for at once; without it the threads of this process take the turns.
    """

class TurnSolver:
    """A problem ready for turns of its restarts, in a process that helps another one's search."""

    def __new__(
        cls, problem: Problem, incumbent: list[NodeRow] | None, seed: int, n_restarts: int, n_perturbations: int
    ) -> TurnSolver:
        """Take the problem, incumbent and options of the search that asks."""
        ...

    def take(self, row: Any, limit_values: Limits, progress: NativeProgress | None = None) -> Any:
        """Take a turn within limits; return it, the nodes visited, and whether no limit has ended it."""
        ...

def branch_and_bound(
    problem: Problem,
    incumbent: tuple[int, list[NodeRow]] | None,
    limit_values: Limits,
    n_threads: int,
    off: list[str] = ...,
    progress: NativeProgress | None = None,
    *,
    checkpoint: tuple[float, Callable[[Any], None], Any] | None = None,
    submit: tuple[Callable[[int, Any], Any], int] | None = None,
) -> Found:
    """Return the best tree and a bound.

    `incumbent`: objective and node table of a feasible tree. `checkpoint`: seconds between two states, who takes them,
    the state to begin with (see `octmip.trees.methods.checkpoint`) or None. `submit`: gives a cut of the root at a
    level to somebody with a `CutSolver` and returns a future, with the number of cuts in work at once (0: as on one
    machine); without it the threads of this process solve the cuts.
    """

def prove(
    problem: Problem,
    claim: int,
    n_threads: int = 1,
    *,
    submit: tuple[Callable[[int, Any], Any], int] | None = None,
) -> str | None:
    """Return the body of a log that proves a claim, None when stopped or when the claim does not hold.

    The same for any number of threads; `submit` as for `branch_and_bound`, to a `CutSolver` that logs.
    """

def shaped_search(
    problem: Problem,
    incumbent: tuple[int, list[NodeRow]] | None,
    limit_values: Limits,
    progress: Callable[[float, int, int, int], None] | None = None,
    *,
    free: tuple[int, list[NodeRow]] | None = None,
    max_splits: int,
    directions: list[int],
    rules: dict[str, Any] | None = None,
) -> Found:
    """Return the best tree of a shape and a bound.

    `free`: cost and rows of the best tree without directions, where they are known.
    `directions`: for each column 1 where predictions never fall as it rises, -1 where they never rise, 0 elsewhere.
    `rules`: parts that are asked for, as `octmip.trees.encoding.parts.rules_of` returns them, not with directions;
    where no tree has them the objective is `octmip.trees.methods.native_call.NO_TREE`.
    """

def exact_bytes(problem: Problem, n_threads: int) -> float:
    """Return the bytes that the tables of an exact search may take, its queues left out."""

class CutSolver:
    """A problem ready for cuts of its root to be solved, in a process that helps another one's search."""

    def __new__(cls, problem: Problem, off: list[str], is_logged: bool) -> CutSolver:
        """Take the problem, the prunes that are switched off by name, and whether lines of a log are wanted."""
        ...

    def solve(self, level: int, row: Any) -> Any:
        """Solve a cut of the root of trees of `level` levels; None when Ctrl-C stopped it."""
        ...

def prunes() -> list[str]:
    """Return the names of all prunes of the exact core."""

def two_feature_branch_and_bound(
    problem: Problem,
    incumbent: int | None,
    limit_values: Limits,
    n_threads: int,
    seed: int = 0,
    off: list[str] = ...,
    progress: NativeProgress | None = None,
    *,
    whole_coefficients: int | None = None,
    checkpoint: tuple[float, Callable[[dict[str, Any]], None], tuple[Any, ...] | None] | None = None,
) -> Found:
    """Return the best tree and a bound; the incumbent is the cost of a feasible tree.

    Checkpoint: seconds between two times that the open nodes are handed out, who takes them, those of an earlier run.
    """

def two_feature_prunes() -> list[str]:
    """Return the names of all prunes and bounds of the two-feature core."""

def prove_two_feature(problem: Problem, claim: int, n_threads: int) -> str | None:
    """Return the body of a log that proves a claim about two-feature trees, None when stopped or not shown."""

def regression(
    room: float | None,
    limit_values: Limits,
    n_threads: int,
    progress: NativeProgress | None = None,
    *,
    ranks: NDArray[np.uint32],
    n_ranks: list[int],
    targets: NDArray[np.float64],
    weights: NDArray[np.float64],
    squares: NDArray[np.float64],
    grain: float,
    slopes: tuple[int, int, int] | None,
    penalty: float,
    depth: int,
    leaf_size: int,
    allowed: list[bool],
) -> FoundBelow:
    """Return the best regression tree that costs less than `room` (None: any).

    `squares` are rounded to the grid `grain`; `slopes` as `Slopes` of `octmip.trees.question.losses.exact_sums`, None:
    squared.
    """
