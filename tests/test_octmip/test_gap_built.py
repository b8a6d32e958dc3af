"""An asset as it was built: constants that its run says, changes from there, effects at their own sizes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from octmip.gap import (
    Addition,
    AugmentedTwin,
    Campaign,
    Differences,
    FunctionTwin,
    Odds,
    Recorded,
    SimpleEffect,
    diagnose,
    function_twin,
    gathered,
)
from octmip.gap.channels.outliers import robust
from octmip.gap.doors.built import built_by
from octmip.gap.effects import chain_of
from octmip.gap.twins import CachedTwin
from octmip.interfaces.report.diagnosis.recommendation import recommend

READINGS = {"u1": "mm", "u2": "mm", "moment": "N m", "sum": "mm"}
RANGES = {"k1": (10.0, 5.0, 14.0, "N/mm"), "k2": (12.0, 8.0, 16.0, "N/mm"), "arm": (0.5, 0.4, 0.6, "m")}
SD = np.array([0.02, 0.02, 0.1, 0.02])
FORCES = (20.0, 40.0, 60.0)


def springs(p, loads):
    force = loads["force"]
    return [force / p["k1"], force / p["k2"], force * p["arm"], 2 * force / (p["k1"] + p["k2"])]


def valve(p, loads):
    flow = loads["q"]
    return [min(flow**2 * p["k"], p["relief"] + 0.1 * flow), 5.0 * flow, 0.3 * flow**2 * p["k"]]


SPRINGS = function_twin(springs, READINGS, RANGES, loads=("force",))
VALVE = function_twin(
    valve,
    {"p1": "bar", "flow": "l/min", "p2": "bar"},
    {"k": (1.0, 0.7, 1.4, "-"), "relief": (8.0, 4.0, 12.0, "bar")},
    loads=("q",),
)


def read(twin: FunctionTwin, loads: list[dict], seed: int, sd=SD, tests: int = 1, **values: float) -> Campaign:
    """Return 24 readings of each load of a twin with other values of its parameters, in some tests."""
    rng, nominal = np.random.default_rng(seed), {name: own.nominal for name, own in twin.card.ranges.items()}
    blocks = []
    for t in range(tests):
        for load in loads:
            clean = np.array(twin.function(nominal | values, load))
            blocks.append(Recorded(clean + sd * rng.standard_normal((24 // tests, len(clean))), load, test=f"T{t}"))
    return gathered(twin, blocks)


def at_forces(rows, forces) -> Campaign:
    """Return readings of the springs, each row at a force of its own."""
    return gathered(SPRINGS, [Recorded(row, {"force": float(f)}) for f, row in zip(forces, rows, strict=True)])


def under(forces=FORCES, **others: float) -> list[dict]:
    return [{"force": force, **others} for force in forces]


@pytest.mark.parametrize("seed", range(3))
def test_a_run_says_the_constants_of_an_asset_within_its_noise(seed):
    built = built_by(read(SPRINGS, under(), seed, k1=9.2, arm=0.53), CachedTwin(SPRINGS), 0.08)
    assert built.values["k1"] == pytest.approx(9.2, abs=0.04)
    assert built.values["arm"] == pytest.approx(0.53, abs=0.005)
    assert built.signature_error == 0.02


def test_a_constant_is_drawn_to_its_drawing_by_the_noise_of_its_mean_and_the_models_own():
    twin = function_twin(lambda p, loads: [p["k"] * loads["f"]], {"u": "mm"}, {"k": (10.0, 5.0, 15.0)}, loads=("f",))
    run = read(twin, [{"f": 2.0}], 1, np.array([5.0]), k=11.0)
    variance = run.spreads()[0, 0] ** 2 / len(run.test) + 0.2**2
    share = 1.6**2 / (1.6**2 + variance)
    assert 0.5 < share < 0.9
    expected = 10.0 + share * (run.readings.mean() / 2.0 - 10.0)
    assert built_by(run, CachedTwin(twin), 0.08).values["k"] == pytest.approx(expected)


def test_constants_that_are_zero_or_at_an_end_are_not_moved():
    twin = function_twin(
        springs, READINGS, RANGES | {"k1": (10.0, 5.0, 10.0, "N/mm"), "leak": (0.0, -1.0, 1.0)}, ("force",)
    )
    assert set(built_by(read(twin, under(), 1, k1=9.2), CachedTwin(twin), 0.08).values) == {"k2", "arm"}


def test_a_run_of_another_twin_or_of_unknown_states_says_no_constants():
    other = function_twin(springs, READINGS, RANGES, loads=("force",), states=("crack",))
    run = read(SPRINGS, under(), 1)
    assert built_by(run, CachedTwin(function_twin(springs, READINGS, RANGES, loads=("weight",))), 0.08) is None
    assert built_by(run, CachedTwin(function_twin(springs, READINGS, {}, loads=("force",))), 0.08) is None
    unknown = np.full((len(run.test), 1), np.nan)
    assert built_by(replace(run, parameters=("crack",), states=unknown), CachedTwin(other), 0.08) is None


def test_a_diagnosis_asks_its_model_six_times_for_every_parameter_and_load_at_most():
    twin = function_twin(springs, READINGS, RANGES, loads=("force",))
    run, now = read(twin, under(), 1), read(twin, under(), 2, k1=8.0)
    before = len(twin.answers)
    found = diagnose(now, twin, commissioning=run)
    assert found.which[0].names == (frozenset({"k1"}),)
    assert len(twin.answers) - before <= 6 * len(RANGES) * len(FORCES)


def test_a_gauge_that_reads_nothing_or_that_the_twin_lacks_does_not_count():
    run = read(SPRINGS, under(), 1, k1=9.2)
    silent = replace(
        run,
        gauges=("other", *run.gauges),
        units=("mm", *run.units),
        readings=np.column_stack(
            [np.full(len(run.test), 7.0), run.readings[:, :2], 0.0 * run.readings[:, 2], run.readings[:, 3]]
        ),
    )
    built = built_by(silent, CachedTwin(SPRINGS), 0.08)
    assert built.values["k1"] == pytest.approx(9.2, abs=0.05)
    assert built.signature_error == built_by(run, CachedTwin(SPRINGS), 0.08).signature_error == 0.02


@pytest.mark.parametrize(("built", "now"), [(9.2, 10.0), (10.8, 10.0), (9.2, 8.0), (11.0, 12.0)])
def test_an_asset_that_is_built_off_its_drawing_is_no_wrong_run(built, now):
    found = diagnose(read(SPRINGS, under(), 1, k1=now), SPRINGS, commissioning=read(SPRINGS, under(), 2, k1=built))
    assert found.which[0].effects == ("k1",)
    assert not found.doubts
    size = found.which[0].parameters[0]
    assert size.low - 0.05 <= now - built <= size.high + 0.05
    assert "sound asset's" in size.named.above
    said = re.search(r"\(k1 ([0-9.]+) for 10\)", found.notes[0])
    assert float(said[1]) == pytest.approx(built, abs=0.06)
    load = {"force": 50.0}
    there = found.augmented(SPRINGS).predict({}, 50.0)
    assert there == pytest.approx(springs({"k1": now, "k2": 12.0, "arm": 0.5}, load), rel=0.01)


@pytest.mark.parametrize(("k1", "relief"), [(8.0, 10.5), (6.0, 6.0), (5.1, 9.0)])
def test_an_effect_is_judged_by_its_exact_map_at_its_own_size(k1, relief):
    soft = diagnose(read(SPRINGS, under(), 1, k1=k1), SPRINGS, commissioning=read(SPRINGS, under(), 2))
    flows = [{"q": q} for q in (1.0, 2.0, 2.5, 3.0, 3.5, 4.0)]
    bent = [read(VALVE, flows, seed, sd=0.02, relief=value) for seed, value in ((3, relief), (4, 8.0))]
    open_ = diagnose(bent[0], VALVE, commissioning=bent[1])
    assert [soft.which[0].effects, open_.which[0].effects] == [("k1",), ("relief",)]
    assert min(soft.which[0].probability, open_.which[0].probability) > 0.9
    assert soft.shrinkage.closed == pytest.approx(1.0, abs=0.02)
    assert max(found.shrinkage.closed for found in (soft, open_)) <= 1.0


@pytest.mark.parametrize(
    ("wrong", "name", "size"), [((1.0, 3.0), "air_offset", 3.0), ((1.06, 0.0), "power_error", 6.0)]
)
def test_a_load_is_wrong_by_a_factor_or_by_an_offset(wrong, name, size):
    def heated(p, loads):
        rise = p["film"] * loads["power"]
        return [rise + loads["air"], 0.4 * rise + loads["air"], loads["power"] ** 0.5]

    parameters = {"film": (5.0, 3.0, 8.0, "K/kW")}
    twin = function_twin(heated, {"hot": "deg C", "cold": "deg C", "fan": "V"}, parameters, loads=("power", "air"))
    loads = [{"power": p, "air": a} for p in (2.0, 5.0, 8.0) for a in (5.0, 15.0, 25.0)]
    factor, offset = wrong
    felt = [{"power": factor * load["power"], "air": load["air"] + offset} for load in loads]
    sd = np.array([0.1, 0.1, 0.01])
    shown = [(read(twin, [load], 7 + k, sd), load) for k, load in enumerate(felt)]
    campaign = gathered(twin, [Recorded(one.readings, load) for (one, _), load in zip(shown, loads, strict=True)])
    found = diagnose(campaign, twin, commissioning=read(twin, loads, 30, sd))
    assert name in found.which[0].names[0]
    parameter = found.which[0].parameters[0]
    assert parameter.low <= size <= parameter.high


def test_a_load_that_is_never_changed_has_no_offset():
    assert "q_offset" not in chain_of(VALVE, extents={"q": 0.0})
    assert "q_offset" in chain_of(VALVE, extents={"q": 3.0})


@pytest.mark.long("2")
@pytest.mark.parametrize("tests", [2, 4])
def test_a_run_of_white_noise_in_several_tests_does_not_wander(tests):
    runs = [read(SPRINGS, under(), seed, tests=tests) for seed in range(6)]
    campaign = read(SPRINGS, under(), 50, k1=9.8)
    wanders = [diagnose(campaign, SPRINGS, commissioning=run).posterior.model.inputs.difference.wander for run in runs]
    assert sum(one.any() for one in wanders) <= 1


def test_a_coarse_display_shows_no_far_off_readings():
    step = 1.5 * SD
    for seed in range(8):
        campaign = read(SPRINGS, under(), seed)
        assert not robust(replace(campaign, readings=step * np.round(campaign.readings / step))).share


@pytest.mark.parametrize(("gain", "gauge"), [(1.3, "u1"), (0.8, "u1"), (1.15, "sum")])
def test_a_fault_of_a_channel_in_the_run_is_no_constant_of_the_asset_and_no_fault_of_today(gain, gauge):
    built = {"k1": 10.5, "k2": 11.6}
    run = read(SPRINGS, under(), 3, **built)
    wrong = replace(run, readings=run.readings * np.where(np.array(list(READINGS)) == gauge, gain, 1.0))
    found = diagnose(read(SPRINGS, under(), 23, **built), SPRINGS, commissioning=wrong)
    assert f"gain of gauge {gauge}" in found.doubts[0]
    assert not [note for note in found.notes if "By its run" in note]
    assert found.is_sound
    by_what_is_left = found.posterior.model.inputs.twin.twin.card.ranges
    assert by_what_is_left["k1"].nominal == pytest.approx(10.5, rel=0.03)


@pytest.mark.parametrize("seed", range(4))
def test_without_a_run_an_asset_that_is_built_off_is_not_accused_and_its_constants_are_told(seed):
    rng = np.random.default_rng(seed)
    asset = {name: own.nominal * (1.0 + 0.05 * rng.standard_normal()) for name, own in SPRINGS.card.ranges.items()}
    found = diagnose(read(SPRINGS, under(), seed, **asset), SPRINGS)
    assert found.which[0].effects == ()
    assert recommend(found)
    for one in found.constants:
        assert abs(one.mean - asset[one.name]) < 3.0 * one.sd < 0.1 * one.drawn
        assert one.drawn == SPRINGS.card.ranges[one.name].nominal
    assert found.augmented(SPRINGS).predict({}, 50.0) == pytest.approx(springs(asset, {"force": 50.0}), rel=0.02)


@pytest.mark.parametrize(("far", "named"), [(0.08, False), (0.02, True)])
def test_without_a_run_a_change_is_named_as_far_as_it_stands_out_of_what_constants_may_be_off(far, named):
    odds = Odds(differences=Differences(constants=far))
    found = diagnose(read(SPRINGS, under(), 7, k1=7.5), SPRINGS, odds=odds)
    first = found.constants[0]
    assert (first.name, first.unit, first.drawn) == ("k1", "N/mm", 10.0)
    assert first.interval[0] < 7.5 < first.interval[1]
    assert (found.which[0].effects == ("k1",) and found.which[0].probability > 0.9) is named
    assert any(f"some {100 * far:g} % off" in note for note in found.notes)
    assert "k1 is 7.5" in recommend(found).lower()
    assert ("a run of the sound asset (--commissioning) tells" in recommend(found)) is not named


@pytest.mark.parametrize("k", [15.0, 6.0, 5.0, 4.0, 2.0, 1.2])
@pytest.mark.parametrize("with_run", [True, False])
def test_a_stiffness_that_is_lost_or_gained_by_half_and_more_is_named_with_its_size(k, with_run):
    def spring(p, loads):
        u = loads["F"] / p["k"]
        return [u, 2 * u + loads["F"] / 10, loads["F"] / 10]

    twin = function_twin(spring, dict.fromkeys("uvw", "mm"), {"k": (10, 1, 20, "N/mm")}, ("F",))
    loads = [{"F": load} for load in (0.0, 5.0, 10.0)]
    today, sound = (read(twin, loads, seed, sd=np.full(3, 0.05), k=value) for seed, value in ((1, k), (2, 10.0)))
    found = diagnose(today, twin, commissioning=sound if with_run else None)
    assert found.which[0].effects == ("k",)
    assert found.which[0].probability > 0.95
    (size,) = found.which[0].parameters
    assert size.low < k - 10.0 < size.high
    assert size.size == pytest.approx(k - 10.0, abs=0.3)
    for load in loads:  # by name, as the function is asked
        assert found.augmented(twin).predict({}, load) == pytest.approx(spring({"k": k}, load), abs=0.06)
    if not with_run:
        assert found.constants[0].interval[0] < k < found.constants[0].interval[1]


@pytest.mark.parametrize(("c", "with_run"), [(2.0, True), (3.0, True), (3.5, True), (0.5, False), (1.5, False)])
def test_a_change_whose_readings_saturate_is_named_alone_with_its_size(c, with_run):
    def charging(p, loads):
        charged = 1.0 / (1.0 + p["R"] * p["leak"])
        v = 12.0 * charged * (1.0 - np.exp(-loads["t"] / (p["R"] * p["C"] * charged)))
        return [v, (12.0 - v) / p["R"], v**2 * p["C"] / 2.0]

    own = {"R": (10, 2, 50, "kohm"), "C": (1, 0.1, 4, "mF"), "leak": (0, 0, 0.1, "mS")}
    twin = function_twin(charging, {"v": "V", "i": "mA", "e": "mJ"}, own, ("t",))
    loads, sd = [{"t": t} for t in (1.0, 3.0, 6.0, 10.0, 20.0, 40.0)], np.array([0.02, 0.005, 0.3])
    run = read(twin, loads, 2, sd) if with_run else None
    found = diagnose(read(twin, loads, 1, sd, C=c), twin, commissioning=run)
    assert found.which[0].effects == ("C",)
    assert found.which[0].probability > 0.93
    assert found.which[0].parameters[0].size == pytest.approx(c - 1.0, abs=0.1)


def test_constants_that_one_reading_alone_shows_are_told_with_their_correlation():
    def lever(p, loads):
        return [loads["force"] * p["arm"] / p["k"], loads["force"]]

    twin = function_twin(
        lever, {"u": "mm", "f": "N"}, {"arm": (2.0, 1.0, 3.0, "m"), "k": (5.0, 3.0, 8.0, "N/mm")}, ("force",)
    )
    found = diagnose(read(twin, under(), 3, sd=np.array([0.02, 0.1])), twin)
    arm, _ = found.constants
    assert arm.correlation["k"] > 0.8
    assert arm.sd == pytest.approx(0.08 * 2.0 / np.sqrt(2.0), rel=0.1)
    assert not found.which[0].effects
    run = read(twin, under(), 4, sd=np.array([0.02, 0.1]))
    assert not diagnose(run, twin, commissioning=run).constants


@pytest.mark.parametrize(
    ("values", "places"),
    [((9.0, 7.0), {"test May", "test June"}), ((10.0, 8.0), {"test June"}), ((8.0, 8.0), {""}), ((10.0, 10.0), set())],
)
def test_a_parameter_may_have_another_size_in_every_test(values, places):
    rng = np.random.default_rng(3)
    months = list(zip(("May", "June"), values, strict=True))
    now = [
        Recorded(
            np.array(springs({"k1": k1, "k2": 12.0, "arm": 0.5}, load)) + SD * rng.standard_normal((20, 4)),
            load,
            test=month,
        )
        for month, k1 in months
        for load in under()
    ]
    found = diagnose(gathered(SPRINGS, now), SPRINGS, commissioning=read(SPRINGS, under(), 4))
    first = found.which[0]
    assert {p.effect for p in first.parameters} <= {"k1"}
    assert {p.place for p in first.parameters} == places
    for p in first.parameters:
        wanted = dict(months).get(p.place.removeprefix("test "), values[0]) - 10.0
        assert p.low <= wanted <= p.high
    # the corrected twin is the asset of the last test
    assert found.augmented(SPRINGS).predict({}, 50.0)[0] == pytest.approx(50.0 / values[1], rel=0.02)
    if len(places) == 2:
        assert "in test May" in recommend(found)
        assert "in test June" in recommend(found)


def test_a_model_that_fails_at_the_constants_found_keeps_those_before():
    def brittle(p, loads):
        if p["k1"] != 10.0 and p["k2"] != 12.0:
            raise ValueError("no equilibrium")
        return springs(p, loads)

    twin = function_twin(brittle, READINGS, RANGES, loads=("force",))
    built = built_by(read(SPRINGS, under(), 0, k1=9.2, k2=11.5), CachedTwin(twin), 0.08)
    assert built.values == {"k1": 10.0, "k2": 12.0, "arm": 0.5}


def test_an_exact_effect_of_a_corrected_twin_knows_the_state():
    cracked = function_twin(lambda p, loads: [10.0 * loads["f"]], {"u": "mm"}, loads=("f",), states=("crack",))
    opens = SimpleEffect("opens", "-", 1.0, lambda u, size, load, place, state: u * (1.0 + size * state["crack"]))
    found = AugmentedTwin(cracked, (Addition(opens, "", 2.0),)).predict({"crack": 0.25}, 1.0)
    assert found.tolist() == [15.0]


def test_a_correction_without_a_run_stays_within_the_ranges_of_the_card():
    twin = function_twin(springs, READINGS, RANGES | {"k1": (10.0, 9.5, 14.0, "N/mm")}, ("force",))
    found = diagnose(read(twin, under(), 1, k1=9.45), twin)
    assert found.constants[0].sound == 9.5
    expected = springs({"k1": 9.5, "k2": 12.0, "arm": 0.5}, {"force": 60.0})
    assert found.augmented(twin).predict({}, 60.0) == pytest.approx(expected, 0.01)
