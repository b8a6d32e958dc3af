"""A campaign of blocks of readings in memory: one for each test and load."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign
from octmip.input.named_arrays import by_name, numbers_in
from octmip.twin import Twin, loads_of, state_parameters, units_of


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """The repeats of one test at one load.

    Attributes
    ----------
    rows
        (n_repeats, n_readings): columns with names are matched by name, those of a data frame, a mapping or a
        structured array; others stand in the order of the twin's readings. One row may be given as (n_readings,).
        Masked, None and NA are missing readings.
    loads
        what was applied, by name.
    test
        name of the test.
    state
        known values of the twin's state parameters; those that are left out are 0, those that are NaN unknown.

    Examples
    --------
    >>> Recorded([[810.0, 300.0], [812.0, 299.0]], {"force": 1.0}).test
    'test'
    """

    rows: Any
    loads: Mapping[str, float] = field(default_factory=dict)
    test: str = "test"
    state: Mapping[str, float] = field(default_factory=dict)


def gathered(twin: Twin, recorded: Sequence[Recorded]) -> Campaign:
    """Return the campaign of all readings of a twin from blocks of them.

    Raises
    ------
    DataError
        a block of another width than the twin has readings, or without one of their names, a value that is no number,
        a load that is missing or unknown.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "microstrain"}, loads=["force"])
    >>> gathered(twin, [Recorded([[2.1], [1.9]], {"force": 1.0}, test="monday")]).test
    ('monday', 'monday')
    """
    names, parameters = loads_of(twin), state_parameters(twin)
    named = [by_name(one.rows, twin.gauges, f"test {one.test!r}") for one in recorded]
    blocks, extra = [rows for rows, _ in named], dict.fromkeys(name for _, more in named for name in more)
    for one in recorded:
        for what, given, known in (("loads", one.loads, names), ("state", one.state, parameters)):
            if not isinstance(given, Mapping):
                raise DataError(
                    f"test {one.test!r}: {what} as {type(given).__name__}; expected {list(known)}; give these by name"
                )
            unknown = [name for name in given if name not in known]
            missing = [name for name in known if name not in given] if what == "loads" else []
            if unknown or missing:
                raise DataError(f"test {one.test!r}: {what} {list(given)}; expected {list(known)}; give these by name")
    counts = [len(rows) for rows in blocks]
    loads = [[numbers_in(one.loads[name], f"test {one.test!r}, load {name!r}") for name in names] for one in recorded]
    applied = np.repeat(loads, counts, axis=0)
    states = np.repeat([[one.state.get(name, 0.0) for name in parameters] for one in recorded], counts, axis=0)
    nan = np.full(sum(counts), np.nan)
    return Campaign(
        gauges=twin.gauges,
        parameters=parameters,
        test=tuple(one.test for one, count in zip(recorded, counts, strict=True) for _ in range(count)),
        load_factor=applied[:, 0] if len(names) == 1 else applied.reshape(sum(counts), len(names)),
        states=states.reshape(sum(counts), len(parameters)),
        readings=np.concatenate(blocks),
        time=nan,
        temperature=nan,
        notes=(f"Columns that are no readings of the twin are not used: {', '.join(extra)}.",) if extra else (),
        load_names=names,
        units=units_of(twin),
    )
