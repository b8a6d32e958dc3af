"""An amount above the optimum on a command line: `3`, or `1%` of the optimum."""

import argparse
from dataclasses import dataclass
from fractions import Fraction

from octmip.errors import DataError
from octmip.input.messages import shown

MOST = Fraction(10) ** 300


@dataclass(frozen=True, slots=True)
class Amount:
    """Units of cost, or a share of the optimum: one of the two."""

    within: float | None
    relative: Fraction | None

    def above(self, optimum: float) -> float:
        """Return the amount in units of cost."""
        return self.within if self.within is not None else float((self.relative or 0) * Fraction(optimum))


def add_amount(group: argparse._ArgumentGroup, default: str) -> None:
    """Add --within."""
    group.add_argument(
        "--within",
        metavar="A",
        default=default,
        help="trees up to A above the optimum, in units of cost or as A%% of it (default "
        f"{default.replace('%', '%%')})",
    )


def amount_of(text: str) -> Amount:
    """Return the amount that a text means.

    Raises
    ------
    DataError
        it is no number of 0 or more, with or without a percent sign.
    """
    try:
        value = Fraction(text.removesuffix("%"))
    except (ValueError, ZeroDivisionError):
        value = Fraction(-1)
    if not 0 <= value < MOST:
        raise DataError(
            f"--within is {shown(text)}; expected an amount such as 3, or a share of the optimum such as 1%"
        )
    return Amount(None, value / 100) if text.endswith("%") else Amount(float(text), None)
