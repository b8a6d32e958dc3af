"""A writer of proof logs that knows no solver: every bound by enumeration, every cut recorded or a random part of them.

Slow and short, for small problems whose weights and costs are whole numbers.
"""

from collections.abc import Iterator
from functools import cache

import numpy as np

from octmip.trees.evidence.proof import proof_header
from octmip.trees.question.problem import Problem

Rows = tuple[int, ...]


def proof_log(problem: Problem, claim: int | None = None, *, keep: float = 1.0, seed: int = 0) -> str:
    """Return a log; claim None: the optimum. With keep < 1 cuts are left out, and the log may prove too little."""
    writer = _Writer(problem, keep, np.random.default_rng(seed))
    free = tuple(range(len(problem.shape.sensors)))
    body, proven = writer.sensors(free, ())
    header = proof_header(problem, (0, 0), proven if claim is None else claim)
    return header + "\n".join([*body, "end", ""])


class _Writer:
    def __init__(self, problem: Problem, keep: float, rng: np.random.Generator) -> None:
        self.problem, self.keep, self.rng = problem, keep, rng
        self.best = cache(self._best)

    def sensors(self, free: tuple[int, ...], taken: tuple[int, ...]) -> tuple[list[str], int]:
        """Decide sensor by sensor down to sets that can be paid for in full."""
        cost, limit = self.problem.shape.sensor_costs, self.problem.shape.sensor_limit
        free = tuple(s for s in free if cost[list(taken)].sum() + cost[s] <= limit)
        if cost[list(taken + free)].sum() > limit:
            without, one = self.sensors(free[1:], taken)
            with_it, other = self.sensors(free[1:], (*taken, free[0]))
            return [f"S {free[0]}", *without, *with_it], min(one, other)
        index, allowed = self.problem.shape.sensor_index, self.problem.shape.is_allowed
        features = tuple(f for f in range(len(index)) if index[f] in taken + free and allowed((f,)))
        rows, shape = tuple(range(self.problem.samples.n_samples)), self.problem.shape
        depth, leaf = shape.depth, shape.leaf_size
        return list(self.node(rows, features, depth, leaf)), self.best(rows, features, depth, leaf)

    def node(self, rows: Rows, features: tuple[int, ...], depth: int, leaf: int) -> Iterator[str]:
        yield f"N {depth} {leaf} {self.best(rows, features, depth, leaf)}"
        if depth > 2 and self.rng.random() < 0.9:
            yield from ["B", *self.node(rows, features, depth - 1, leaf)]
        for f in features:
            cuts = [cut for cut in self.cuts(rows, f) if self.rng.random() < self.keep]
            if depth == 2:
                yield " ".join(map(str, ["F", f, *np.diff([0, *(len(left) for left, _ in cuts)])]))
            for left, right in cuts if depth > 2 else []:
                yield f"K {f} {len(left)}"
                yield from ["L", *self.node(left, features, depth - 1, leaf)]
                yield from ["R", *self.node(right, features, depth - 1, leaf)]
        yield "E"

    def cuts(self, rows: Rows, feature: int) -> list[tuple[Rows, Rows]]:
        column = self.problem.samples.features[:, feature]
        values = sorted({float(column[i]) for i in rows})[:-1]
        sides = ([tuple(i for i in rows if (column[i] <= v) == side) for side in (True, False)] for v in values)
        return [(left, right) for left, right in sides]

    def _best(self, rows: Rows, features: tuple[int, ...], depth: int, leaf: int) -> int:
        found = int(self.problem.class_costs(np.array(rows)).min())
        for f in features if depth else ():
            for left, right in self.cuts(rows, f):
                if min(len(left), len(right)) >= leaf:
                    sides = [self.best(side, features, depth - 1, leaf) for side in (left, right)]
                    found = min(found, sum(sides) + int(self.problem.shape.leaf_penalty))
        return found
