"""Gap times: the first report within a gap counts, and the solution at the end."""

import math

from octmip.cli.gap_times import GapTimes
from octmip.solution import Progress, Solution, Stop
from octmip.tree import Leaf


def test_the_first_report_within_a_gap_counts_and_the_end_closes_the_rest(monkeypatch):
    clock = iter([0.0, 1.0, 2.0, 3.0, 4.0])
    monkeypatch.setattr("octmip.cli.gap_times.time.perf_counter", lambda: next(clock))
    shown: list[Progress] = []
    times = GapTimes(shown.append)
    for bound in (-math.inf, 95.0, 96.0):
        times(Progress(0.0, 100.0, bound, 0))
    found = times.at_end(Solution(Leaf(0), 100.0, 97.0, Stop.TIME, 4.0, 1, "exact", "1", 0))
    assert found == {"10 %": 2.0, "1 %": None, "0 %": None}
    assert len(shown) == 3
