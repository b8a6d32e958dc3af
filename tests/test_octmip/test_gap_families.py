"""Effects as families: the courses that a campaign gives, and the axes of the structure."""

from typing import ClassVar

import numpy as np
import pytest

from octmip.gap import Campaign
from octmip.gap.diagnosis import library_of
from octmip.gap.effects import chain_of
from octmip.twin import MICROSTRAIN


class Plate:
    """Four gauges at the corners of a plate, longer than it is wide."""

    gauges = ("a", "b", "c", "d")
    parameters = ()
    effects: ClassVar[dict[str, object]] = {}
    gauge_positions = np.array([[0.0, 0.0], [0.0, 2.0], [1.0, 0.0], [1.0, 2.0]])

    def predict(self, state, load_factor):
        return load_factor * np.array([100.0, 200.0, 300.0, 400.0])


def library(load, temperature):
    n = len(load)
    campaign = Campaign(
        gauges=Plate.gauges,
        parameters=(),
        test=("T1",) * n,
        load_factor=np.array(load),
        states=np.zeros((n, 0)),
        readings=np.array([Plate().predict({}, one) for one in load]),
        time=600.0 * np.arange(n),
        temperature=np.array(temperature),
    )
    return library_of(Plate(), campaign)


TYPICAL, HOURS, READINGS = 200.0, 0.5, np.array([-100.0, -200.0, -300.0, -400.0])
LAWS = {
    "constant": np.ones(4),
    "proportional": 0.01 * READINGS,
    "square": 0.01 * READINGS**2 * [-1, -1, -1, -1] / TYPICAL,
    "threshold": 0.01 * np.array([0.0, -100.0, -200.0, -300.0]),  # beyond half of what is typical
}
COURSES = {"steady": 1.0, "linear": HOURS, "power": HOURS ** (1 / 3), "settling": 1.0 - np.exp(-3.0 * HOURS)}


def test_a_family_is_its_law_of_the_reading_times_its_course_in_hours():
    found = chain_of(Plate(), {MICROSTRAIN: TYPICAL})
    named = {(course, law): found.get(f"unit_{course}_{law}") for course in COURSES for law in LAWS}
    named["steady", "proportional"] = found["common_gain"]
    assert sum(effect is not None for effect in named.values()) == 10
    for (course, law), effect in named.items():
        if effect is not None:
            at = effect.signature(Plate(), {}, -1.0, time=3600.0 * HOURS)
            assert at == pytest.approx(COURSES[course] * LAWS[law]), (course, law)


def test_a_gauge_that_goes_with_the_temperature_has_its_course_in_ten_kelvin():
    effect = library([0.0, 1.0, 2.0], [15.0, 25.0, 20.0])["one_warming_constant"]
    at = [effect.signature(Plate(), {}, 1.0, "b", time=time) for time in (0.0, 600.0, 1200.0)]
    assert np.array(at) == pytest.approx(np.outer([0.0, 1.0, 0.5], [0.0, 1.0, 0.0, 0.0]))


def test_readings_that_lag_change_their_sign_with_the_direction_of_the_load():
    effect = library([1.0, 2.0, 0.5], [20.0] * 3)["unit_direction_proportional"]
    at = [effect.signature(Plate(), {}, 1.0, time=time) for time in (0.0, 600.0, 1200.0)]
    assert np.array(at) == pytest.approx(np.outer([1.0, 1.0, -1.0], 0.01 * Plate().predict({}, 1.0)))


def test_courses_that_a_campaign_lacks_are_not_in_its_library():
    found = library([0.0, 1.0, 2.0], [20.0, 20.1, 20.0])
    assert not [name for name in found if "warming" in name or "direction" in name]


def test_what_varies_along_and_across_a_structure_goes_with_its_two_longest_axes():
    found = library([0.0, 1.0], [20.0] * 2)
    along, across = (found[f"{who}_steady_constant"].signature(Plate(), {}, 1.0) for who in ("along", "across"))
    assert along == pytest.approx([-1.0, 1.0, -1.0, 1.0])
    assert across == pytest.approx([-1.0, -1.0, 1.0, 1.0])
