"""Gap times: the first report within a gap counts, and the solution at the end."""

import math

from octmip.interfaces.cli.gap_times import GapTimes
from octmip.trees.answer.solution import Progress, Solution, Stop
from octmip.trees.nodes.tree import Leaf


def test_the_first_report_within_a_gap_counts_and_the_end_closes_the_rest():
    shown: list[Progress] = []
    times = GapTimes(shown.append)
    for seconds, bound in ((1.0, -math.inf), (2.0, 95.0), (3.0, 96.0)):
        times(Progress(seconds, 100.0, bound, 0))
    times.end(Solution(Leaf(0), 100.0, 97.0, Stop.TIME, 4.0, 1, "exact", "1", 0))
    assert times.reached() == {"10 %": 2.0, "1 %": None, "0 %": None}
    assert times.gaps == [(2.0, 0.05), (3.0, 0.04), (4.0, 0.03)]
    assert len(shown) == 3


def test_the_end_is_timed_by_the_clock_of_the_solution():
    times = GapTimes(lambda state: None)
    times.end(Solution(Leaf(0), 100.0, 100.0, Stop.OPTIMAL, 0.25, 1, "exact", "1", 0))
    assert set(times.reached().values()) == {0.25}
