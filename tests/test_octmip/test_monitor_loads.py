"""A monitor of twins with several loads, and with none: a library holds for one combination of loads."""

import numpy as np
import pytest

from octmip.errors import DataError, ProblemError, TwinError
from octmip.gap import function_twin
from octmip.monitor import (
    Filter,
    ModelSelector,
    Monitor,
    Watch,
    effect_candidates,
    grid_states,
    library_of,
    steady_growth,
)
from octmip.trees.nodes.tree import Leaf, Split
from tests.test_octmip.test_monitor_filter import WholeReading

LEVELS = (0.0, 0.2, 0.4)
GAUGES = {f"g{k}": "mm" for k in range(6)}
PLACE = np.linspace(0.0, 1.0, 6)
AT = {"force": 2.0, "moment": 1.0}


def bent(parameters, loads):
    pull = loads["force"] * (1.0 + PLACE) / (1.0 - parameters["crack"])
    return parameters["k"] * (10.0 * pull + 4.0 * loads["moment"] * PLACE**2)


def twin_of(function=bent, loads=("force", "moment"), **options):
    return function_twin(function, GAUGES, {"k": (1.0, 0.8, 1.2)}, loads, states=("crack",), **options)


LINEAR = twin_of(linear=True)


def library(twin=LINEAR, at=AT):
    return library_of(twin, grid_states([LEVELS]), 0.1, load_factor=at)


def monitor_of(known, **options):
    middle = (known.strains[1:, 0] + known.strains[:-1, 0]) / 2
    tree = Split(0, float(middle[0]), Leaf(0), Split(0, float(middle[1]), Leaf(1), Leaf(2)))
    chain = Filter(WholeReading(known), steady_growth(known, 0.01))
    return Monitor(ModelSelector(known, tree), chain, Watch(known, **options))


def test_the_state_is_found_at_every_multiple_of_the_loads_and_refused_at_another_ratio():
    readings = []
    for factor in (1.0, 0.5, 3.0):
        loads = {name: factor * amount for name, amount in AT.items()}
        readings.append((loads, bent({"crack": 0.2, "k": 1.0}, loads)))
    *found, refused = monitor_of(library()).run([*readings, ({"force": 2.0, "moment": 2.0}, readings[0][1])])
    assert [result.state for result in found] == [1, 1, 1]
    assert found[-1].belief.probability[0].argmax() == 1
    assert min(result.p_value for result in found) > 0.5
    assert "expected a multiple of force 2, moment 1" in refused.words


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_loads_are_multiples_of_the_reference_in_any_unit(unit):
    known = library()
    assert known.checked_load({name: unit / 3 * amount for name, amount in AT.items()}) == pytest.approx(unit / 3)
    with pytest.raises(DataError, match="expected a multiple of force 2, moment 1"):
        known.checked_load({"force": 2.0 * unit, "moment": 1.001 * unit})


def test_an_effect_of_the_twin_is_named_where_readings_depend_on_two_loads():
    softer = effect_candidates(LINEAR, LINEAR.effects["k"], library())
    watched = monitor_of(library())
    watched = Monitor(watched.selector, watched.filter, Watch(library(), softer, horizon=20))
    reading = 1.1 * bent({"crack": 0.0, "k": 1.0}, AT)
    kinds = [result.finding.kind for result in watched.run([(AT, reading)] * 20) if result.finding]
    assert kinds == ["k"]


def test_a_twin_that_is_not_linear_holds_for_its_loads_alone():
    known = library(twin_of())
    assert known.checked_load(AT) == 1.0
    with pytest.raises(DataError, match="not linear in load"):
        known.checked_load({"force": 4.0, "moment": 2.0})


def test_a_twin_without_loads_is_monitored_by_its_readings_alone():
    still = twin_of(lambda p, loads: bent(p, AT), loads=())
    known = library(still, {})
    (result,) = monitor_of(known).run([({}, bent({"crack": 0.4, "k": 1.0}, AT))])
    assert result.state == 2


@pytest.mark.parametrize(
    ("at", "told"),
    [
        (1.0, r"load_factor is 1.0; expected the twin's loads \['force', 'moment'\] by name"),
        ({"force": 1.0}, r"expected the twin's loads"),
        ({"force": 0.0, "moment": 0.0}, "not all 0"),
    ],
)
def test_a_library_needs_all_loads_of_the_twin(at, told):
    with pytest.raises(ProblemError, match=told):
        library(LINEAR, at)


def test_a_twin_that_claims_to_be_linear_and_is_not_is_refused():
    curved = twin_of(lambda p, loads: bent(p, loads) + loads["force"] ** 2, linear=True)
    with pytest.raises(TwinError, match=r"says that it is linear in its loads, but reading g0 is 24 .* and 11 at half"):
        library(curved)


def test_loads_by_name_are_refused_where_the_twin_has_one_load():
    known = library(twin_of(lambda p, loads: bent(p, AT | loads), ("force",)), 2.0)
    with pytest.raises(DataError, match="expected one number, the load factor"):
        known.checked_load({"force": 2.0})
