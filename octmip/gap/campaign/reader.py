"""The file of a campaign, validated cell by cell; every complaint names the row and the column.

Columns: ``test``, one for each of the twin's loads (``load_factor`` for a twin that announces none), one for each known
state parameter (fractions; empty is unknown), optional ``time`` [s] and ``temperature`` [deg C], then one for each
gauge under the twin's name. Any table is read as `octmip.formats.table` reads it; rows have the numbers that a text
editor shows. How names, units and times are understood stands in `octmip.gap.campaign.columns`.
"""

import re
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.table import Table
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.columns import CampaignColumns, read_columns
from octmip.gap.campaign.metered import looked_at
from octmip.gap.campaign.plausibility import Sheet, refuse_nonsense, warnings_on
from octmip.gap.twins import CachedTwin
from octmip.input.files import PathLike
from octmip.input.messages import shown
from octmip.twin import Twin, loads_of, sign_of, state_parameters, units_of

STATISTICS = frozenset(
    {"average", "avg", "mean", "median", "min", "minimum", "max", "maximum", "std", "stdev", "stdevs", "stdevp"}
    | {"stddev", "standarddeviation", "sd", "rms", "variance", "sum", "total", "subtotal", "grandtotal", "count"}
    | {"mittelwert", "standardabweichung", "stabw", "summe", "gesamtergebnis", "teilergebnis", "anzahl"}
    | {"moyenne", "écarttype", "médiane", "somme", "totalgénéral", "promedio", "totalgeneral"}
)
"""What spreadsheets and loggers call a row that is no reading, without marks and blanks."""
UNKNOWN_STATES = "Some states are unknown; the diagnosis marginalises over them."
HOTTEST = 150.0
"""Temperatures beyond this [deg C] are kelvin or Fahrenheit."""
MOST_LOAD = 1e9
"""Loads beyond this are no load on any structure, in whatever unit."""


def read_campaign(path: PathLike | Table, twin: Twin) -> Campaign:
    """Return the campaign in a file or table, its columns matched with the twin's gauges and state parameters.

    Raises
    ------
    DataError
        a missing column, a cell that is no number, a load left out, a test of two states, units a factor off or of
        another quantity, a turned sign, all readings equal; the message names the row and the column.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "microstrain"}, loads=["force"])
    >>> import pandas as pd
    >>> run = pd.DataFrame({"test": ["t", "t", "t"], "force": [1, 1, 2], "g1": [2.1, 1.9, 4.0]})
    >>> run.to_csv("run.csv", index=False)
    >>> read_campaign("run.csv", twin).load_factor.tolist()
    [1.0, 1.0, 2.0]
    """
    parameters, names, units = state_parameters(twin), loads_of(twin), units_of(twin)
    table = read_columns(path, twin.gauges, names, parameters)
    gauges = tuple(sorted((name for name in twin.gauges if name in table), key=lambda name: _position(table, name)))
    order = [twin.gauges.index(name) for name in gauges]
    tests = _tests(table)
    applied = np.array([_load_column(table, name) for name in names]).reshape(len(names), len(tests)).T
    readings = [
        table.in_unit(name, units[k], table.floats(name, words=True)) for name, k in zip(gauges, order, strict=True)
    ]
    time, how = table.time()
    temperature, converted = _temperature(table)
    campaign = Campaign(
        gauges=gauges,
        parameters=parameters,
        test=tests,
        load_factor=applied[:, 0] if len(names) == 1 else applied,
        states=_states(table, parameters, tests),
        readings=np.array([values for values, _ in readings]).T,
        time=time,
        temperature=temperature,
        numbers=table.numbers,
        load_names=names,
        units=tuple(units[k] for k in order),
    )
    healthy = np.zeros_like(campaign.readings)
    asked = twin if isinstance(twin, CachedTwin) else CachedTwin(twin)
    for load, rows in looked_at(campaign):
        healthy[rows] = asked.predict({}, load)[order]
    sheet = Sheet(campaign, healthy, sign_of(twin), tuple(range(len(gauges))))
    refuse_nonsense(sheet)
    told = (*table.notes, *(note for _, notes in readings for note in notes), *how, *converted)
    return replace(campaign, notes=(*told, *warnings_on(sheet), *_notes(table, twin, campaign)))


def _position(table: CampaignColumns, name: str) -> int:
    return table.table.columns.index(table.place[name])


