"""Library: states of a twin, each with the strains that the twin predicts for it.

Near a state s the strains at load factor L are  L * (strains_s + slopes_s . delta),  delta uniform in the cell around s
(width 0: the state is a point), and a reading adds noise N(0, noise_sd^2) at every gauge, the same at every load.

Of a twin with several loads L is the multiple of one combination of them, the `reference`: a reading belongs to the
library where its loads stand in that ratio. Of a twin without loads it is 1.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import DataError, ProblemError, TwinError
from octmip.input.named_arrays import as_mapping, by_name, numbers_in
from octmip.twin import Load, Loads, Twin, amounts_of, load_of, load_words, loads_of, predict_states

Floats = NDArray[np.float64]
Applied = float | Mapping[str, float]
"""What is applied to a reading: the load factor, or all loads by name."""

RATIO = 1e-6
"""Relative rounding within which loads stand in a ratio, and readings are proportional to them."""


@dataclass(frozen=True, slots=True, eq=False)
class Library:
    """States of a twin with their strains.

    Attributes
    ----------
    parameters
        names of the state parameters.
    states
        (n_states, n_parameters) damage fractions, none twice.
    gauges
        names of the gauges, the order of every reading.
    strains
        (n_states, n_gauges) microstrain (or the twin's units) per unit of load factor, compressive positive.
    noise_sd
        (n_gauges,) of one reading at any load [microstrain]; one number: the same for all.
    widths
        (n_parameters,) width of the cell around each state; 0: a point.
    slopes
        (n_states, n_parameters, n_gauges) change of `strains` per unit of parameter; None: 0.
    only_load
        the one load factor that the strains hold for; None: strain is proportional to load.
    reference
        the loads that a load factor is a multiple of; None: the twin has one load, which is the load factor, and
        strains are per unit of it.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> library.index_of({"crack": 0.4}), library.state_names
    (1, ('crack=0', 'crack=0.4'))
    """

    parameters: tuple[str, ...]
    states: Floats
    gauges: tuple[str, ...]
    strains: Floats
    noise_sd: Floats | Any  # given as a number or a list too
    widths: Floats = field(default_factory=lambda: np.zeros(0))
    slopes: Floats = field(default_factory=lambda: np.zeros(0))
    only_load: float | None = None
    reference: Loads | None = None

    def __post_init__(self) -> None:
        n, p, g = len(np.atleast_1d(self.states)), len(self.parameters), len(self.gauges)
        empty_widths, empty_slopes = np.size(self.widths) == 0, np.size(self.slopes) == 0
        shapes: dict[str, tuple[ArrayLike, tuple[int, ...]]] = {
            "states": (self.states, (n, p)),
            "strains": (self.strains, (n, g)),
            "noise_sd": (np.broadcast_to(self.noise_sd, (g,)) if np.ndim(self.noise_sd) == 0 else self.noise_sd, (g,)),
            "widths": (np.zeros(p) if empty_widths else self.widths, (p,)),
            "slopes": (np.zeros((n, p, g)) if empty_slopes else self.slopes, (n, p, g)),
        }
        for name, (values, shape) in shapes.items():
            object.__setattr__(self, name, _frozen(values, name, shape))
        if len(np.unique(self.states, axis=0)) != n:
            raise ProblemError("states holds a state twice; expected every state once; drop the copies")
        if len(set(self.gauges)) != g:
            raise ProblemError(f"gauges names a gauge twice in {self.gauges}; name every gauge once")
        if not (self.noise_sd > 0).all():
            raise ProblemError(f"noise_sd is {self.noise_sd.min()}; expected more than 0 microstrain at every gauge")

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.states)

    @property
    def state_names(self) -> tuple[str, ...]:
        """The states in words, as "mu1=0.2 mu2=0.4"."""
        return tuple(
            " ".join(f"{name}={value:g}" for name, value in zip(self.parameters, row, strict=True))
            for row in self.states.tolist()
        )

    def index_of(self, state: Mapping[str, float]) -> int:
        """Return the index of a state given by name; what it does not name is 0.

        Raises
        ------
        ProblemError
            it names an unknown parameter, or is not in the library.
        """
        unknown = [name for name in state if name not in self.parameters]
        row = np.array([state.get(name, 0.0) for name in self.parameters])
        found = np.flatnonzero(np.isclose(self.states, row, rtol=0.0, atol=1e-9).all(axis=1))
        if unknown or not found.size:
            raise ProblemError(
                f"the library of {self.n_states} states has no state {dict(state)}; expected parameters "
                f"{self.parameters} at its levels; add the state"
            )
        return int(found[0])

    @property
    def asked_at(self) -> tuple[Load, float]:
        """The load that the twin is asked at, and its load factor."""
        factor = self.only_load or 1.0
        own = self.reference
        return (factor, factor) if own is None else (load_of(own.names, own.amounts), 1.0)

    def features(self, readings: Floats, load_factor: Applied) -> Floats:
        """Return readings (n, n_gauges) per unit of load factor, the features of the trees.

        Raises
        ------
        DataError
            the load factor is not positive, or one that the strains do not hold for.
        """
        return np.asarray(readings / self.checked_load(load_factor))

    def checked_loads(self, load_factor: Applied | Floats, n: int) -> Floats:
        """Return the load factors (n,) of readings, given one for all or one for each; loads by name are checked."""
        one = self.checked_load(load_factor) if isinstance(load_factor, Mapping) else load_factor
        return np.broadcast_to(np.asarray(one, dtype=np.float64), (n,))

    def checked_load(self, load_factor: Applied) -> float:
        """Return the load factor, given as such or as the loads by name.

        Raises
        ------
        DataError
            it is not a positive number, or one that the strains do not hold for; the loads have other names than the
            reference or do not stand in its ratio.
        """
        if isinstance(load_factor, Mapping):
            load_factor = self._multiple(load_factor)
        elif not isinstance(load_factor, float | int):
            given = numbers_in(load_factor, "load_factor").ravel()
            load_factor = float(given[0]) if len(given) == 1 else math.nan
        if not 0.0 < load_factor < np.inf:
            raise DataError(f"load_factor is {load_factor}; expected a positive number, 1 in steady level flight")
        if self.only_load is not None and load_factor != self.only_load:
            raise DataError(
                f"load_factor is {load_factor} but the library's twin is not linear in load and answered at "
                f"{self.only_load}; make a library for that load"
            )
        return load_factor

    def _multiple(self, loads: Mapping[str, float]) -> float:
        """Return how many times the reference some loads are."""
        own = self.reference
        if own is None or set(own) != set(loads):
            expected = "one number, the load factor" if own is None else f"the loads {list(own)}"
            raise DataError(f"the loads are {dict(loads)}; expected {expected}, as the library's twin has; give these")
        given, reference = numbers_in([loads[name] for name in own], "the loads"), np.array(own.amounts)
        factor = float(given @ reference / (reference @ reference)) if len(own) else 1.0
        if not np.allclose(given, factor * reference, rtol=0.0, atol=RATIO * float(np.abs(given).max(initial=0.0))):
            raise DataError(
                f"the loads are {dict(loads)}; expected a multiple of {own:g}, which the library's strains hold for; "
                "make a library for loads in this ratio"
            )
        return factor

    def with_state(self, state: Mapping[str, float], strains: Floats) -> "Library":
        """Return the library with one more state, `strains` (n_gauges,) per unit of load factor.

        A parameter that the library does not know becomes a new one, 0 in all other states.
        """
        parameters = (*self.parameters, *(name for name in state if name not in self.parameters))
        more = len(parameters) - len(self.parameters)
        states = np.pad(self.states, ((0, 1), (0, more)))
        states[-1] = [state.get(name, 0.0) for name in parameters]
        return Library(
            parameters,
            states,
            self.gauges,
            np.vstack([self.strains, strains]),
            self.noise_sd,
            np.pad(self.widths, (0, more)),
            np.pad(self.slopes, ((0, 1), (0, more), (0, 0))),
            self.only_load,
            self.reference,
        )


def default_levels(limit: float) -> list[float]:
    """Return the levels of a parameter for which none are given, up to 80 % of its limit, in few digits."""
    return [float(f"{level * limit:.12g}") for level in (0.0, 0.2, 0.4, 0.6, 0.8)]


def grid_states(levels: Sequence[Sequence[float]]) -> Floats:
    """Return all combinations (n_states, n_parameters) of levels, one sequence per parameter, the last fastest.

    >>> grid_states([[0.0, 0.4], [0.0, 0.2]]).tolist()
    [[0.0, 0.0], [0.0, 0.2], [0.4, 0.0], [0.4, 0.2]]
    """
    return np.array(list(itertools.product(*levels)), dtype=np.float64)


def library_of(
    twin: Twin,
    states: Floats,
    noise_sd: float | Sequence[float] | Mapping[str, float],
    *,
    gauges: Sequence[str] | None = None,
    widths: Sequence[float] = (),
    load_factor: Applied = 1.0,
) -> Library:
    """Return the library of a twin over states (n_states, n_parameters), in the order of `twin.parameters`.

    Parameters
    ----------
    gauges
        those to read; None: all of the twin.
    widths
        (n_parameters,) cells around the states; slopes are then differences across the cell, half of it kept within 0
        and 1.
    load_factor
        where a twin that is not linear in load is asked; the library holds for that load alone. Loads by name, which a
        twin with several needs: strains are those at these loads, as they are read, and the library holds for their
        multiples where the twin is linear, else for them alone.

    Raises
    ------
    ProblemError
        the twin lacks a gauge, or has other loads than are given.
    TwinError
        the twin says that it is linear in its loads, and is not.

    Examples
    --------
    >>> from octmip.gap import function_twin
    >>> def readings(own, loads):
    ...     return [loads["force"] * (100 + 50 * own["crack"]), loads["force"] * (200 - 80 * own["hole"])]
    >>> names = {"g1": "um/m", "g2": "um/m"}
    >>> twin = function_twin(readings, names, loads=["force"], states=["crack", "hole"], linear=True)
    >>> states = grid_states([[0.0, 0.4], [0.0, 0.5]])
    >>> library = library_of(twin, states, noise_sd=10.0, load_factor={"force": 1.0})
    >>> library.strains.tolist()
    [[100.0, 200.0], [100.0, 160.0], [120.0, 200.0], [120.0, 160.0]]
    """
    names = tuple(twin.gauges if gauges is None else gauges)
    missing = [name for name in names if name not in twin.gauges]
    if missing:
        raise ProblemError(f"the twin lacks the gauges {missing}; it has {list(twin.gauges)}; correct the names")
    columns = [twin.gauges.index(name) for name in names]
    states = np.array(states, dtype=np.float64)

    load = _applied(twin, load_factor)
    is_named = isinstance(load_factor, Mapping) or isinstance(load, Loads)
    reference = Loads(loads_of(twin), amounts_of(load)) if is_named else None
    factor = 1.0 if isinstance(load, Loads) or is_named else load

    def ask(at: Floats) -> Floats:
        return np.asarray(predict_states(twin, at, load)[:, columns] / factor)

    named = as_mapping(noise_sd)
    is_linear = bool(getattr(twin, "is_linear_in_load", False)) or not loads_of(twin)
    if is_linear and loads_of(twin):
        _refuse_bent(twin, states[:1], load)
    return Library(
        tuple(twin.parameters),
        states,
        names,
        ask(states),
        by_name(named, names, "noise_sd")[0][0]
        if isinstance(named, Mapping)
        else np.asarray(noise_sd, dtype=np.float64),
        np.array(widths, dtype=np.float64),
        _slopes(ask, states, widths, len(names)),
        None if is_linear else factor,
        reference,
    )


def _applied(twin: Twin, given: Applied) -> Load:
    """Return the load as the twin is asked for it."""
    names = loads_of(twin)
    by_name = dict(given) if isinstance(given, Mapping) else dict.fromkeys(names, given) if len(names) == 1 else {}
    if set(by_name) != set(names) or (names and not any(by_name.values())):
        raise ProblemError(
            f"load_factor is {given}; expected the twin's loads {list(names)} by name, not all 0; give them, such as "
            f"load_factor={dict.fromkeys(names, 1.0)}"
        )
    return load_of(names, tuple(by_name[name] for name in names))


def _refuse_bent(twin: Twin, states: Floats, load: Load) -> None:
    """Refuse a twin that says that it is linear in its loads where half of them is not half of the readings."""
    half = load_of(loads_of(twin), tuple(0.5 * amount for amount in amounts_of(load)))
    whole, halved = predict_states(twin, states, load)[0], predict_states(twin, states, half)[0]
    off = np.abs(halved - 0.5 * whole)
    if off.max(initial=0.0) > RATIO * np.abs(whole).max(initial=0.0):
        k = int(off.argmax())
        raise TwinError(
            f"the twin says that it is linear in its loads, but reading {twin.gauges[k]} is {whole[k]:g} at "
            f"{load_words(loads_of(twin), load)} and {halved[k]:g} at half of it; expected {0.5 * whole[k]:g}; leave "
            "out linear"
        )


def _slopes(ask: Callable[[Floats], Floats], states: Floats, widths: Sequence[float], n_gauges: int) -> Floats:
    """Return the change (n_states, n_parameters, n_gauges) of the strains across each cell, per unit of parameter."""
    slopes = np.zeros((len(states), states.shape[1], n_gauges))
    for k, width in enumerate(widths):
        low, high = states.copy(), states.copy()
        low[:, k], high[:, k] = np.maximum(states[:, k] - width / 2, 0.0), np.minimum(states[:, k] + width / 2, 1.0)
        if width > 0:
            slopes[:, k] = (ask(high) - ask(low)) / (high[:, k] - low[:, k])[:, None]
    return slopes


def _frozen(values: ArrayLike, name: str, shape: tuple[int, ...]) -> Floats:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ProblemError(f"{name} is no array of numbers ({error}); expected shape {shape}") from error
    if array.shape != shape:
        raise ProblemError(f"{name} has shape {array.shape}; expected {shape} of the library's states and gauges")
    if not np.isfinite(array).all():
        raise ProblemError(f"{name} holds {array[~np.isfinite(array)][0]}; expected finite numbers")
    array.flags.writeable = False
    return array
