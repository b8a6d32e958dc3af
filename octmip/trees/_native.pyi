"""The native core: see octmip/trees/native/src/python.rs.

Every solver takes problem, incumbent, limits, threads, seed, switches, progress, in this order, then its own by name.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

class Problem:
    """A problem over dense ranks with integer costs, checked."""

    def __new__(
        cls,
        ranks: NDArray[np.uint32],
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
        planes: tuple[NDArray[np.float64], int, list[list[int]] | None, int | None] | None = None,
    ) -> Problem: ...

class SequentialProblem:
    """A problem of sequential sensing, checked."""

    def __new__(
        cls,
        ranks: NDArray[np.uint32],
        paid: NDArray[np.float64],
        frequency: NDArray[np.float64],
        delay_costs: NDArray[np.float64],
        shape: tuple[float, int, int, list[int], list[bool], list[int]],
        prices: tuple[list[float], list[int], list[float], list[int]],
        multiplier: float,
        cap: float | None,
    ) -> SequentialProblem:
        """Take the problem.

        `shape`: penalty, depth, leaf size, sensor of each feature, whether it may be used, most readings of each label.
        `prices`: cost and group of each sensor, set-up cost of each group, sensors read before the root.
        """

class Question:
    """What is asked, in float64 as given, for the checker of proof logs."""

    def __new__(
        cls,
        features: NDArray[np.float64],
        labels: NDArray[np.uint32],
        weights: NDArray[np.float64],
        costs: NDArray[np.float64],
        limits: tuple[int, bool, int, int, float],
        sensors: tuple[list[int], list[float], float],
        allowed_splits: list[list[int]] | None,
    ) -> Question:
        """Take the problem.

        `limits`: depth, whether splits are hyperplanes, features of a split, samples of a leaf, penalty of a feature.
        `sensors`: sensor of each feature, cost of each sensor, budget.
        """

    def identity(self) -> tuple[str, str, str]:
        """Return the error by its name, the sha256 of samples, labels and weights, and that of all the rest."""

    def check(self, log: str, n_threads: int) -> tuple[tuple[float, int, int] | None, tuple[int, str] | None]:
        """Return the bound that a log proves, its number of lines, the line of its claim; or where and why it fails."""

class RegressionQuestion:
    """A regression problem in float64 as given, for the checker of proof logs and their writer."""

    def __new__(
        cls,
        features: NDArray[np.float64],
        targets: NDArray[np.float64],
        weights: NDArray[np.float64],
        asked: tuple[tuple[int, int, int] | None, int, int, float],
        sensors: tuple[list[int], list[float], float],
    ) -> RegressionQuestion:
        """Take the problem.

        `asked`: slopes and what they are divided by (None: squared), depth, samples of a leaf, price of a split.
        `sensors`: sensor of each feature, cost of each sensor, budget.
        """

    def identity(self) -> tuple[str, str, str]:
        """Return the error by its name, the sha256 of samples, targets and weights, and that of all the rest."""

    def check(self, log: str) -> tuple[tuple[float, int, int] | None, tuple[int, str] | None]:
        """Return the bound that a log proves, its number of lines, the line of its claim; or where and why it fails."""

    def prove(self, scale: tuple[int, int, int, int], wanted: int) -> tuple[int, str, float] | None:
        """Return claim, body and bound of a log: `wanted`, or what the best tree costs. None if it was stopped.

        `scale`: exponents of weights, targets and costs of the log's grid.
        """

class NearProblem:
    """A problem whose trees are counted, its costs whole numbers."""

    def __new__(
        cls,
        problem: Problem,
        costs: tuple[list[int], list[int], list[int], int, int, int],
        above: list[int],
        is_narrow: bool,
        by_sets: bool,
    ) -> NearProblem:
        """Take the problem.

        `costs`: class and weight of each sample, cost of each label for each class, number of labels, penalty, and by
        how many binary digits a unit of `problem` is larger. `above`: columns that rank missing readings above others.
        """

    def count(
        self, limit: int, limit_values: LimitValues, n_threads: int, progress: NativeProgress | None
    ) -> tuple[list[NearEntry], list[NearCut], list[int], str, int]:
        """Return leaves, cuts of the root, features whose cuts are not all known, stop and evaluated cuts."""

    def trees(self, wanted: list[tuple[NearCut | None, int, int, int]]) -> list[list[NodeRow]] | None:
        """Return the trees of a cut (None: leaves), a cost, sensors, and a number each."""

    def readers(
        self, known: list[int], limit_values: LimitValues, n_threads: int
    ) -> tuple[list[int | None], str | None, int]:
        """Return the least cost of a tree that reads each sensor if below `known`, stop if early, evaluated cuts."""

    def predictions(self, limit: int, most: int, seconds: float) -> int | None:
        """Return the number of distinct predictions, None if some node has more than `most` or time is out."""

NearEntry = tuple[int, int, int]  # cost, sensors as bits, number of trees
# Feature, largest rank that goes left, samples left of it, bounds of both sides, trees.
NearCut = tuple[int, int, int, tuple[int, int], list[NearEntry] | None]
LimitValues = tuple[float, float, float, float]  # seconds, gap, nodes, memory
NativeProgress = Callable[[float, int, int, int], None]  # seconds, objective, bound, nodes
NodeRow = tuple[int, int, int, int, int, int, list[tuple[int, float]], float]
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
    lists: tuple[list[int], list[float], list[list[int]], list[bool | None], int],
    rows: NDArray[np.float64] | NDArray[np.float32],
) -> NDArray[np.uint32] | None:
    """Return the node that each row (n_samples, n_features), C-contiguous, ends at after as many steps as levels.

    Lists: feature, threshold, children and whether a missing reading goes right, by node. None: a reading is missing
    and its split has no side for it.
    """

def search(
    problem: Problem,
    incumbent: list[NodeRow] | None,
    limit_values: LimitValues,
    n_threads: int,
    seed: int,
    progress: NativeProgress | None = None,
    *,
    n_restarts: int,
    n_perturbations: int,
    submit: tuple[Callable[[Any, Any], Any], int] | None = None,
) -> tuple[list[NodeRow], int, int, str, int]:
    """Return node table, objective, bound, stop and number of visited nodes; the incumbent is a tree to begin with.

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

    def take(self, row: Any, limit_values: LimitValues, progress: NativeProgress | None = None) -> Any:
        """Take a turn within limits; return it, the nodes visited, and whether no limit has ended it."""
        ...

