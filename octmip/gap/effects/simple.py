"""An effect in one line: what it does to the readings, as a function of its size.

warm = SimpleEffect("warm", "K", 10.0, lambda readings, size: readings - 12.0 * size)
slip = SimpleEffect("slip", "mm", 0.5, lambda readings, size, load: readings * (1 - 0.1 * size * load))
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError
from octmip.twin import Effect, State, Twin

Floats = NDArray[np.float64]

SIGNATURE_ERROR = 0.1
"""Relative sd of the signature of an effect that does not say its own: models differ by some parts in a hundred.

Of 30 draws of the three twins of the documentation one more is named with it, a storey softer by 38 %; with 0.12 a
stiffness is taken for a gain."""


def in_test(name: str) -> str:
    """Return the place of an effect that acts in one test alone."""
    return f"test {name}"


def test_of(effect: Effect, place: str) -> str:
    """Return the test in which alone an effect acts at a place; "" for all tests."""
    return next((name for name in getattr(effect, "tests", ()) if place == in_test(name)), "")


@dataclass(frozen=True, slots=True, eq=False)
class SimpleEffect:
    """An effect of which only four things are said.

    Attributes
    ----------
    name
        in snake_case.
    unit
        of the size.
    prior_sd
        size that would be no surprise; sizes three times smaller and larger are looked for as well.
    apply
        the readings (n_gauges,) as the twin predicts them, and a size in `unit` -> the readings (n_gauges,) with the
        effect, exactly: it need not be linear, and with size 0 it changes nothing. A third argument gets the load (a
        float, or a mapping where the twin has several), a fourth the place, a fifth the state.
    at
        places where it may act, each its own; by default the whole.
    bounds
        least and greatest size that is possible; with a least of 0 it goes one way only.
    parameter, separated_by, words, action, says
        words: what the size measures, what would tell the effect from its likes, and those of `octmip.twin.Effect`.
    step
        of the finite difference that is its signature, over the prior sd.
    signature_error
        relative sd of what it changes: models of one thing differ by some parts in a hundred.
    slope
        state and load -> what a unit of its size changes about 0 (n_gauges,); None: by a finite difference.
    tests
        of a campaign in which it may have a size of its own: each is a place, "test " and its name.

    The others are those of `octmip.twin.Effect`.

    Examples
    --------
    >>> SimpleEffect("warm", "K", 10.0, lambda readings, size: readings - 12.0 * size).parameter
    'size of the warm'
    """

    name: str
    unit: str
    prior_sd: float
    apply: Callable[..., Any]
    at: tuple[str, ...] = ("",)
    bounds: tuple[float, float] = (-np.inf, np.inf)
    parameter: str = ""
    separated_by: str = ""
    prior_mean: float = 0.0
    load_power: int | None = None
    words: str = ""
    action: str = ""
    says: tuple[str, str] = ("", "")
    step: float = 0.1
    signature_error: float = SIGNATURE_ERROR
    slope: Callable[[State, Any], Floats] | None = None
    tests: tuple[str, ...] = ()
    n_arguments: int = field(init=False)

    def __post_init__(self) -> None:
        called = self.name.replace("_", " ")
        if not self.parameter:
            object.__setattr__(self, "parameter", f"size of the {called}")
        if not self.separated_by:
            object.__setattr__(self, "separated_by", f"a measurement of the {called} itself shows it")
        object.__setattr__(self, "n_arguments", _n_arguments(self.name, self.apply))

    @property
    def is_one_sided(self) -> bool:
        """Whether the size cannot be negative."""
        return self.bounds[0] >= 0.0

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the places where it may act."""
        return *self.at, *map(in_test, self.tests)

    def signature(self, twin: Twin, state: State, load_factor: Any, place: str = "", time: float = 0.0) -> Floats:
        """Return the change of the readings (n_gauges,) per unit of size about 0."""
        if self.slope is not None:
            return self.slope(state, load_factor)
        readings = np.asarray(twin.predict(state, load_factor), dtype=np.float64)
        step = self.step * self.prior_sd
        ahead, behind = min(step, self.bounds[1]), max(-step, self.bounds[0])
        high, low = (self._applied(readings, size, load_factor, place, state) for size in (ahead, behind))
        return np.asarray((high - low) / (ahead - behind))

    def predict(self, twin: Twin, state: State, load_factor: Any, size: float, place: str, time: float) -> Floats:
        """Return the readings (n_gauges,) with an effect of this size, exactly."""
        readings = np.asarray(twin.predict(state, load_factor), dtype=np.float64)
        return self._applied(readings, min(max(size, self.bounds[0]), self.bounds[1]), load_factor, place, state)

    def _applied(self, readings: Floats, size: float, load: Any, place: str, state: State) -> Floats:
        more = (load, place, state)[: self.n_arguments - 2]
        return np.asarray(self.apply(np.array(readings), size, *more), dtype=np.float64)


def _n_arguments(name: str, apply: Callable[..., Any]) -> int:
    """Return how many of readings, size, load, place and state a function takes."""
    try:
        kinds = [p.kind for p in inspect.signature(apply).parameters.values()]
    except (TypeError, ValueError) as error:
        raise TwinError(f"effect {name}: apply is no function of readings and size ({error}); give one") from error
    positional = sum(
        kind in (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD) for kind in kinds
    )
    if not 2 <= positional <= 5:
        raise TwinError(
            f"effect {name}: apply takes {positional} arguments; expected readings and size, then load, place and "
            "state if it needs them; change it"
        )
    return positional
