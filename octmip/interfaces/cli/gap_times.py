"""Gap times: the gap between a method's tree and its bound while it ran, and when it was 10 %, 1 % and 0 %."""

import math

from octmip.trees.solution import Progress, ProgressCallback, Solution, relative_gap

GAPS = (0.1, 0.01, 0.0)


class GapTimes:
    """The gap of a solver by its reports and its end.

    Reports come now and then, so a gap may have been reached a little earlier. Time is the solver's own, as in
    `Solution.seconds`: of one row no time is later than its end.

    Attributes
    ----------
    gaps
        (seconds, gap) each time that the gap became smaller; empty without a bound.
    """

    def __init__(self, show: ProgressCallback) -> None:
        self._show = show
        self.gaps: list[tuple[float, float]] = []

    def __call__(self, state: Progress) -> None:
        """Note a report and hand it on."""
        self._note(relative_gap(state.objective, state.bound), state.seconds)
        self._show(state)

    def end(self, solution: Solution) -> None:
        """Note the end."""
        self._note(0.0 if solution.meets_bound else solution.gap, solution.seconds)

    def reached(self) -> dict[str, float | None]:
        """Return the seconds to each of `GAPS`, by its percentage; None for those that were not reached."""
        return {f"{100 * gap:g} %": self.seconds_to(gap) for gap in GAPS}

    def seconds_to(self, wanted: float) -> float | None:
        """Return the seconds until the gap was as small as wanted, None where it never was."""
        return next((seconds for seconds, gap in self.gaps if gap <= wanted), None)

    def _note(self, gap: float, seconds: float) -> None:
        if gap < (self.gaps[-1][1] if self.gaps else math.inf):  # no NaN is
            self.gaps.append((seconds, gap))
