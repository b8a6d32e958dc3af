"""Groups: samples of the same features and class, which no tree can tell apart, with the earning of each label."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import Ranks
from octmip.trees.mip.prices import Prices
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Groups of equal samples, and the pairs (group, label) that earn something.

    Attributes
    ----------
    sample
        (n_groups,) one sample of each group.
    size
        (n_groups,) how many samples it has.
    pair_group, pair_label
        (n_pairs,) group and label of each pair.
    earning
        (n_pairs,) what the whole group earns by that label over its most expensive one: positive.
    """

    sample: NDArray[np.int64]
    size: NDArray[np.int64]
    pair_group: NDArray[np.int64]
    pair_label: NDArray[np.int64]
    earning: NDArray[np.float64]

    @property
    def heaviest(self) -> int:
        """The group that may earn most."""
        return int(self.pair_group[self.earning.argmax()]) if len(self.earning) else 0


def group_samples(problem: Problem, ranks: Ranks, prices: Prices) -> Groups:
    """Return the groups of a problem; a group that weighs nothing stays only where leaf sizes are counted."""
    keys = np.column_stack([ranks.ranks.T.astype(np.int64), prices.profile])
    _, sample, group, size = np.unique(keys, axis=0, return_index=True, return_inverse=True, return_counts=True)
    weight = np.bincount(group.ravel(), prices.weights, len(sample))
    if problem.shape.leaf_size == 1:
        sample, size, weight = sample[weight > 0], size[weight > 0], weight[weight > 0]
    costs = prices.costs[prices.profile[sample]]
    earning = weight[:, None] * (costs.max(axis=1, keepdims=True) - costs)
    pair_group, pair_label = np.nonzero(earning > 0)
    return Groups(sample, size, pair_group, pair_label, earning[pair_group, pair_label])
