"""The border to the native core of sequential sensing: the problem as arrays, a node table as a tree."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.sensing.sequential.problem import SequentialProblem
from octmip.trees import _native
from octmip.trees.encoding import Ranks, tree_from_rows
from octmip.trees.solution import Limits
from octmip.trees.tree import Node, centred

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CoreResult:
    """Result of one search of the core: a tree below the room or none, and a bound of what was minimised."""

    tree: Node | None
    bound: float
    stop: str
    n_cuts: int


@dataclass(frozen=True, slots=True, eq=False)
class Core:
    """A sequential problem as the core takes it.

    Attributes
    ----------
    sequential
        the problem.
    paid
        (n_samples, n_classes) weight times cost of predicting each class.
    """

    sequential: SequentialProblem
    paid: Floats

    @classmethod
    def of(cls, sequential: SequentialProblem) -> "Core":
        """Return the core of a sequential problem."""
        problem = sequential.problem
        return cls(sequential, np.ascontiguousarray(problem.weights[:, None] * problem.costs[problem.codes]))

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
    ) -> CoreResult:
        """Return the tree of least error + multiplier * cost below `room`; with a cap the least error within the cost.

        Parameters
        ----------
        multiplier
            of the reading cost, summed over the samples' counts.
        cap
            most reading cost, as such a sum.
        rows
            the samples of a subtree; None: all.
        depth
            its levels; None: the problem's.
        read
            sensors read on the way to it.
        """
        problem = self.sequential.problem
        chosen = np.arange(problem.n_samples) if rows is None else rows
        features = np.ascontiguousarray(problem.features[chosen])
        ranks = Ranks.of(features)
        asked = _native.SequentialProblem(
            ranks=ranks.ranks,
            paid=np.ascontiguousarray(self.paid[chosen]),
            frequency=self.sequential.counts[chosen],
            delay_costs=self.sequential.delay_costs[chosen],
            penalty=problem.leaf_penalty,
            depth=problem.depth if depth is None else depth,
            leaf_size=problem.leaf_size,
            sensor_of_feature=problem.sensor_index.tolist(),
            allowed=[problem.is_allowed((feature,)) for feature in range(problem.n_features)],
            most_readings=self.sequential.most_readings,
            **self._prices(read),
            multiplier=multiplier,
            cap=cap,
        )
        found = _native.sequential(asked, room, limits)
        tree = None if found.rows is None else centred(tree_from_rows(found.rows, ranks), features)
        return CoreResult(tree, found.bound, found.stop, found.n_nodes)

    def _prices(self, read: frozenset[str]) -> dict[str, Any]:
        problem, groups = self.sequential.problem, self.sequential.groups
        names, of_sensor = list(groups), self.sequential.group_of_sensor
        # A sensor in no group has one of its own that costs nothing to set up.
        lone = len(names)
        index = [names.index(of_sensor[s]) if s in of_sensor else lone for s in problem.sensors]
        setup_costs = [groups[name].setup_cost for name in names] + [0.0]
        return {
            "sensor_cost": problem.sensor_costs.tolist(),
            "group_of_sensor": index,
            "setup_costs": setup_costs,
            "read": [problem.sensors.index(s) for s in sorted(read)],
        }

    @property
    def least_reading(self) -> float:
        """The least that the first reading of a path can cost."""
        return min(self.sequential.path_cost(frozenset([sensor])) for sensor in self.sequential.problem.sensors)

    @property
    def highest_cost_sum(self) -> float:
        """The most that all the samples' paths can cost."""
        sequential = self.sequential
        per_sensor = [sequential.path_cost(frozenset([sensor])) for sensor in sequential.problem.sensors]
        return math.fsum(sorted(per_sensor)[-sequential.problem.depth :]) * float(sequential.counts.sum())
