"""Every pair of error and reading cost that a tree can have, by exhaustive enumeration, in fractions.

Slow, short and exact: all cuts of all features at every node, all labels, the sensors read on the path as a set.
Imports nothing of octmip but the nouns that are asked about.
"""

from fractions import Fraction
from functools import cache

import numpy as np

from octmip.sensing.sequential.problem import SequentialProblem

Pair = tuple[Fraction, Fraction]


def front(sequential: SequentialProblem) -> list[Pair]:
    """Return the pairs (error with delay cost and penalty, reading cost over counts) that no tree beats in both."""
    problem = sequential.problem
    costs = [Fraction(float(c)) for c in problem.sensor_costs]
    group_of = {problem.sensors.index(s): g for g, group in sequential.groups.items() for s in group.sensors}
    within = [sequential.within.get(name, 99) for name in problem.class_names]
    delay_cost = [Fraction(float(sequential.delay_cost.get(name, 0))) for name in problem.class_names]
    counts = [Fraction(float(c)) for c in sequential.counts]

    def price(read: frozenset[int]) -> Fraction:
        touched = {group_of[s] for s in read if s in group_of}
        setup = sum(Fraction(sequential.groups[g].setup_cost) for g in touched)
        return sum((costs[s] for s in read), Fraction(0)) + setup

    def told(rows: frozenset[int], label: int, read: frozenset[int]) -> Pair:
        error, cost = Fraction(0), Fraction(0)
        for i in rows:
            code = int(problem.codes[i])
            error += Fraction(float(problem.weights[i])) * Fraction(float(problem.costs[code, label]))
            error += delay_cost[code] * len(read)
            cost += counts[i] * price(read)
        return error, cost

    @cache
    def pairs(rows: frozenset[int], levels: int, read: frozenset[int]) -> tuple[Pair, ...]:
        found = [told(rows, k, read) for k in range(problem.n_classes) if len(read) <= within[k]]
        for feature in range(problem.n_features) if levels else ():
            if not problem.is_allowed((feature,)):
                continue
            after = read | {int(problem.sensor_index[feature])}
            for low in np.unique(problem.features[sorted(rows), feature])[:-1]:
                left = frozenset(i for i in rows if problem.features[i, feature] <= low)
                if min(len(left), len(rows - left)) >= problem.leaf_size:
                    sides = [pairs(side, levels - 1, after) for side in (left, rows - left)]
                    penalty = Fraction(problem.leaf_penalty)
                    found += [(a[0] + b[0] + penalty, a[1] + b[1]) for a in sides[0] for b in sides[1]]
        return tuple(_undominated(found))

    return list(pairs(frozenset(range(problem.n_samples)), problem.depth, frozenset()))


def _undominated(found: list[Pair]) -> list[Pair]:
    kept: list[Pair] = []
    for error, cost in sorted(set(found)):
        if not kept or cost < kept[-1][1]:
            kept.append((error, cost))
    return kept
