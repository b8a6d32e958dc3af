"""Loads that were not what was noted: the twin reads at (1 + s / 100) L by a factor, and at L + s by an offset."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError
from octmip.gap.effects.chain import ChainEffect, Moment, whole
from octmip.twin import Load, Loads, State, Twin

Floats = NDArray[np.float64]

STEP = 0.01
"""Step of the load, one unit of size: a per cent."""
OFFSET_SHARE = 0.02
"""Prior sd of a load's offset over the extent of what was applied."""


def _more_load(moment: Moment) -> Floats:
    """Return what a per cent of the load changes."""
    return _rise(moment, STEP * _amount(moment))


def _risen(moment: Moment, step: float) -> Floats:
    """Return what one unit more of a load changes: by a per cent of it, by a step where it is 0."""
    step = STEP * _amount(moment) or step
    return _rise(moment, step) / step


def _rise(moment: Moment, step: float) -> Floats:
    """Return what a step of the load changes (1, n_gauges); where a twin, as a table does, refuses it, one back."""
    try:
        return (moment.twin.predict(moment.state, _raised(moment, step)) - moment.readings)[None]
    except TwinError:
        return (moment.readings - moment.twin.predict(moment.state, _raised(moment, -step)))[None]


def _amount(moment: Moment) -> float:
    """Return the load that is wrong."""
    load = moment.load
    return dict(load.items())[moment.load_name] if isinstance(load, Loads) else load


def _raised(moment: Moment, amount: float) -> Load:
    """Return the load with the one that is wrong raised by an amount."""
    load = moment.load
    if not isinstance(load, Loads):
        return load + amount
    return Loads(load.names, tuple(v + amount if name == moment.load_name else v for name, v in load.items()))


@dataclass(frozen=True, slots=True, eq=False)
class LoadError(ChainEffect):
    """A load that is not what was noted: by a factor in per cent or, in its own unit, by an offset.

    Attributes
    ----------
    is_offset
        which of the two.
    signature_error
        relative sd of what it changes: as good as the twin.
    """

    is_offset: bool = False
    signature_error: float = 0.0

    def predict(self, twin: Twin, state: State, load: Load, size: float, place: str, time: float) -> Floats:
        """Return the readings (n_gauges,) at the load that was, exactly; of a table that has no such load, linearly."""
        moment = Moment(twin, state, load, load_name=self.load_name)
        try:
            return twin.predict(state, _raised(moment, size if self.is_offset else STEP * size * _amount(moment)))
        except TwinError:
            return np.asarray(moment.readings + size * self.change(moment)[0])


LOAD_FACTOR_ERROR = LoadError(
    name="load_factor_error",
    parameter="error of the load factor",
    unit="%",
    prior_sd=1.5,  # load cells and accelerometers are good to about one per cent
    separated_by="strain alone cannot tell it from a common gain or a modulus: a second load cell or a known mass does",
    change=_more_load,
    places_in=whole,
    seen_by=("applied_load",),
    words="error of the load factor",
    action="correct the load factor",
    says=("the load was {size} higher than noted", "the load was {size} lower than noted"),
)


def errors_of_load(load: str, extent: float, signature_error: float) -> list[LoadError]:
    """Return the error of a load of this name and, where it was applied over an extent in its unit, its offset."""
    called = load.replace("_", " ")
    factor = replace(
        LOAD_FACTOR_ERROR,
        signature_error=signature_error,
        name=f"{load}_error",
        parameter=f"error of the {called}",
        separated_by=f"a second instrument for the {called} shows it",
        words=f"error of the {called}",
        action=f"correct the {called}",
        says=(f"the {called} was {{size}} higher than noted", f"the {called} was {{size}} lower than noted"),
        load_name=load,
    )
    if not extent > 0.0:
        return [factor]
    sd = OFFSET_SHARE * extent
    offset = replace(
        factor,
        name=f"{load}_offset",
        parameter=f"offset of the {called}",
        unit="-",  # the twin says no units of its loads
        prior_sd=sd,
        is_offset=True,
        change=partial(_risen, step=0.1 * sd),
        separated_by=f"a second instrument for the {called}, or its reading at zero, shows it",
        words=f"offset of the {called}",
    )
    return [factor, offset]
