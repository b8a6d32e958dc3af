"""Cost-complexity pruning: of all prunings of one tree those that are best for some price of a split.

The price at which a subtree of node t with m splits pays no more than the leaf in its place is

    g(t) = (R(leaf at t) - R(subtree of t)) / m

The node of least g becomes a leaf first (the weakest link), then that of the tree which is left, up to the root: a
nested sequence of trees that holds, for every price, the best pruning.

R is the cost of the problem; or, of classes, the Gini impurity by which CART grew, as scikit-learn prunes:

    R(leaf at t) = W - sum over classes c of W_c^2 / W      W_c weight of the class in the node, W of all of it

Source: Breiman, Friedman, Olshen & Stone (1984), Classification and Regression Trees, section 3.3.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from heapq import heapify, heappop, heappush

import numpy as np
from numpy.typing import NDArray

from octmip.trees.answer.solution import Solution, Stop
from octmip.trees.methods.ordering import ordered
from octmip.trees.nodes.tree import Leaf, Node, complexity, goes_left
from octmip.trees.question.problem import Problem

SMALL = 24
"""Prunings of fewer splits are all kept."""
RATIO = 1.15
"""Of larger ones each kept has so many times the splits of the next, so that a deep tree gives some dozens."""


@dataclass(slots=True)
class _Links:
    """The nodes of a tree in preorder as arrays (n_nodes,): what each costs as a leaf, and what its subtree costs."""

    leaves: list[Leaf]
    as_leaf: NDArray[np.float64]
    below: NDArray[np.float64]
    n_splits: NDArray[np.int64]
    right: NDArray[np.int64]  # -1 at a leaf; the left child is the next node
    parent: NDArray[np.int64]  # -1 at the root

    def prices(self) -> NDArray[np.float64]:
        """Return the price from which on each split is a leaf in the best pruning, -inf at leaves, shape (n_nodes,)."""
        found = np.full(len(self.leaves), -np.inf)
        link = self._links()
        order = [(gain, node) for node, gain in enumerate(link.tolist()) if np.isfinite(gain)]
        heapify(order)
        highest = 0.0
        while order:
            gain, weakest = heappop(order)
            if gain != link[weakest]:  # it was another's descendant, or its link has changed
                continue
            highest = max(highest, gain)
            end = self._end(weakest)
            is_left = np.isfinite(link[weakest:end])
            found[weakest:end][is_left] = highest
            link[weakest:end] = np.inf
            fewer, increase = self.n_splits[weakest], self.as_leaf[weakest] - self.below[weakest]
            node = int(self.parent[weakest])
            while node >= 0:
                self.n_splits[node] -= fewer
                self.below[node] += increase
                link[node] = (self.as_leaf[node] - self.below[node]) / max(1, self.n_splits[node])
                heappush(order, (float(link[node]), node))
                node = int(self.parent[node])
        return found

    def _links(self) -> NDArray[np.float64]:
        gain = (self.as_leaf - self.below) / np.maximum(1, self.n_splits)
        return np.asarray(np.where(self.right >= 0, gain, np.inf))

    def _end(self, node: int) -> int:
        """Return the number behind the last node of a subtree."""
        while self.right[node] >= 0:
            node = int(self.right[node])
        return node + 1


def prunings(problem: Problem, tree: Node) -> Iterator[Node]:
    """Yield prunings that are best for some price of a split, by rising price, from the largest to a single leaf.

    Of large trees not all are yielded (`RATIO`). Costs are sums of float64, not exact.
    """
    return (pruned for _, pruned in priced_prunings(problem, tree))


def priced_prunings(problem: Problem, tree: Node, *, by_impurity: bool = False) -> Iterator[tuple[float, Node]]:
    """Yield what `prunings` yields with the price from which on each is best; by impurity, of a problem of classes."""
    links = _links_of(problem, tree, by_impurity)
    prices = links.prices()
    rising = np.sort(prices[links.right >= 0])  # no split outlives those above it
    last = np.inf
    for price in np.unique(rising).tolist():
        size = len(rising) - int(np.searchsorted(rising, price, side="right"))
        if size < SMALL or size * RATIO <= last:
            last = size
            yield price, _pruned(tree, links, prices, price)


def _impurity(problem: Problem, rows: NDArray[np.int64]) -> float:
    weights = np.bincount(problem.samples.codes[rows], problem.samples.weights[rows])
    total = float(weights.sum())
    return total - float(weights @ weights) / total if total > 0 else 0.0


def _links_of(problem: Problem, tree: Node, by_impurity: bool) -> _Links:
    leaves: list[Leaf] = []
    as_leaf: list[float] = []
    right: list[int] = []
    parent: list[int] = []
    stack: list[tuple[Node, NDArray[np.int64], int, bool]] = [(tree, np.arange(problem.samples.n_samples), -1, False)]
    while stack:
        subtree, rows, above, is_right = stack.pop()
        here = len(leaves)
        leaf, cost = problem.leaf_and_cost(rows)
        leaves.append(leaf)
        as_leaf.append(_impurity(problem, rows) if by_impurity else cost)
        right.append(-1)
        parent.append(above)
        if is_right:
            right[above] = here
        if not isinstance(subtree, Leaf):
            left = goes_left(subtree, problem.samples.features, rows)
            right[here] = 0  # a split; its right child comes later
            stack += [(subtree.right, rows[~left], here, True), (subtree.left, rows[left], here, False)]
    links = _Links(leaves, *map(np.array, (as_leaf, as_leaf, np.zeros(len(leaves), np.int64), right, parent)))
    for node in range(len(leaves) - 1, -1, -1):
        if links.right[node] >= 0:
            sides = [node + 1, int(links.right[node])]
            links.below[node] = links.below[sides].sum()
            links.n_splits[node] = 1 + links.n_splits[sides].sum()
    return links


def _pruned(tree: Node, links: _Links, prices: NDArray[np.float64], price: float, at: int = 0) -> Node:
    """Return the pruning for a price; `at` is the number of the root in preorder."""
    if isinstance(tree, Leaf) or prices[at] <= price:
        return links.leaves[at]
    left = _pruned(tree.left, links, prices, price, at + 1)
    return replace(tree, left=left, right=_pruned(tree.right, links, prices, price, int(links.right[at])))


def pruned(problem: Problem, tree: Node, max_splits: int | None) -> Node:
    """Return the best pruning of a tree with at most `max_splits` features in its splits; the tree itself if it fits.

    A pruning has a leaf of the best label in place of some splits. The best one for every number of features follows
    from those of the two sides, so one pass from the leaves to the root finds it.
    """
    if max_splits is None or complexity(tree) <= max_splits:
        return tree
    most = max_splits

    def by_number(node: Node, rows: NDArray[np.int64]) -> list[tuple[float, Node]]:
        """Return cost and pruning for 0, 1, 2, ... features at most; more than the last number changes nothing."""
        leaf, cost = problem.leaf_and_cost(rows)
        best: list[tuple[float, Node]] = [(cost, leaf)]
        if isinstance(node, Leaf):
            return best
        is_left = goes_left(node, problem.samples.features, rows)
        lefts, rights = by_number(node.left, rows[is_left]), by_number(node.right, rows[~is_left])
        size = len(node.features)
        for number in range(1, min(most, complexity(node)) + 1):
            found = best[-1]
            for n_left in range(min(number - size, len(lefts) - 1) + 1):
                left, right = lefts[n_left], rights[min(number - size - n_left, len(rights) - 1)]
                cost = left[0] + right[0] + size * problem.shape.leaf_penalty
                if cost < found[0]:
                    found = cost, replace(node, left=left[1], right=right[1])
            best.append(found)
        return best

    return by_number(tree, np.arange(problem.samples.n_samples))[-1][1]


def fitting(problem: Problem, solution: Solution) -> Solution:
    """Return a solution whose tree has the shape of a shaped problem: pruned and put in order where it has not."""
    if solution.tree is None:
        return solution
    tree = ordered(problem, pruned(problem, solution.tree, problem.shape.max_splits))
    if tree is solution.tree:
        return solution
    stop = Stop.FINISHED if solution.stop is Stop.OPTIMAL else solution.stop
    return replace(solution, tree=tree, objective=problem.objective(tree), stop=stop)
