"""At the edge of the library: false alarms at the stated rate, what is found, what is named, what is proposed."""

import numpy as np
import pytest
from scipy.stats import kstest

from octmip.errors import ProblemError
from octmip.monitor import (
    Candidate,
    Library,
    ModelSelector,
    Monitor,
    Watch,
    effect_candidates,
    explain,
    grid_states,
    library_of,
)
from octmip.monitor.candidates import gauge_candidates
from octmip.monitor.parity import Parity
from octmip.monitor.stuck import Repeats
from octmip.trees.nodes.tree import Leaf
from tests.test_octmip.beam_twin import ETA, Field
from tests.test_octmip.test_monitor_selector import LinearBeam

SD = 31.6
BUMP = 40.0 * np.exp(-(((ETA - 0.55) / 0.06) ** 2))


@pytest.fixture(scope="module")
def library() -> Library:
    levels = np.linspace(0.0, 0.8, 9)
    return library_of(LinearBeam(), grid_states([levels, levels]), SD)


@pytest.fixture(scope="module")
def watch(library) -> Watch:
    candidates = [
        Candidate("at half span", "foreign damage", BUMP / 40.0, (20.0, 40.0), "%", 1),
        Candidate("at the tip", "foreign damage", np.linspace(0, 1, 20) ** 4, (20.0, 40.0), "%", 1),
    ]
    return Watch(library, candidates, rate=0.05, horizon=50)


def missions(n, seed, horizon=50, change=lambda k, x, load: x):
    """Yield readings (n, 20) and load of assets whose damage grows at a rate of their own, off every level."""
    rng, twin = np.random.default_rng(seed), LinearBeam()
    end = rng.uniform(0.0, 0.8, (n, 2))
    for k in range(horizon):
        load = 3.0 if k % 3 else 2.0
        clean = np.array([twin.predict(dict(zip(("mu1", "mu2"), row, strict=True)), load) for row in end * k / horizon])
        yield change(k, clean + rng.normal(0, SD, clean.shape), load), load


def keep(watch, n, seed, change=lambda k, x, load: x):
    monitor_state, p_values = watch.start(n), []
    for readings, load in missions(n, seed, watch.horizon, change):
        monitor_state = watch.observe(monitor_state, readings, load)
        p_values.append(monitor_state.p_value)
    return monitor_state, np.array(p_values)


def test_in_the_library_p_values_are_uniform_and_false_alarms_keep_to_their_rate(watch):
    monitor_state, p_values = keep(watch, 400, 1)
    assert kstest(p_values.ravel()[::7], "uniform").pvalue > 0.01
    assert monitor_state.is_alarm.mean() <= watch.rate + 3 * np.sqrt(watch.rate / 400)


def test_evidence_is_a_martingale_in_the_library(library):
    # few and weak candidates: then the mean is not carried by rare missions, and can be tested
    short = Watch(library, [Candidate("weak", "foreign damage", BUMP / 40.0, (3.0,), "%", 1)], rate=0.9, horizon=4)
    monitor_state = short.start(4000)
    rng = np.random.default_rng(5)
    logs = []
    for _ in range(4):
        readings = 3.0 * library.strains[np.zeros(4000, int)] + rng.normal(0, SD, (4000, 20))
        monitor_state = short.observe(monitor_state, readings, 3.0)
        weak = [k for k, (s, size) in enumerate(short.hypotheses) if s.name == "weak" or abs(size) <= 1.0]
        logs.append(np.exp(short.log_parts(monitor_state)[:, weak]).sum(axis=1) / np.exp(short._log_prior[weak]).sum())
    for k, evidence in enumerate(logs):
        assert evidence.mean() == pytest.approx((k + 1) / 4, abs=4 * evidence.std() / np.sqrt(4000))


def test_what_a_whole_horizon_cannot_show_is_no_hypothesis(library):
    shown = np.linalg.norm(BUMP / SD @ Parity(library, 3.0).projector(np.ones(20, dtype=bool)))
    faint = 0.2 / shown * BUMP  # sqrt(-2 log 0.01 / 100) = 0.303 can be shown
    candidates = [Candidate(str(power), "foreign damage", faint, (1.0, 2.0), "%", power) for power in (0, 1)]
    found = Watch(library, candidates, rate=0.01, horizon=100, largest_load=3.0).hypotheses
    assert [(one.name, size) for one, size in found if one.kind != "gauge"] == [("0", 2.0), ("1", 1.0), ("1", 2.0)]