def branch_and_bound(
    problem: Problem,
    incumbent: tuple[int, list[NodeRow]] | None,
    limit_values: LimitValues,
    n_threads: int,
    off: list[str] = ...,
    progress: NativeProgress | None = None,
    *,
    checkpoint: tuple[float, Callable[[Any], None], Any] | None = None,
    submit: tuple[Callable[[int, Any], Any], int] | None = None,
) -> tuple[list[NodeRow], int, int, str, int]:
    """Return node table, objective, bound, stop and number of evaluated cuts.

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
    limit_values: LimitValues,
    progress: Callable[[float, int, int, int], None] | None = None,
    *,
    max_splits: int,
    directions: list[int],
) -> tuple[list[NodeRow], int, int, str, int]:
    """Return the best tree of a shape: node table, objective, bound, stop and evaluated cuts.

    `directions`: for each column 1 where predictions never fall as it rises, -1 where they never rise, 0 elsewhere.
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
    limit_values: LimitValues,
    n_threads: int,
    seed: int = 0,
    off: list[str] = ...,
    progress: NativeProgress | None = None,
    *,
    whole_coefficients: int | None = None,
    checkpoint: tuple[float, Callable[[tuple[Any, ...]], None], tuple[Any, ...] | None] | None = None,
) -> tuple[list[NodeRow], int, int, str, int]:
    """Return node table, objective, bound, stop and number of nodes; the incumbent is the cost of a feasible tree.

    Checkpoint: seconds between two times that the open nodes are handed out, who takes them, those of an earlier run.
    """

def two_feature_prunes() -> list[str]:
    """Return the names of all prunes and bounds of the two-feature core."""

def prove_two_feature(problem: Problem, claim: int, n_threads: int) -> str | None:
    """Return the body of a log that proves a claim about two-feature trees, None when stopped or not shown."""

def sequential(
    problem: SequentialProblem, room: float, limit_values: LimitValues
) -> tuple[list[NodeRow] | None, float, str, int]:
    """Return the node table of the best tree below the room (None: there is none), bound, stop and evaluated cuts."""

def regression(
    ranks: NDArray[np.uint32],
    n_ranks: list[int],
    targets: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float],
    shape: tuple[tuple[int, int] | None, float, int, int, list[bool]],
    room: float | None,
    n_threads: int,
    limit_values: LimitValues,
    progress: NativeProgress | None = None,
) -> tuple[list[NodeRow] | None, float, str, int]:
    """Return the node table of the best regression tree below the room (None: there is none), bound, stop and cuts.

    `targets`: targets, weights, rounded squares, the grid of the squares. `shape`: slopes (None: squared), price
    of a split, depth, leaf size, which features may be used.
    """

BandRow = tuple[NDArray[np.uint32], NDArray[np.uint32], int, int]  # lowest and highest ranks, most off, labels

def drift(
    problem: Problem,
    band_row: BandRow,
    incumbent: tuple[int, list[NodeRow]] | None,
    floor: int,
    limit_values: LimitValues,
    n_threads: int,
    progress: NativeProgress | None = None,
) -> tuple[list[NodeRow], int, int, str, int]:
    """Return the tree of least worst case to depth 2, its cost, the bound, stop and cuts of the root."""

def drift_search(
    problem: Problem,
    band_row: BandRow,
    starts: list[tuple[int, list[NodeRow]]],
    n_rounds: int,
    seed: int,
    limit_values: LimitValues,
) -> tuple[list[NodeRow], int, str]:
    """Return the best tree that changes of single nodes lead to, its cost, and stop."""
