"""Every way in which a line over two features, or a cut of one, can part the samples.

Exact: feature values enter as fractions. Every way of parting distinct points by a line is that of the line through two
of them, turned a little about a place on it, so the points on it come apart as a prefix and a suffix.
"""

from collections.abc import Iterable
from fractions import Fraction
from itertools import combinations

from octmip.trees.problem import Problem


def partings(problem: Problem) -> dict[int, set[tuple[int, frozenset[int]]]]:
    """Return for each side of each split (a bit mask of its left samples) the prices and features that make it."""
    found: dict[int, set[tuple[int, frozenset[int]]]] = {}
    columns = [[Fraction(value) for value in column] for column in problem.features.T.tolist()]
    everything = (1 << problem.n_samples) - 1

    def add(left: int, features: tuple[int, ...]) -> None:
        for side in (left, everything ^ left):
            found.setdefault(side, set()).add((len(features), frozenset(features)))

    for f in range(problem.n_features):
        if problem.is_allowed((f,)):
            for value in set(columns[f]):
                add(_mask(x <= value for x in columns[f]), (f,))
    for f, g in combinations(range(problem.n_features), 2):
        if problem.is_allowed((f, g)):
            points = list(zip(columns[f], columns[g], strict=True))
            for a, b in combinations(sorted(set(points)), 2):
                normal = (b[1] - a[1], a[0] - b[0])
                turn = [normal[0] * (p[0] - a[0]) + normal[1] * (p[1] - a[1]) for p in points]
                for end in {p for p, t in zip(points, turn, strict=True) if t == 0}:
                    for is_upper in (False, True):
                        sides = zip(points, turn, strict=True)
                        add(_mask(t > 0 or (t == 0 and (p > end) == is_upper) for p, t in sides), (f, g))
    return found


def _mask(bits: Iterable[bool]) -> int:
    return sum(1 << i for i, bit in enumerate(bits) if bit)
