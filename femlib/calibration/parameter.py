"""What is fitted: a number with a physical range and, if something is known of it, a prior."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError, is_number


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a calibration.

    It is fitted on its own scale or on that of its logarithm: factors and moduli belong on the second.

    Attributes
    ----------
    name : str
        Name.
    start : float
        Value at which the fit begins.
    lower, upper : float
        Physical range: the fit never leaves it.
    prior_mean, prior_sd : float, optional
        Normal prior; `prior_sd` of a parameter on the log scale is that of its logarithm. No prior if not given.
    is_log : bool
        Fitted by its logarithm.
    meaning : str
        What it is, with its unit, for the report.
    """

    name: str
    start: float
    lower: float
    upper: float
    prior_mean: float | None = None
    prior_sd: float | None = None
    is_log: bool = False
    meaning: str = ""

    def __post_init__(self) -> None:
        ends = (self.lower, self.start, self.upper)
        if not all(map(is_number, ends)) or not self.lower < self.upper or not self.lower <= self.start <= self.upper:
            raise InputError(
                f"parameter {self.name} starts at {self.start!r} in {self.lower!r} to {self.upper!r}; expected finite "
                "numbers, the start within the range; correct them"
            )
        if self.is_log and self.lower <= 0.0:
            raise InputError(
                f"parameter {self.name} has the lower end {self.lower!r} and is fitted by its logarithm; expected more "
                "than 0; raise it"
            )
        if (self.prior_mean is None) != (self.prior_sd is None):
            raise InputError(
                f"parameter {self.name} has the prior mean {self.prior_mean!r} and sd {self.prior_sd!r}; expected both "
                "or neither; give the other"
            )
        if self.prior_sd is not None and not (is_number(self.prior_sd) and self.prior_sd > 0.0):
            raise InputError(
                f"parameter {self.name} has the prior sd {self.prior_sd!r}; expected more than 0; widen it"
            )
        if self.prior_mean is not None and not (
            is_number(self.prior_mean) and self.lower <= self.prior_mean <= self.upper
        ):
            raise InputError(
                f"parameter {self.name} has the prior mean {self.prior_mean!r}; expected {self.lower} to {self.upper}, "
                "its range; correct it"
            )

    def coordinate(self, value: float) -> float:
        """Return the coordinate in which the fit moves: the value or its logarithm."""
        return float(np.log(value)) if self.is_log else value

    def value(self, coordinate: float) -> float:
        """Return the value at a coordinate, within the range to the last digit."""
        return float(np.clip(np.exp(coordinate) if self.is_log else coordinate, self.lower, self.upper))

    def slope(self, value: float) -> float:
        """Return the derivative of the value by the coordinate."""
        return value if self.is_log else 1.0


def checked_parameters(parameters: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """Return parameters as a tuple.

    Raises
    ------
    InputError
        If there is none, one is no `Parameter`, or two share a name.
    """
    if not isinstance(parameters, Sequence) or not parameters or not all(isinstance(p, Parameter) for p in parameters):
        raise InputError(f"parameters are {parameters!r}; expected a list of Parameter; put at least one in a list")
    names = [parameter.name for parameter in parameters]
    double = sorted({name for name in names if names.count(name) > 1})
    if double:
        raise InputError(f"parameters share the names {double}; expected a different one for each; rename one")
    return tuple(parameters)


def coordinates(parameters: Sequence[Parameter], values: Sequence[float]) -> FloatArray:
    """Return the coordinates (n,) of values."""
    return np.array([p.coordinate(value) for p, value in zip(parameters, values, strict=True)])
