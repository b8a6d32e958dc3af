"""Windows of steady load: where they are, and where there are none."""

import contextlib
import re

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.formats.table.units import _UNITS, factor_between
from octmip.recordings import Channel, Window
from octmip.recordings.windows import moving, ordered, steady_windows, window_of

TIME = np.arange(0.0, 100.0, 0.01)
STAIRS = np.interp(TIME, [0, 20, 22, 40, 42, 60, 62, 80, 82, 100], [0, 0, 10, 10, 20, 20, 10, 10, 0, 0])
ENDS = [(0, 20), (22, 40), (42, 60), (62, 80), (82, 100)]
NOISE = np.random.default_rng(3).standard_normal(len(TIME))


def load(values, time=TIME, name="force"):
    return Channel(name, "N", time, values)


def found(values, **how):
    windows, told = steady_windows([load(values)], **how)
    return [(one.start, one.end) for one in windows], told


@pytest.mark.parametrize(
    "values",
    [
        STAIRS,
        STAIRS + 0.05 * NOISE,
        np.round(STAIRS + 0.05 * NOISE, 1),
        STAIRS + np.sin(40.0 * TIME),
        STAIRS + 2.0 * NOISE,
    ],
    ids=["clean", "noise", "a display", "vibration", "much noise"],
)
def test_every_plateau_is_a_window_within_its_ends(values):
    windows, _ = found(values)
    assert len(windows) == 5
    for (start, end), (first, last) in zip(windows, ENDS, strict=True):
        assert first - 0.3 <= start < first + 0.8
        assert last - 0.8 < end <= last + 0.3


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (0.3 * TIME, "no window of at least 2 s in which force stays within 0.598 N, the longest still stretch has"),
        (np.sin(31.0 * TIME), "expected plateaus that stand out of its noise; give --windows START,END"),
        (5.0 + 0.1 * NOISE, "expected plateaus that stand out of its noise"),
    ],
    ids=["a ramp", "a fast sine", "noise alone"],
)
def test_what_does_not_stand_still_makes_no_window(values, said):
    with pytest.raises(DataError, match=said.replace("(", r"\(")):
        found(values)


def test_a_load_that_creeps_into_a_plateau_begins_where_it_is_there():
    windows, told = found(np.where(TIME < 20, 0.0, 10.0 * (1.0 - np.exp((20.0 - TIME) / 5.0))) + 0.01 * NOISE)
    assert windows[0] == pytest.approx((0.25, 19.75), abs=0.1)
    assert windows[-1][0] > 35.0
    assert "creeps all along" in told[-1]


def test_all_loads_stand_still_in_a_window_and_one_of_noise_alone_stands_always():
    other = np.interp(TIME, [0, 30, 31, 100], [0, 0, 5, 5])
    windows, _ = steady_windows([load(STAIRS), load(other, name="moment")])
    assert [round(one.end) for one in windows] == [20, 30, 40, 60, 80, 100]
    windows, told = steady_windows([load(STAIRS), load(0.1 * NOISE, name="moment")])
    assert len(windows) == 5
    assert "moment is noise" in told[0]


def test_a_gap_and_bad_samples_of_the_load_end_a_window():
    keep = (TIME < 5.0) | (TIME > 9.0)
    values = np.where((TIME > 28.0) & (TIME < 31.0), np.nan, STAIRS)
    windows, _ = steady_windows([load(values[keep], TIME[keep])])
    assert [round(one.start) for one in windows] == [0, 9, 22, 31, 42, 62, 82]


def test_windows_that_are_given_are_ordered_and_a_load_that_moves_is_told():
    assert ordered([window_of("2,6"), window_of("1,2,first")]) == (Window(1.0, 2.0, "first"), Window(2.0, 6.0))
    assert moving([load(STAIRS)], [Window(1.0, 19.0)], 0.02) == ()
    (told,) = moving([load(STAIRS)], [Window(1.0, 19.0), Window(19.0, 25.0)], 0.02)
    assert told.startswith("Load force moves by 8.76")
    for wrong in ("1", "1,x", "2,1", "1,nan"):
        with pytest.raises(DataError, match="expected START,END in seconds"):
            window_of(wrong)
    with pytest.raises(DataError, match="expected a positive time"):
        found(STAIRS, least=-1.0)


@pytest.mark.parametrize(
    ("given", "wanted", "factor"),
    [
        ("cN", "N", 0.01),
        ("ksi", "MPa", 6.894757293168361),
        ("kip", "N", 4448.2216152605),
        ("0.01 m", "mm", 10.0),
        ("rpm", "deg/s", 6.0),
        ("rpm", "Hz", 1 / 60),  # pint itself says 0.105
        ("Hz", "rad/s", None),
        ("rad", "strain", None),
        ("furlong", "", None),
        ("rankine", "degC", None),
        ("dBm", "W", None),
        ("9**9**9 m", "km", None),
        ("no such unit", "inch", None),
    ],
)
def test_units_that_the_table_lacks_are_those_of_pint_and_angles_stay_angles(given, wanted, factor):
    assert factor_between(given, wanted) == (None if factor is None else pytest.approx(factor))


OTHER_IN_PINT = {"ue", "Nm", "kNm", "mNm", "MNm", "daNm", "Nm/rad", "kNm/rad", "rpm", "g", "mg", "pct", "kg/cm2"}
OTHER_IN_PINT |= {"%RH", "% RH", "%rH", "% rH", "RH%", "%rF"}
"""Electronvolts, nanometres, radians a minute, grams, masses on areas, Rydberg's constants, Henrys, Farads."""


def test_a_unit_of_the_table_is_as_large_as_in_pint():
    pint, sizes = pytest.importorskip("pint"), {}
    read = pint.UnitRegistry().parse_expression
    for unit, (quantity, size) in _UNITS.items():
        if unit not in OTHER_IN_PINT and not quantity.startswith("temperature"):
            with contextlib.suppress(pint.PintError, AssertionError, SyntaxError):  # it has no Volt, and no -
                sizes[unit] = (size, read(re.sub(r"(?<=[ms])2$", "^2", unit)).to_base_units().magnitude)
    assert len(sizes) > 90
    assert {unit: own for unit, (own, _) in sizes.items()} == pytest.approx({u: size for u, (_, size) in sizes.items()})
