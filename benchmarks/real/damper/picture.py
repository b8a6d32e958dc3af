"""The picture of docs/gap/damper.md: a measured loop with the twin's and the corrected one, and what sizes it has."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from benchmarks.real.damper.answers import SeriesVerdict
from benchmarks.real.damper.lacking import Found, modelled, with_extras
from benchmarks.real.damper.path import fitted
from benchmarks.real.damper.slack import slack_at, slack_force

INK, RED, BLUE = "#1b1f24", "#b3261e", "#2f6db3"


def picture(verdicts: Sequence[SeriesVerdict], path: str) -> None:
    """Draw one test of each series, fitted without it, and the slack of all tests over the stroke's speed."""
    figure, axes = plt.subplots(1, len(verdicts) + 1, figsize=(5 * len(verdicts) + 4, 4.2), layout="constrained")
    for axis, verdict in zip(axes, verdicts, strict=False):
        loop(axis, verdict)
    axes[0].legend(frameon=False, loc="center", fontsize=8, markerscale=5)
    slack(axes[-1], verdicts)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def loop(axis: Axes, verdict: SeriesVerdict) -> None:
    """Draw the loop of the series' middle test, predicted from the others."""
    there = np.unique(verdict.data.test)
    middle = there[len(there) // 2]
    known = verdict.data.of(there[there != middle]) if len(there) > 1 else verdict.data
    held = verdict.data.of([middle])
    reference = float(np.median(known.now))
    best = verdict.lacking.best
    path = fitted(best.path.kind, best.path.coordinate, known, best.path)
    corrected = with_extras(path, tuple(best.extras), known)
    twin = Found(fitted("twin", "stroke", known), {})
    axis.plot(held.position, held.force, ".", markersize=2, color=INK, label="measured")
    axis.plot(held.position, modelled(twin, held, reference), ".", markersize=2, color=RED, label="twin")
    axis.plot(held.position, modelled(corrected, held, reference), ".", markersize=2, color=BLUE, label="with slack")
    test = verdict.tests[int(middle)]
    axis.set(
        title=f"{verdict.name}: {test.name}, {test.frequency:g} Hz, {test.amplitude:g} in, predicted from the others"
    )
    axis.title.set_fontsize(9)
    axis.set(xlabel="displacement [in]", ylabel="force [kip]")


def slack(axis: Axes, verdicts: Sequence[SeriesVerdict]) -> None:
    """Draw the slack of each test over its largest speed."""
    for verdict, colour, marker in zip(verdicts, (BLUE, RED, INK) * len(verdicts), "os^" * len(verdicts), strict=False):
        force = slack_force(verdict.tests)
        speed = [2.0 * np.pi * test.frequency * test.amplitude for test in verdict.tests]
        axis.plot(
            speed,
            [slack_at(test, force) for test in verdict.tests],
            marker,
            color=colour,
            label=f"series {verdict.name}",
        )
        for size in verdict.lacking.sizes[:1]:
            axis.axhspan(size.low, size.high, color=colour, alpha=0.2)
    axis.set(
        xlabel="largest speed [in/s]",
        ylabel="slack at a reversal [in]",
        title="backlash, test by test",
        ylim=(0.0, 0.25),
    )
    axis.title.set_fontsize(9)
    axis.legend(frameon=False)
