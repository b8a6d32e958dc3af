"""Trees handed to HiGHS while it runs."""

import pytest

from octmip import Leaf, Limits, Split
from octmip.mip.feed import Feed
from octmip.mip.oct import solve_oct
from tests.test_octmip.test_mip import stop_at_six, uci


def test_a_feed_hands_trees_to_highs_while_it_runs():
    best = Split(3, 0.8, Leaf(0), Split(3, 1.75, Leaf(1), Leaf(2)))
    with Feed(lambda turn: best, most_turns=1) as feed:
        poor = Split(0, 5.5, Leaf(0), Leaf(2))
        limits = Limits(seconds=120)
        solution = solve_oct(uci("iris", depth=2), limits=limits, incumbent=poor, inject=feed, progress=stop_at_six)
    assert solution.objective == 6


def test_what_a_feed_s_source_raises_comes_out():
    def source(turn):
        raise ValueError("the source is dry")

    with Feed(source) as feed, pytest.raises(ValueError, match="dry"):
        solve_oct(uci("iris", depth=2), limits=Limits(seconds=20), inject=feed)
