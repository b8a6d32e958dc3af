"""The mission in small: its course, and what becomes of the aircraft."""

import numpy as np
import pytest

from benchmarks.uav.mission import lives, local_damage
from benchmarks.uav.mission.aircraft import Aircraft, build_aircraft
from benchmarks.uav.mission.capable import MOST, STEP, Capable
from benchmarks.uav.mission.course_plan import WIDE_STEPS
from benchmarks.uav.mission.histories import draw
from benchmarks.uav.mission.policies import POLICIES, Brain, Pilot
from benchmarks.uav.mission.simulation import fly
from femlib.wing import reduced_twin, uav_wing

LEVELS = np.linspace(0.0, MOST, round(MOST / STEP) + 1)
CAPABLE = Capable(4.0 - 1.6 * np.maximum(LEVELS[:, None], 0.2 * LEVELS))
"""A wing that bears 4 g, and less by 1.6 g where mu1 is whole: femlib's own takes a minute."""


@pytest.fixture(scope="module")
def aircraft(tmp_path_factory: pytest.TempPathFactory) -> Aircraft:
    with pytest.MonkeyPatch.context() as patch:  # a coarse mesh: the course is the same
        patch.setattr("benchmarks.uav.mission.aircraft.uav_twin", lambda: reduced_twin(uav_wing(refinement=0.3)))
        patch.setattr("benchmarks.uav.mission.aircraft.capable_wing", lambda folder: CAPABLE)
        return build_aircraft(tmp_path_factory.mktemp("mission"), depth=2)


def test_a_table_twin_is_the_wing_at_its_levels_and_close_between_them(aircraft: Aircraft):
    columns = [aircraft.wing.gauges.names.index(gauge) for gauge in aircraft.gauges]
    reduced = aircraft.twin.effects["damage_outside_library"].twin
    at_level, between = np.array([[0.3, 0.6]]), np.array([[0.35, 0.55]])
    exact, near = (aircraft.wing.strains_microstrain(state, 1.0)[:, columns] for state in (at_level, between))
    assert aircraft.strains(at_level) == pytest.approx(reduced.predict_states(at_level, 1.0)[:, columns], abs=1e-6)
    bound = reduced.error_bound(at_level, 1.0)[:, columns]
    assert (np.abs(aircraft.strains(at_level) - exact) <= bound).all()
    assert aircraft.strains(between) == pytest.approx(near, abs=0.5)


@pytest.mark.long
def test_policies_keep_their_order(aircraft: Aircraft):
    lost, cost, steps = {}, {}, {}
    brain = Brain.of(aircraft, 10)
    for policy in POLICIES[:-1]:
        rng = np.random.default_rng(3)
        histories = draw("paper", 300, rng, (0,))
        flights = fly(aircraft, histories, Pilot(policy, aircraft, 300, brain, None, histories.rates), rng)
        lost[policy.estimator, policy.rule, policy.level] = flights.lost.mean()
        cost[policy.estimator, policy.rule, policy.level] = flights.cost.mean()
        steps[policy.estimator, policy.rule, policy.level] = flights.arrival.mean()
    oracle, planner = ("truth", "plan", 0.5), ("filter", "plan", 0.5)
    always, never = ("nothing", "always", 0.5), ("nothing", "never", 0.5)
    assert lost[always] < 1e-9
    assert lost[never] > 0.5
    assert lost["filter", "limit", 0.02] <= lost["filter", "limit", 0.1]
    assert cost[oracle] <= cost[planner] < min(cost[one] for one in cost if one not in (oracle, planner))
    assert steps[oracle] <= steps[planner] <= steps[always] == WIDE_STEPS


@pytest.mark.long
def test_damage_at_two_gauges_is_told_by_the_watch_and_not_one_gauge_at_a_time(aircraft: Aircraft, monkeypatch):
    monkeypatch.setattr(local_damage, "DAMAGED", (2,))
    monkeypatch.setattr(local_damage, "FAILED", (1,))
    damaged, failed = local_damage.local_rows(aircraft, 8, 4)
    right = {name: int(str(told).split()[0]) for name, told in damaged.items() if name not in ("gauges", "seed")}
    assert right["the watch"] >= 7 > right["one gauge at a time"]
    assert int(str(failed["the watch"]).split()[0]) >= 7


@pytest.mark.long
def test_bands_of_a_forecast_hold_most_lives(aircraft: Aircraft, monkeypatch):
    monkeypatch.setattr(lives, "LONGEST", 1200)
    monkeypatch.setattr(lives, "FLOWN", 10)
    rows = list(lives.life_rows(aircraft, 60, 2))
    assert rows[0]["wings"] == "of any rate"
    assert 78.0 <= float(str(rows[0]["within 90 % bands %"])) <= 99.0, rows
