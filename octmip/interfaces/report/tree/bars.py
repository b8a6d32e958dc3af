"""The bars in a node's box: which classes a leaf holds, or where its number lies; at a split the histogram."""

from collections.abc import Sequence
from dataclasses import dataclass

from octmip.interfaces.report.tree.seen import Histogram

BAR, HISTOGRAM = 6, 40
"""Height of the bar of a leaf, and of the highest bar of a histogram [px]."""


@dataclass(frozen=True, slots=True)
class Bar:
    """A rectangle in the colour of a class, by its upper left corner."""

    x: float
    y: float
    width: float
    height: float
    label: int


def leaf_bars(shares: Sequence[float], x: float, foot: float, room: float) -> tuple[Bar, ...]:
    """Return bars side by side, one for each share of a class that is not 0, from the left end of the room."""
    bars, at = [], x - room / 2
    for label, share in enumerate(shares):
        if share:
            bars.append(Bar(at, foot - BAR, room * share, BAR, label))
            at += room * share
    return tuple(bars)


def histogram_bars(
    histogram: Histogram, x: float, foot: float, room: float
) -> tuple[tuple[Bar, ...], tuple[float, float, float]]:
    """Return the bars of a histogram, those of the classes on one another, and (x, top, bottom) of its threshold."""
    counts, bars = histogram.counts, []
    wide, scale = room / len(counts), HISTOGRAM / counts.sum(axis=1).max()
    for k, of_classes in enumerate(counts.tolist()):
        top = foot
        for label, count in enumerate(of_classes):
            if count:
                top -= scale * count
                bars.append(Bar(x - room / 2 + wide * k, top, wide, scale * count, label))
    at = x - room / 2 + wide * histogram.n_left
    return tuple(bars), (at, foot - HISTOGRAM - 2, foot + 3)
