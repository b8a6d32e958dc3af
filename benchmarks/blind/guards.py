"""Guards of a score: what shuffled keys score, and what luck does with groups of names so wide."""

from collections.abc import Sequence

import numpy as np

from benchmarks.blind.score import CLEAR, Pair, d_prime, names_of, top
from benchmarks.figure import Figure, share, statistic


def guards(cases: Sequence[Pair]) -> list[Figure]:
    """Return the guards' figures for pairs of diagnosis and opened key."""
    single = [(f, a) for f, a in cases if a["case"]["stratum"].startswith("single")]
    clear = [(f, a) for f, a in single if d_prime(f, a) >= CLEAR]
    return [
        share("this diagnosis, top-1 by its own groups", [top(f, a) for f, a in clear]),
        shuffled(clear),
        chance(clear),
        statistic("names in the first cause's groups", [sum(map(len, f["names"][0])) for f, _ in clear]),
    ]


def shuffled(clear: Sequence[Pair]) -> Figure:
    """Return top-1 against the keys of other cases, dealt out at random: it must score what `chance` says."""
    order = np.random.default_rng(0).permutation(len(clear))
    hits = [top(clear[k][0], clear[order[j]][1]) for j, k in enumerate(np.roll(order, 1))]
    return share("shuffled keys, top-1 by the diagnosis' groups", hits)


def chance(clear: Sequence[Pair]) -> Figure:
    """Return what luck scores with groups of these names: how often the names of a group are drawn, over all cases."""
    drawn = [names_of(a)[0] for _, a in clear]
    firsts = [f["names"][0] for f, _ in clear]
    hits = [drawn.count(name) / len(drawn) for groups in firsts if len(groups) == 1 for name in groups[0]]
    value = float(np.sum(hits)) / max(1, len(clear))
    return Figure("chance of groups so wide", value, value, value, len(clear))