def test_a_residual_does_not_know_the_state(library):
    parity, every = Parity(library, 3.0), np.ones(20, dtype=bool)
    off_grid = np.array([LinearBeam().predict({"mu1": 0.37, "mu2": 0.71}, 3.0)])
    assert np.linalg.norm(parity.residuals(off_grid, 3.0, every)) < 0.1
    projector = parity.projector(every)
    assert projector @ projector == pytest.approx(projector, abs=1e-12)
    without = every.copy()
    without[4] = False
    assert not parity.projector(without)[4].any()
    assert parity.degrees(without) == parity.degrees(every) - 1


def test_a_missing_gauge_leaves_the_evidence_of_the_unknown_a_lower_bound(watch):
    readings = np.full((2, 20), 1.0)
    readings[1, 4] = np.nan
    monitor_state = watch.observe(watch.start(2), readings, 1.0)
    every = Parity(watch.library, 3.0).degrees(np.ones(20, dtype=bool))
    assert monitor_state.degrees.tolist() == [every, 20]
    assert watch.observe(monitor_state, readings[::-1], 1.0).degrees.tolist() == [20, 20]


def test_damage_outside_the_library_is_found_named_and_proposed(watch, library):
    monitor_state, _ = keep(watch, 60, 2, lambda k, x, load: x + (k >= 10) * load * BUMP)
    assert monitor_state.is_alarm.mean() >= 0.95
    finding = explain(watch, monitor_state, row=0, state=library.index_of({"mu1": 0.2}))
    assert (finding.kind, finding.name) == ("foreign damage", "at half span")
    assert finding.probability > 0.9
    assert finding.proposal.size == pytest.approx(40.0, abs=4 * finding.proposal.sd)
    assert finding.proposal.state["mu1"] == 0.2
    assert "Inspect" in finding.words
    wider = library.with_state(finding.proposal.state, finding.proposal.strains)
    assert wider.n_states == library.n_states + 1
    assert wider.parameters[-1] == "at half span"


def test_what_no_suspect_explains_is_called_unknown(watch):
    odd = 60.0 * np.where(np.arange(20) % 2, 1.0, -1.0)
    monitor_state, _ = keep(watch, 20, 3, lambda k, x, load: x + load * odd)
    finding = explain(watch, monitor_state)
    assert monitor_state.is_alarm.all()
    assert finding.kind == "unknown"
    assert "no candidate explains" in finding.words
    assert len(finding.gauges) > 5
    assert finding.since == 0


@pytest.mark.parametrize("fault", ["bias", "dead"])
def test_a_faulty_gauge_is_named(watch, fault):
    def change(k, x, load):
        if k >= 20:
            x[:, 6] = 0.0 if fault == "dead" else x[:, 6] + 100.0
        return x

    monitor_state, _ = keep(watch, 40, 4, change)
    findings = [explain(watch, monitor_state, row) for row in range(40)]
    assert monitor_state.is_alarm.all()
    assert np.mean([(f.kind, f.name) == ("gauge", "g07") for f in findings]) >= 0.95
    assert findings[0].gauges[0] == "g07"
    assert findings[0].proposal is None


def stream(watch, readings, load=3.0):
    """Return the findings about one asset."""
    monitor = Monitor(ModelSelector(watch.library, Leaf(0)), watch=watch)
    found = [result.finding for result in monitor.run((load, row.tolist()) for row in readings)]
    return [finding for finding in found if finding is not None]


@pytest.fixture(scope="module")
def placed(library) -> Watch:
    return Watch(library, places=np.column_stack([ETA, np.zeros(20)]))


@pytest.mark.long
def test_neighbours_that_begin_to_disagree_together_are_damage(placed, library):
    rng, found = np.random.default_rng(8), []
    for _ in range(20):
        readings = 3.0 * library.strains[np.zeros(60, int)] + rng.normal(0.0, SD, (60, 20))
        readings[25:, 9] += 150.0
        readings[25:, 10] -= 50.0
        found.append(stream(placed, readings)[-1])
    assert np.mean([finding.kind == "unknown" for finding in found]) >= 0.95
    assert all(set(finding.together) <= {"g09", "g10", "g11", "g12"} for finding in found)
    assert "began to disagree together" in next(finding.words for finding in found if finding.together)


@pytest.mark.long("10-True", "16-False")
@pytest.mark.parametrize(("second", "places"), [(10, True), (16, True), (16, False)])
def test_gauges_that_fail_one_by_one_are_each_named(placed, library, second, places):
    rng, named = np.random.default_rng(9), []
    watch = placed if places else Watch(library)
    for _ in range(8):
        readings = 3.0 * library.strains[np.zeros(60, int)] + rng.normal(0.0, SD, (60, 20))
        readings[20:, 9] += 150.0
        readings[40:, second] = 0.0
        named.append([(finding.kind, finding.name) for finding in stream(watch, readings)])
    assert named.count([("gauge", "g10"), ("gauge", f"g{second + 1:02d}")]) >= 7


