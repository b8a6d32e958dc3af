"""Effects of a measuring chain on gauges of any name, and the answers that a cached twin keeps of effects."""

import json
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from octmip.errors import DataError, TwinError
from octmip.gap import (
    CHAIN,
    CachedTwin,
    Campaign,
    FunctionTwin,
    Recorded,
    SimpleEffect,
    diagnose,
    function_twin,
    gathered,
)
from octmip.gap.doors import table_twin
from octmip.gap.effects import chain_of
from octmip.gap.inference.candidates import candidates_of
from octmip.gap.odds import Odds
from octmip.gap.preparation import library_of
from octmip.twin import MICROSTRAIN, Effect
from tests.test_octmip.beam_twin import Beam, Field
from tests.test_octmip.test_gap_doors import TWIN, measured

NAMES = ("a/b", "<", "x<y", "a", "b", "/", "y")
PLAIN = tuple(f"g{k}" for k in range(len(NAMES)))
PAIRS = ("swapped_pair", "crosstalk")


class Named:
    """A twin whose strains are 1, 2, 4, ... at gauges of any names."""

    parameters = ()
    effects: ClassVar[dict] = {}

    def __init__(self, gauges):
        self.gauges = gauges

    def predict(self, state, load_factor):
        return load_factor * 2.0 ** np.arange(len(self.gauges))


@pytest.mark.parametrize("name", PAIRS)
def test_gauges_of_any_name_are_paired_as_those_of_plain_names(name):
    named, plain = Named(NAMES), Named(PLAIN)
    for place, known in zip(CHAIN[name].places(named), CHAIN[name].places(plain), strict=True):
        expected = CHAIN[name].signature(plain, {}, 1.0, known)
        assert CHAIN[name].signature(named, {}, 1.0, place) == pytest.approx(expected, abs=0.0)


@pytest.mark.parametrize(
    ("name", "gauges", "place", "told"),
    [
        ("swapped_pair", ("a", "b/c", "a/b", "c"), "a/b/c", "2 pairs of gauges.*rename"),
        ("crosstalk", ("<", "<<"), "<<<<", "2 pairs of gauges.*rename"),
        *((name, PLAIN, "g0/g9<g1", "0 pairs of gauges") for name in PAIRS),
    ],
)
def test_a_place_of_two_readings_or_of_none_is_refused(name, gauges, place, told):
    with pytest.raises(DataError, match=f"names {told}"):
        CHAIN[name].signature(Named(gauges), {}, 1.0, place)


def test_gauges_that_were_not_read_have_no_candidates_whatever_they_are_called():
    read = tuple(name for name in NAMES if name not in ("a/b", "x<y"))
    effects = {name: CHAIN[name] for name in ("gauge_gain", *PAIRS)}
    found = candidates_of(effects, Named(NAMES), read, Odds())
    places = {name: {found.place for found in found if found.name == name} for name in effects}
    assert places["gauge_gain"] == set(read)
    assert places["swapped_pair"] == set(CHAIN["swapped_pair"].places(Named(read)))
    assert places["crosstalk"] == {"a<b", "b<a", "b</", "/<b", "/<y", "y</"}


def test_a_cached_twin_keeps_two_effects_of_one_name_apart():
    cached = CachedTwin(Beam())
    one = Field("soak", np.full(20, -1.0), 0, 10.0)
    other = replace(one, shape=np.full(20, -3.0))
    first, second = (cached.signatures(effect, ("",), {}, 1.0, 0.0) for effect in (one, other))
    assert (first == -1.0).all()
    assert (second == -3.0).all()
    assert cached.signatures(one, ("",), {}, 1.0, 0.0) is first
    assert cached.signatures(other, ("",), {}, 1.0, 0.0) is second


def test_a_simple_effect_says_four_things_and_is_found():
    slack = SimpleEffect("slack", "mm", 0.1, lambda readings, size: readings + np.array([size, 0.7 * size, 0.0]))
    assert isinstance(slack, Effect)
    given = measured(3)
    campaign = replace(given, readings=given.readings + np.array([0.15, 0.7 * 0.15, 0.0]))
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


GAUGES = {f"g{k}": "mm" for k in range(6)}
SHAPE = np.linspace(1.0, 2.0, 6)


def cracked(parameters, loads):
    crack = parameters["crack"]
    return loads["force"] * SHAPE * (1.0 + crack * np.linspace(0.1, 2.0, 6) / (1.2 - crack)) * 10.0 / parameters["k"]


PARAMETERS = {"k": (10.0, 8.0, 12.0, "N/mm")}
CRACKED = function_twin(cracked, GAUGES, PARAMETERS, ("force",), states=("crack",))


def with_crack(crack, known=float("nan"), seed=0):
    rng, blocks = np.random.default_rng(seed), []
    for force in (1.0, 2.0, 4.0):
        rows = cracked({"crack": crack, "k": 10.0}, {"force": force}) + 0.02 * rng.standard_normal((15, 6))
        blocks.append(Recorded(rows, {"force": force}, state={"crack": known}))
    return gathered(CRACKED, blocks)


@pytest.fixture
def table(tmp_path):
    lines = [",".join(["k", "crack", "force", *GAUGES])]
    for k in (8.0, 9.0, 10.0, 11.0, 12.0):
        for crack in np.linspace(0.0, 0.4, 41):
            for force in (0.0, 4.0):
                row = cracked({"crack": crack, "k": k}, {"force": force})
                lines.append(",".join(f"{v:.15g}" for v in (k, crack, force, *row)))
    (tmp_path / "t.csv").write_text("\n".join(lines))
    card = {"readings": GAUGES, "loads": ["force"], "states": ["crack"], "parameters": {"k": list(PARAMETERS["k"])}}
    (tmp_path / "t.csv.json").write_text(json.dumps(card))
    return table_twin(tmp_path / "t.csv")


def test_an_unknown_state_is_looked_for_within_the_table(table):
    assert table.state_limits == {"crack": 0.4}
    (own,), (exact,) = (diagnose(with_crack(0.25), twin).states for twin in (table, CRACKED))
    assert own.mean["crack"] == pytest.approx(0.25, abs=0.03)
    assert own.mean["crack"] == pytest.approx(exact.mean["crack"], abs=0.02)


def test_a_stated_state_at_the_end_of_the_table_is_no_question_beyond_it(table):
    assert diagnose(with_crack(0.4, known=0.4), table).is_sound


def test_a_state_without_a_limit_is_taken_as_stated_and_must_be_stated():
    slow = FunctionTwin(cracked, replace(CRACKED.card, state_limits={}))
    assert diagnose(with_crack(0.3, known=0.3), slow).is_sound
    with pytest.raises(DataError, match="state crack is unknown, and the twin gives no range"):
        diagnose(with_crack(0.3), slow)