def _temperature(table: CampaignColumns) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Return the temperatures (n_rows,) [deg C], NaN where there is none, and a note where they were converted."""
    return table.in_unit("temperature", "degC", _optional(table, "temperature"))


def _load_column(table: CampaignColumns, name: str) -> NDArray[np.float64]:
    """Return the loads of a column, none missing, none at which a twin's own numbers overflow.

    Newtons for load factors are found later, beside the twin's strains.
    """
    values = table.floats(name)
    missing, huge = np.flatnonzero(np.isnan(values)), np.flatnonzero(np.abs(values) > MOST_LOAD)
    if missing.size:
        raise DataError(
            f"row {table.numbers[missing[0]]}, column {name} is empty ({missing.size} such "
            f"row{'s' * (missing.size != 1)}); give it for every reading, or begin a row without one with #"
        )
    if huge.size:
        of = "a load factor, 1 in steady level flight," if name == "load_factor" else "a number"
        raise DataError(
            f"row {table.numbers[huge[0]]}, column {name} is {values[huge[0]]:g}; expected {of} of at most "
            f"{MOST_LOAD:g}; correct it"
        )
    return values


def _tests(table: CampaignColumns) -> tuple[str, ...]:
    tests = table.texts("test")
    for k, name in enumerate(tests):
        if not name:
            raise DataError(
                f"row {table.numbers[k]}, column test is empty; give every reading the name of its test, or begin the "
                "row with # if it holds no readings, but units or remarks"
            )
        if re.sub(r"[\W_]", "", name.lower()) in STATISTICS:
            raise DataError(
                f"row {table.numbers[k]}, column test is {shown(name)}, as a statistic of the rows above is called; "
                "expected the name of a test; delete the row, or give the test another name"
            )
    return tests


def _optional(table: CampaignColumns, name: str) -> NDArray[np.float64]:
    return table.floats(name) if name in table else np.full(len(table.table.frame), np.nan)


def _states(table: CampaignColumns, parameters: tuple[str, ...], tests: tuple[str, ...]) -> NDArray[np.float64]:
    """Return the states (n_rows, n_parameters); refuse what is no fraction, and a test of two states."""
    states = np.array([_optional(table, name) for name in parameters]).reshape(len(parameters), len(tests)).T
    bad = np.argwhere((states < 0.0) | (states >= 1.0))
    if len(bad):
        row, column = (int(k) for k in bad[0])
        raise DataError(
            f"row {table.numbers[row]}, column {parameters[column]} is {states[row, column]:g}; expected a fraction of "
            "0 to below 1 (0.2 for 20 %); correct it"
        )
    first: dict[str, int] = {}
    starts = np.array([first.setdefault(test, row) for row, test in enumerate(tests)])
    apart = np.argwhere(~np.isclose(states, states[starts], rtol=0.0, atol=1e-12, equal_nan=True))
    if apart.size:
        row, column = (int(k) for k in apart[0])
        here, there = (_shown(states[k, column]) for k in (row, starts[row]))
        raise DataError(
            f"row {table.numbers[row]}, column {parameters[column]} is {here} but row {table.numbers[starts[row]]} of "
            f"the same test {tests[row]!r} has {there}; expected one state per test; give the tests two names, or both "
            "rows the same"
        )
    return states


def _shown(value: float) -> str:
    return "empty" if np.isnan(value) else f"{value:g}"


def _notes(table: CampaignColumns, twin: Twin, campaign: Campaign) -> list[str]:
    """Return a sentence on what the file leaves out, and on times and temperatures that cannot be."""
    notes, time, temperature = [], campaign.time, campaign.temperature
    absent = [name for name in twin.gauges if name not in campaign.gauges]
    if absent:
        notes.append(f"{len(absent)} of the twin's gauges are not in the file ({', '.join(absent[:6])}); not used.")
    if np.isnan(campaign.states).any():
        notes.append(UNKNOWN_STATES)
    missing = np.flatnonzero(np.isnan(time))
    if 0 < missing.size < len(time):
        notes.append(f"Row {table.numbers[missing[0]]}, column time is empty: times are not used.")
    back = np.flatnonzero(np.diff(time) < 0.0)
    if back.size:
        notes.append(
            f"Row {table.numbers[back[0] + 1]}, column time: earlier than the row before; order rows by time, or "
            "write the day beside the time of day."
        )
    hot = np.flatnonzero(temperature > HOTTEST)
    if hot.size:
        notes.append(
            f"Row {table.numbers[hot[0]]}, column temperature is {temperature[hot[0]]:g}; expected degrees Celsius."
        )
    return notes
