"""A stream of readings: one result for each, no memory but the belief, and no bad reading that ends it.

A reading is refused, with a sentence, when it holds NaN, infinity or a number beyond `MOST`, has another length, names
an unknown gauge, or has a load factor that is no positive number. A gauge that gave nothing is left out of the mapping
(or None, NA, an empty text): with a filter the reading is used without it, without one it is refused where the tree
asks for it.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, OctmipError
from octmip.input.messages import shown
from octmip.input.named_arrays import by_name, numbers_in
from octmip.monitor.belief import Belief
from octmip.monitor.filter import Filter
from octmip.monitor.finding import Finding
from octmip.monitor.leaf_likelihood import LeafLikelihood
from octmip.monitor.library import Applied
from octmip.monitor.selector import ModelSelector
from octmip.monitor.series import Series
from octmip.monitor.surprise import leaf_p_value
from octmip.monitor.watch import Watch

Floats = NDArray[np.float64]
Values = Sequence[float | None] | Mapping[str, float | None]
Reading = tuple[Applied, Values]
"""Load factor or loads by name, and readings: by gauge name, or one for each gauge in the library's order."""


MOST = 1e100
"""No reading is so large, but the largest double is what some programs write for none; its square has no place."""
PLAIN = frozenset({float, np.float64, type(None)})
"""Types of values that are taken as they are."""


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """The result of one reading.

    Attributes
    ----------
    number
        of the reading in the stream, from 0.
    state
        index of the selected state in the selector's library; None where a missing gauge leaves it open.
    belief
        after the reading; None without a filter.
    leaf_p_value
        of the leaf under the belief before the reading; None without a filter on leaves.
    p_value
        of the reading in the library; None without a watch.
    finding
        why the alarm was raised at this reading; None otherwise.
    left_out
        names of the gauges that the watch has found faulty so far.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> monitor = Monitor(ModelSelector(library, Split(0, 125.0, Leaf(0), Leaf(1))))
    >>> next(monitor.run([(1.0, [148, 201])])).state
    1
    """

    number: int
    state: int | None
    belief: Belief | None = None
    leaf_p_value: float | None = None
    p_value: float | None = None
    finding: Finding | None = None
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Refusal:
    """A reading that was not used.

    Attributes
    ----------
    number
        of the reading in the stream, from 0.
    words
        what is wrong with it.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> monitor = Monitor(ModelSelector(library, Split(0, 125.0, Leaf(0), Leaf(1))))
    >>> next(monitor.run([(1.0, [148])])).words
    'reading has 1 values; expected 2, one for each of g1, g2'
    """

    number: int
    words: str


