"""A parameter of a model as an effect: the asset's value is not the model's.

The size is the asset's value less the nominal one, within the parameter's range. Its signature is a finite difference
of the model; the exact forward map asks the model at the value itself, so a model that bends is not taken as linear.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.gap.doors.card import Range
from octmip.twin import PURE, State, Twin

Floats = NDArray[np.float64]
Ask = Callable[[State, Any, Mapping[str, float]], Floats]
"""State, load and values of parameters that are not nominal -> readings (n_gauges,)."""

SHARE = 0.25
"""Prior sd over the width of the range: the range reaches two standard deviations to either side of its middle."""
STEP = 0.25
"""Step of the finite difference over the prior sd: small beside the curvature of a model that is tabulated or rough."""
BENT = 0.1
"""Relative error of the signature at each reading: it is a line, and models bend. Of 30 draws of the three twins of the
documentation one more is named with it, a storey softer by 38 %; with 0.12 a stiffness is taken for a gain."""


@dataclass(frozen=True, slots=True, eq=False)
class ParameterEffect:
    """The asset's value of one parameter differs from the model's.

    Attributes
    ----------
    name
        of the parameter.
    range
        its values.
    ask
        the model.

    The others are those of `octmip.twin.Effect`.
    """

    name: str
    range: Range
    ask: Ask
    parameter: str
    unit: str
    prior_sd: float
    prior_source: str
    separated_by: str
    is_one_sided: bool
    bounds: tuple[float, float]
    words: str
    action: str
    says: tuple[str, str]
    load_power: int | None = None
    prior_mean: float = 0.0
    signature_error: float = BENT

    @property
    def _sign(self) -> float:
        """-1 where the nominal value is the greatest: the size is then how far it falls."""
        return -1.0 if self.range.nominal == self.range.high else 1.0

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the one place, the whole."""
        return ("",)

    def signature(self, twin: Twin, state: State, load_factor: Any, place: str = "", time: float = 0.0) -> Floats:
        """Return the change of the readings (n_gauges,) per unit of size, by a finite difference about the nominal."""
        low, high = self.bounds
        ahead, behind = min(STEP * self.prior_sd, high), max(-STEP * self.prior_sd, low)
        change = self._at(state, load_factor, ahead) - self._at(state, load_factor, behind)
        return np.asarray(change / (ahead - behind))

    def predict(self, twin: Twin, state: State, load_factor: Any, size: float, place: str, time: float) -> Floats:
        """Return the readings (n_gauges,) with the parameter moved: what the model itself says, within its range."""
        size = min(max(size, self.bounds[0]), self.bounds[1])
        moved = self._at(state, load_factor, size) - self._at(state, load_factor, 0.0)
        return np.asarray(twin.predict(state, load_factor) + moved)

    def _at(self, state: State, load: Any, size: float) -> Floats:
        return self.ask(state, load, {self.name: self.range.nominal + self._sign * size} if size else {})


def parameter_effect(name: str, own: Range, ask: Ask) -> ParameterEffect:
    """Return the effect that a parameter with a range is another than the model's."""
    called, width = name.replace("_", " "), own.high - own.low
    is_at_end, below = own.nominal in (own.low, own.high), own.nominal == own.high
    unit = "" if own.unit in PURE else f" {own.unit}"
    of, way = f"the model's {own.nominal:g}{unit}", "below" if below else "above"
    return ParameterEffect(
        name=name,
        range=own,
        ask=ask,
        parameter=f"{called} {way} {of}",
        unit=own.unit,
        prior_sd=(2 * SHARE if is_at_end else SHARE) * width,
        prior_source=f"the range {own.low:g} to {own.high:g}{unit}",
        separated_by=f"a measurement of the {called} itself shows it",
        is_one_sided=is_at_end,
        bounds=(0.0, width) if is_at_end else (own.low - own.nominal, own.high - own.nominal),
        words=called,
        action=f"correct the {called}",
        says=(f"it is {{size}} {way} {of}", f"it is {{size}} below {of}"),
    )
