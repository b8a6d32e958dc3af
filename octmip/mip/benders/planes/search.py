"""The search: is there a tree cheaper than a target? Each case of the root is asked, and cores cut its master.

A solution of a master is a split of the root and the points kept on its sides. Where no split below tells those of one
side apart, a core of them is a cut for both sides and for every case. Where all are told apart
the solution is a tree, cheaper than the target. Where no master has a solution the target is a bound.

Targets lie halfway between bound and best tree, so that a run that is stopped has a bound.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.mip.benders.planes import master
from octmip.mip.benders.planes.question import Case, Question
from octmip.mip.benders.planes.separation import Separation
from octmip.mip.engine import Clock, LimitReachedError
from octmip.mip.highs import highs
from octmip.mip.rows import Rows
from octmip.solution import Stop
from octmip.tree import HyperplaneSplit, Leaf, Node

CORES = 3
"""So many cores without a common point are taken from one side of a solution."""


@dataclass(slots=True, eq=False)
class PlaneSearch:
    """The search for a tree cheaper than a target; its state can be read at any time.

    Attributes
    ----------
    question
        what is searched.
    clock
        of the run.
    seed
        of HiGHS.
    report
        called while HiGHS runs; may raise.
    cores
        found so far, each once.
    reached
        by case, the price that no tree of it lies below.
    n_masters
        solved so far.
    """

    question: Question
    clock: Clock
    seed: int
    report: Callable[[], None]
    separation: Separation = field(init=False)
    cores: list[NDArray[np.int64]] = field(default_factory=list)
    reached: dict[Case, int] = field(init=False)
    n_masters: int = 0

    def __post_init__(self) -> None:
        self.separation = Separation(self.question, self._check)
        self.reached = self.question.cases()

    @property
    def bound(self) -> float:
        """No tree of the question is cheaper; infinite if no split is allowed."""
        return min(self.reached.values(), default=math.inf)

    def cheaper(self, target: int) -> Node | None:
        """Return a tree cheaper than a target, None if there is none."""
        for case in sorted(self.reached, key=lambda one: self.reached[one]):
            if self.reached[case] < target:
                tree = self._cheaper_in(case, target)
                if tree is not None:
                    return tree
                self.reached[case] = target
        return None

    def _cheaper_in(self, case: Case, target: int) -> Node | None:
        """Return a tree of a case that is cheaper than a target, None if there is none."""
        while True:
            rows = Rows(limit_check=self.clock.check)
            model = master.encode(self.question, case, target, self.cores, rows)
            values = self._solution(rows, self.question.tolerance)
            if values is None:
                return None
            kept = model.kept(values)
            is_free = np.isin(self.question.code, list(set(case.labels[0]) & set(case.labels[1])))
            found = [core for points in kept for core in self._cores(points, is_free)]
            if not found:
                return self._tree(case, *model.split(values), kept)
            self.cores.extend(found)

    def _solution(self, rows: Rows, tolerance: float) -> NDArray[np.float64] | None:
        """Return a solution of a master, None if HiGHS proves that there is none."""
        self._check()
        if self.n_masters >= self.clock.limits.nodes:
            raise LimitReachedError(Stop.NODES)
        self.n_masters += 1
        options = highs.Options(limits=self.clock.left, seed=self.seed, tolerance=tolerance)
        outcome = highs.run(rows, options, progress=lambda _: self.report())
        if outcome.values is None and outcome.status in ("kInfeasible", "kUnboundedOrInfeasible"):
            return None  # its columns are bounded
        if outcome.values is None:
            raise LimitReachedError(outcome.stop)
        return outcome.values

    def _cores(self, points: NDArray[np.int64], is_free: NDArray[np.bool_]) -> Iterator[NDArray[np.int64]]:
        """Yield cores of some points, without a common point."""
        for _ in range(CORES):
            core = self.separation.core(points, is_free)
            if core is None:
                return
            yield core
            points = np.setdiff1d(points, core)

    def _tree(self, case: Case, normal: NDArray[np.float64], offset: float, kept: list[NDArray[np.int64]]) -> Node:
        """Return the tree of a solution: below the root a split between the classes that a side keeps."""
        left, right = (self._side(points) for points in kept)
        root = self.question.split(case.features, normal, offset - self.question.mu / 2)
        if root is None:
            return right if len(kept[1]) else left
        return HyperplaneSplit(root.features, root.coefficients, root.offset, left, right)

    def _side(self, points: NDArray[np.int64]) -> Node:
        codes = np.unique(self.question.code[points])
        if len(codes) < 2:
            return Leaf(int(codes[0]) if len(codes) else 0)
        split = self.separation.split(points)
        if split is None:
            return Leaf(int(codes[0]))
        return HyperplaneSplit(split.features, split.coefficients, split.offset, *(Leaf(int(k)) for k in codes))

    def _check(self) -> None:
        self.clock.check()
        self.report()
