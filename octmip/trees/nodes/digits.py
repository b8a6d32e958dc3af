"""Numbers of a tree as text: what is printed is the number that decides, to its last bit.

A threshold may lie anywhere between two neighbouring values of the training. `midpoint` takes the number of fewest
digits in the middle third of that gap, so that the rule that is stored is the one that a person reads, types off and
applies:

    neighbours                    mean                 threshold
    1.5         4.0               2.75                 2.75
    1700000960  1700001020        1700000990           1700001000
    48.1234727  48.1234737        48.123473200000006   48.123473

`exact` prints any float64 in the fewest digits that read back as the same one.
"""

from decimal import Decimal

FEWEST_DIGITS = 6
"""Digits that a threshold may have without being shortened: fewer would move it in tables of few values."""
MOST_DIGITS = 17


def midpoint(low: float, high: float) -> float:
    """Return a threshold with ``low <= threshold < high`` that is near their mean and has few digits.

    The mean of two neighbouring float64 values can round to the upper one, which would send `high` left; then it is
    `low`.
    """
    middle = low / 2 + high / 2
    if not low <= middle < high:
        return low
    sixth = high / 6 - low / 6
    for digits in range(FEWEST_DIGITS, MOST_DIGITS):
        short = float(f"{middle:.{digits}g}")
        if low <= short < high and abs(short - middle) <= sixth:
            return short
    return middle


def exact(number: float) -> str:
    """Return a number in the fewest digits that read back as the same float64, whole numbers without a point."""
    return repr(float(number) + 0.0).removesuffix(".0")  # no minus before a zero


def grouped(number: float) -> str:
    """Return `exact` with commas between groups of three digits, as pages have it: 1,700,001,000.5."""
    text = exact(number)
    return text if "e" in text else f"{Decimal(text):,f}"
