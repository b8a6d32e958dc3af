"""Effects of other people: four things said are enough, fewer are refused."""

import numpy as np
import pytest

from octmip.errors import TwinError
from octmip.gap import Campaign, SimpleEffect, diagnose
from octmip.twin import Effect
from tests.test_octmip.test_gap_doors import TWIN, measured


def test_a_simple_effect_says_four_things_and_is_found():
    slack = SimpleEffect("slack", "mm", 0.1, lambda readings, size: readings + np.array([size, 0.7 * size, 0.0]))
    assert isinstance(slack, Effect)
    given = measured(3)
    readings = given.readings + np.array([0.15, 0.7 * 0.15, 0.0])
    campaign = Campaign(
        given.gauges, (), given.test, given.load_factor, given.states, readings, given.time, given.temperature,
        load_names=given.load_names,
    )  # fmt: skip
    diagnosis = diagnose(campaign, TWIN, {**TWIN.effects, "slack": slack})
    (found,) = diagnosis.which[0].parameters
    assert found.effect == "slack"
    assert found.size == pytest.approx(0.15, rel=0.1)


def test_a_simple_effect_may_ask_for_load_and_place_and_knows_its_bounds():
    at = SimpleEffect(
        "hit",
        "mm",
        1.0,
        lambda r, size, load, place: r + size**2 * load * (place == "b"),
        ("a", "b"),
        bounds=(0.0, 2.0),
    )
    assert at.is_one_sided
    assert at.places(TWIN) == ("a", "b")
    assert at.predict(TWIN, {}, 100.0, 9.0, "b", 0.0) == pytest.approx(TWIN.predict({}, 100.0) + 400.0)
    assert not at.signature(TWIN, {}, 100.0, "a").any()
    assert at.signature(TWIN, {}, 100.0, "b") == pytest.approx(100.0 * 0.1)  # the slope from 0 to a tenth of its sd
    with pytest.raises(TwinError, match="takes 1 arguments"):
        SimpleEffect("one", "mm", 1.0, lambda readings: readings)


def test_an_effect_that_says_too_little_and_a_name_that_comes_twice_are_refused():
    with pytest.raises(TwinError, match=r"effect 'tilt' \(object\) has no name"):
        diagnose(measured(5), TWIN, {"tilt": object()})
    tilt = SimpleEffect("tilt", "deg", 1.0, lambda readings, size: readings + size)
    with pytest.raises(TwinError, match="two effects are called 'tilt'"):
        diagnose(measured(5), TWIN, {"a": tilt, "b": tilt})
