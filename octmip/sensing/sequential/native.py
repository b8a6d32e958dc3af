"""The way to the native core of sequential acquisition and back: an Inspection as arrays, a node table as a tree."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip import _native
from octmip.encoding import Ranks, tree_from_rows
from octmip.sensing.sequential.problem import Inspection
from octmip.solution import Limits
from octmip.tree import Node, centred

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Answer:
    """What the core says: a tree below the room or none, and a bound of what was minimised."""

    tree: Node | None
    bound: float
    stop: str
    n_cuts: int


@dataclass(frozen=True, slots=True, eq=False)
class Core:
    """An inspection as the core takes it.

    Attributes
    ----------
    inspection
        the inspection.
    paid
        (n_samples, n_classes) weight times cost of telling each class.
    """

    inspection: Inspection
    paid: Floats

    @classmethod
    def of(cls, inspection: Inspection) -> "Core":
        """Return the core of an inspection."""
        problem = inspection.problem
        return cls(inspection, np.ascontiguousarray(problem.weights[:, None] * problem.costs[problem.codes]))

    def search(
        self,
        multiplier: float,
        room: float,
        limits: Limits,
        *,
        cap: float | None = None,
        rows: NDArray[np.int64] | None = None,
        depth: int | None = None,
        read: frozenset[str] = frozenset(),
    ) -> Answer:
        """Return the tree of least error + multiplier * cost below `room`; with a cap the least error within the cost.

        Args:
            multiplier: of the acquisition cost, summed over the samples' counts.
            cap: most acquisition cost, as such a sum.
            rows: the samples of a subtree; None: all.
            depth: its levels; None: the problem's.
            read: sensors read on the way to it.
        """
        problem = self.inspection.problem
        chosen = np.arange(problem.n_samples) if rows is None else rows
        features = np.ascontiguousarray(problem.features[chosen])
        ranks, values = _native.dense_ranks(features)
        asked = _native.SequentialProblem(
            ranks,
            np.ascontiguousarray(self.paid[chosen]),
            self.inspection.counts[chosen],
            self.inspection.haste[chosen],
            self._shape(problem.depth if depth is None else depth),
            self._prices(read),
            multiplier,
            cap,
        )
        allowance = (limits.seconds, limits.gap, limits.nodes, limits.memory)
        table, bound, stop, n_cuts = _native.sequential(asked, room, allowance)
        tree = None if table is None else centred(tree_from_rows(table, Ranks(ranks, tuple(values))), features)
        return Answer(tree, bound, stop, n_cuts)

    def _shape(self, depth: int) -> tuple[float, int, int, list[int], list[bool], list[int]]:
        problem = self.inspection.problem
        allowed = [problem.is_allowed((feature,)) for feature in range(problem.n_features)]
        sensors = problem.sensor_index.tolist()
        return problem.leaf_penalty, depth, problem.leaf_size, sensors, allowed, self.inspection.most_readings

    def _prices(self, read: frozenset[str]) -> tuple[list[float], list[int], list[float], list[int]]:
        problem, groups = self.inspection.problem, self.inspection.groups
        names, of_sensor = list(groups), self.inspection.group_of_sensor
        # A sensor in no group has one of its own that costs nothing to open.
        lone = len(names)
        index = [names.index(of_sensor[s]) if s in of_sensor else lone for s in problem.sensors]
        opening = [groups[name].opening for name in names] + [0.0]
        return problem.sensor_costs.tolist(), index, opening, [problem.sensors.index(s) for s in sorted(read)]

    @property
    def least_reading(self) -> float:
        """The least that the first reading of a path can cost."""
        return min(self.inspection.path_cost(frozenset([sensor])) for sensor in self.inspection.problem.sensors)

    @property
    def dearest_sum(self) -> float:
        """The most that all the samples' paths can cost."""
        inspection = self.inspection
        per_sensor = [inspection.path_cost(frozenset([sensor])) for sensor in inspection.problem.sensors]
        return math.fsum(sorted(per_sensor)[-inspection.problem.depth :]) * float(inspection.counts.sum())