@dataclass(frozen=True, slots=True, eq=False)
class Monitor:
    """A selector, with or without filter and watch, at work on the readings of one asset.

    Attributes
    ----------
    selector
        the tree.
    filter
        carries a belief from reading to reading; None: every reading by itself.
    watch
        tests for damage and faults outside the library; None: no test.
    start_state
        index in the filter's library that the asset starts in; None: unknown.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> tree = Split(0, 125.0, Leaf(0), Leaf(1))  # of the gauge g1
    >>> monitor = Monitor(ModelSelector(library, tree))
    >>> [result.state for result in monitor.run([(1.0, [101, 199]), (1.0, [148, 201])])]
    [0, 1]
    """

    selector: ModelSelector
    filter: Filter | None = None
    watch: Watch | None = None
    start_state: int | None = None
    _index: Mapping[str, int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        gauges = self.selector.library.gauges
        for part in (self.filter, self.watch):
            if part is not None and part.library.gauges != gauges:
                raise DataError(
                    f"filter and watch read {part.library.gauges}, the selector {gauges}; give all the same gauges"
                )
        object.__setattr__(self, "_index", {gauge: k for k, gauge in enumerate(gauges)})

    def run(self, readings: Iterable[Reading]) -> Iterator[Result | Refusal]:
        """Yield a result or a refusal for every reading, in their order."""
        belief = None if self.filter is None else self.filter.start(1, self.start_state)
        series = None if self.watch is None else Series(self.watch)
        for number, reading in enumerate(readings):
            try:
                load_factor, values = _parts(reading)
                if belief is None and series is None:
                    yield Result(number, self._select(self._row(values, False), load_factor))
                    continue
                row = self._row(values, True)
                heard = row if series is None else series.without_faulty(row)
                state = self._state(heard, load_factor)
                leaf_p, p_value, finding, left_out = None, None, None, tuple[str, ...]()
                if self.filter is not None and belief is not None:
                    leaf_p, belief = self._believed(belief, np.array([heard]), load_factor)
                if series is not None:
                    finding = series.observe(np.array(row), load_factor, self._state_of_watch(state))
                    p_value, left_out = series.p_value, series.left_out
                yield Result(number, state, belief, leaf_p, p_value, finding, left_out)
            except OctmipError as error:
                yield Refusal(number, str(error))

    def _row(self, values: Values, may_lack: bool) -> list[float]:
        """Return the strains in the library's order, NaN where a gauge gave nothing and may be missing."""
        index = self._index
        if isinstance(values, Mapping):
            unknown = values.keys() - index.keys()
            if unknown:
                raise DataError(
                    f"reading names the gauges {', '.join(sorted(map(str, unknown)))}, which the library lacks; it has "
                    f"{', '.join(index)}"
                )
            row = [values.get(gauge) for gauge in index]
        elif type(values).__name__ not in ("list", "tuple", "ndarray"):  # a series, a masked array
            own = by_name(values, tuple(index), "reading")[0].ravel().tolist()
            row = [None if math.isnan(value) else value for value in own]
        else:
            row = list(values)
            if len(row) != len(index):
                raise DataError(
                    f"reading has {len(row)} values; expected {len(index)}, one for each of {', '.join(index)}"
                )
        if not set(map(type, row)) <= PLAIN:
            row = [None if value is None else _number(gauge, value) for gauge, value in zip(index, row, strict=True)]
        if all(value is not None and -MOST < value < MOST for value in row):  # NaN is not
            return row  # type: ignore[return-value]
        for gauge, value in zip(index, row, strict=True):
            if value is None and not may_lack:
                raise DataError(f"reading lacks gauge {gauge}; give a number, or use a filter, which can do without it")
            if value is not None and not -MOST < value < MOST:
                raise DataError(f"reading of gauge {gauge} is {value}; expected microstrain; leave it out if unknown")
        return [math.nan if value is None else value for value in row]

    def _select(self, row: list[float], load_factor: Applied) -> int:
        load = self.selector.library.checked_load(load_factor)
        return self.selector.compiled.label([value / load for value in row])

    def _state(self, row: list[float], load_factor: Applied) -> int | None:
        """Return the selected state; None where a missing gauge leaves it open."""
        try:
            return self._select(row, load_factor)
        except DataError:
            if not any(map(math.isnan, row)):
                raise
            return None

    def _believed(self, belief: Belief, reading: Floats, load_factor: Applied) -> tuple[float | None, Belief]:
        """Return the p-value of the leaf, of a filter on leaves, and the belief after a reading (1, n_gauges)."""
        assert self.filter is not None
        expected, leaf_p = self.filter.advance(belief), None
        if isinstance(self.filter.likelihood, LeafLikelihood):
            leaf_p = float(leaf_p_value(self.filter.likelihood, expected, reading, load_factor)[0])
        return leaf_p, self.filter.observe(expected, reading, load_factor)

    def _state_of_watch(self, state: int | None) -> int:
        """Return the state of the watch's library that lies nearest to the selected one."""
        assert self.watch is not None
        if state is None:
            return 0
        told = self.selector.library.states[state]
        return int(np.abs(self.watch.library.states - told).sum(axis=1).argmin())


def _parts(reading: object) -> Reading:
    """Return the load and the values of what a stream holds.

    Raises
    ------
    DataError
        it holds something else.
    """
    if not isinstance(reading, tuple | list) or len(reading) != 2:
        raise DataError(f"reading is {shown(reading)}; expected a pair of load and values; give both")
    return reading[0], reading[1]


def _number(gauge: str, value: object) -> float | None:
    """Return what a gauge gave, None where it is an empty text or the NA of pandas.

    Raises
    ------
    DataError
        it is no number.
    """
    if type(value).__name__ == "NAType" or (isinstance(value, str) and not value.strip()):
        return None
    found = numbers_in(value, f"reading of gauge {gauge}")
    if found.ndim:
        raise DataError(f"reading of gauge {gauge} is {shown(value)}; expected one number; give one")
    return float(found)