def test_two_gauges_far_apart_that_fail_at_once_are_named(placed, library):
    readings = 3.0 * library.strains[np.zeros(40, int)] + np.random.default_rng(1).normal(0.0, SD, (40, 20))
    readings[10:, [2, 12]] += 90.0
    assert {finding.name for finding in stream(placed, readings)} == {"g03", "g13"}


def test_missing_gauges_are_done_without(watch):
    def gaps(k, x, load):
        x[:, k % 20] = np.nan
        x[:, 3] = np.nan
        return x

    monitor_state, p_values = keep(watch, 200, 6, gaps)
    assert kstest(p_values.ravel()[::7], "uniform").pvalue > 0.01
    assert monitor_state.is_alarm.mean() <= 0.1
    nothing = watch.observe(watch.start(1), np.full((1, 20), np.nan), 3.0)
    assert nothing.p_value[0] == 1.0
    assert not nothing.is_alarm[0]


def test_the_effects_of_a_twin_are_suspects(library):
    shape = Field("foreign damage", BUMP / LinearBeam().predict({}, 1.0), None, 10.0)
    both = effect_candidates(LinearBeam(), shape, library)
    assert both[0].name == "foreign damage"
    assert set(both[0].sizes) == {10.0, -10.0, 20.0, -20.0, 40.0, -40.0}
    assert both[0].signature == pytest.approx(BUMP)
    assert [s.name for s in gauge_candidates(library)] == list(library.gauges)


def test_a_watch_that_cannot_be_is_refused(library):
    with pytest.raises(ProblemError, match=r"rate is 1\.5"):
        Watch(library, rate=1.5)
    few = library_of(LinearBeam(), grid_states([(0.0, 0.4, 0.8), (0.0, 0.4)]), SD, gauges=("g01", "g16"))
    with pytest.raises(ProblemError, match=r"places has shape \(20,\)"):
        Watch(library, places=ETA)
    with pytest.raises(ProblemError, match="can explain any reading of 2 gauges"):
        Watch(few)


def test_one_asset_can_be_taken_back_and_the_others_stay(watch, library):
    monitor_state = watch.start(3)
    far = 3.0 * library.strains[:3] + 3.0 * BUMP * 5
    for _ in range(4):
        monitor_state = watch.observe(monitor_state, far, 3.0)
    back = watch.restarted(monitor_state, 1)
    assert back.is_alarm.tolist() == [True, False, True]
    assert not back.sums[1].any()
    assert np.array_equal(back.log_evidence[[0, 2]], monitor_state.log_evidence[[0, 2]])
    quiet = watch.observe(back, 3.0 * library.strains[:3], 3.0)
    assert not quiet.is_alarm[1]
    assert quiet.p_value[1] > 0.99


@pytest.mark.parametrize("digits", [0.01, SD])
def test_a_gauge_that_is_stuck_at_a_value_of_a_sound_one_is_named(placed, library, digits):
    readings = 3.0 * library.strains[np.zeros(90, int)] + np.random.default_rng(4).normal(0.0, SD, (90, 20))
    readings[20:, 6] = 3.0 * library.strains[0, 6]
    found = stream(placed, np.round(readings / digits) * digits)
    assert [(finding.kind, finding.name) for finding in found] == [("gauge", "g07")]
    assert "again and again" in found[0].words


@pytest.mark.parametrize("rounded", [lambda own: own, lambda own: np.round(own), lambda own: np.round(own / 3.0)])
def test_sound_gauges_are_stuck_with_the_stated_chance_whatever_their_digits(rounded):
    own, n_stuck = np.random.default_rng(2).normal(size=(400, 100, 20)), 0
    for mission in rounded(own):
        repeats, was_stuck = Repeats(np.full(20, np.nan)), False
        for row in mission:
            repeats.count(row)
            was_stuck |= bool(repeats.is_stuck(0.05 / (20 * 100)).any())
        n_stuck += was_stuck
    assert n_stuck <= 0.05 * 400


def test_a_stuck_gauge_began_with_no_neighbour(placed, library):
    readings = 3.0 * library.strains[np.zeros(60, int)] + np.random.default_rng(8).normal(0.0, SD, (60, 20))
    readings[25:, 9] = readings[24, 9]
    readings[26:, 10] += 60.0
    assert {(finding.kind, finding.name) for finding in stream(placed, readings)} == {
        ("gauge", "g10"),
        ("gauge", "g11"),
    }
