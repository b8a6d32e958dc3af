"""Gap times: how long a method took until its tree and its bound were within 10 %, 1 % and 0 % of each other."""

import math

from octmip.trees.solution import Progress, ProgressCallback, Solution, relative_gap

GAPS = (0.1, 0.01, 0.0)


class GapTimes:
    """The first time at which each gap was reached, by the reports of a solver and by its end.

    Reports come now and then, so a gap may have been reached a little earlier. Time is the solver's own, as in
    `Solution.seconds`: of one row no time is later than its end.
    """

    def __init__(self, show: ProgressCallback) -> None:
        self._show = show
        self._seconds: dict[float, float] = {}

    def __call__(self, state: Progress) -> None:
        """Note a report and hand it on."""
        self._note(relative_gap(state.objective, state.bound), state.seconds)
        self._show(state)

    def at_end(self, solution: Solution) -> dict[str, float | None]:
        """Return the seconds to each gap, by its percentage; None for those that were not reached."""
        self._note(0.0 if solution.is_optimal else solution.gap, solution.seconds)
        return {f"{100 * gap:g} %": self._seconds.get(gap) for gap in GAPS}

    def _note(self, gap: float, seconds: float) -> None:
        for wanted in GAPS:
            if gap <= wanted and not math.isnan(gap):
                self._seconds.setdefault(wanted, seconds)
