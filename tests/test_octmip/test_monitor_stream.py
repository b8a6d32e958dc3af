"""Streams: every reading gets its result, a bad one its refusal, and memory does not grow."""

import math
import sys
from collections import namedtuple
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pandas as pd
import pytest

from octmip.errors import DataError
from octmip.monitor import (
    Filter,
    Monitor,
    Refusal,
    Result,
    Watch,
    grid_states,
    library_of,
    steady_growth,
)
from tests.test_octmip.test_monitor_filter import WholeReading
from tests.test_octmip.test_monitor_selector import LinearBeam, a_selector

SELECTOR = a_selector()
GAUGES = SELECTOR.library.gauges


def whole():
    cells = library_of(LinearBeam(), grid_states([(0.1, 0.3, 0.5, 0.7)] * 2), 31.6, widths=(0.2, 0.2))
    chain = Filter(WholeReading(cells), steady_growth(cells, 0.01))
    return Monitor(SELECTOR, chain, Watch(SELECTOR.library, rate=0.01, horizon=20), start_state=0)


def good(n=1):
    return (3.0, (3.0 * SELECTOR.library.strains[n]).tolist())


BAD = {
    "has 3 values; expected 20": (3.0, [1.0, 2.0, 3.0]),
    "g05 is nan": (3.0, [math.nan if k == 4 else 500.0 for k in range(20)]),
    "g02 is inf": (3.0, [math.inf if k == 1 else 500.0 for k in range(20)]),
    r"names the gauges g99": (3.0, dict.fromkeys((*GAUGES, "g99"), 500.0)),
    "load_factor is 0": (0.0, [500.0] * 20),
    "load_factor is nan": (math.nan, [500.0] * 20),
    "load_factor: values of type complex": (3j, [500.0] * 20),
    r"gauge g03: values that are no numbers \(such as 'OVLD'\); expected": (
        3.0,
        ["OVLD" if k == 2 else 500.0 for k in range(20)],
    ),
    "gauge g03: values of type complex": (3.0, [1j if k == 2 else 500.0 for k in range(20)]),
    "gauge g03 is a list of 1; expected one number": (3.0, [[500.0] if k == 2 else 500.0 for k in range(20)]),
    r"g06 is 1.79\d+e\+308; expected": (3.0, [sys.float_info.max if k > 4 else 500.0 for k in range(20)]),
    r"g05 is -1e\+200; expected": (3.0, [-1e200 if k == 4 else 500.0 for k in range(20)]),
    "names the gauges 0, 1": (3.0, dict(enumerate([500.0] * 20))),
    "is None; expected a pair": None,
    "is a list of 3; expected a pair": (3.0, [500.0] * 20, 1),
}


@pytest.mark.parametrize("monitor", [Monitor(SELECTOR), whole()], ids=["tree alone", "with filter and watch"])
@pytest.mark.parametrize(("words", "reading"), BAD.items(), ids=list(BAD))
def test_a_bad_reading_is_refused_with_a_sentence_and_the_stream_goes_on(monitor, words, reading):
    before, refused, after = monitor.run([good(), reading, good()])
    assert isinstance(refused, Refusal)
    assert refused.number == 1
    with pytest.raises(DataError, match=words):
        raise DataError(refused.words)
    assert (before.state, after.state) == (after.state, before.state)
    assert after.number == 2


AS = {
    "texts": (str, lambda values: [str(value) for value in values]),
    "texts by name": (float, lambda values: {g: str(value) for g, value in zip(GAUGES, values, strict=True)}),
    "Decimal": (Decimal, lambda values: [Decimal(value) for value in values]),
    "a named tuple": (np.float32, lambda values: namedtuple("Row", GAUGES[::-1])(*values[::-1])),
    "an array of texts": (float, lambda values: np.array(values).astype(str)),
}


@pytest.mark.parametrize(("load", "made"), AS.values(), ids=list(AS))
def test_readings_are_numbers_in_whatever_type_a_message_has_them(load, made):
    factor, values = good(7)
    truth, told = Monitor(SELECTOR).run([(factor, values), (load(factor), made(values))])
    assert told.state == truth.state


@pytest.mark.parametrize("nothing", [None, "", " ", pd.NA], ids=repr)
def test_what_stands_for_no_reading_is_done_without_where_there_is_a_filter(nothing):
    factor, values = good(7)
    truth, told = whole().run([(factor, [None, *values[1:]]), (factor, [nothing, *values[1:]])])
    assert (told.number, told.state) == (1, truth.state)


def test_a_gauge_that_gave_nothing_is_done_without_where_there_is_a_filter():
    load, values = good(7)
    lacking = (load, {gauge: value for gauge, value in zip(GAUGES, values, strict=True) if gauge != "g01"})
    (refused,) = Monitor(SELECTOR).run([lacking])
    assert "lacks gauge g01" in refused.words
    (result,) = whole().run([lacking])
    assert result.state is None
    assert result.belief is not None
    assert result.p_value > 0
    (told,) = whole().run([(load, [None if k == 2 else v for k, v in enumerate(values)])])  # the tree reads no g03
    assert told.state == SELECTOR.select(values, load).state


def test_the_alarm_is_explained_once_and_a_faulty_gauge_is_left_out():
    bad = good()[1]
    bad[5] += 400.0
    results = list(whole().run([good()] * 5 + [(3.0, bad)] * 15))
    found = [result for result in results if result.finding is not None]
    assert len(results) == 20
    assert len(found) == 1
    assert found[0].number in (5, 6)
    assert found[0].finding.name == "g06"
    assert results[-1].p_value > 0.9
    assert results[-1].belief.mean("mu1")[0] < 0.2


def test_loads_that_never_repeat_need_no_more_than_so_many_tables():
    monitor = whole()
    leaves = Filter(SELECTOR.likelihood, steady_growth(SELECTOR.library, 0.001))
    loads = np.random.default_rng(0).uniform(2.0, 2.2, 300)
    readings = ((load, (load * SELECTOR.library.strains[7]).tolist()) for load in loads.tolist())
    assert all(isinstance(result, Result) for result in replace(monitor, filter=leaves).run(readings))
    assert len(monitor.watch._tables) <= 64
    assert len(SELECTOR.likelihood._tables) <= 8


def test_parts_that_read_other_gauges_are_refused():
    other = replace(SELECTOR.library, gauges=tuple(f"x{k}" for k in range(20)))
    with pytest.raises(DataError, match="give all the same"):
        Monitor(SELECTOR, watch=Watch(other))
