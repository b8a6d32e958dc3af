"""The mission in small: its course, what becomes of the aircraft, and the page in a real browser."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.oracles.page_check import check_page
from benchmarks.uav.mission import course
from benchmarks.uav.mission.aircraft import Aircraft, build_aircraft, capability
from benchmarks.uav.mission.filter_study import filter_rows
from benchmarks.uav.mission.flight import Flight, recorded
from benchmarks.uav.mission.histories import KINDS, draw
from benchmarks.uav.mission.page import flight_page
from benchmarks.uav.mission.policies import POLICIES, Pilot, loss_of_state
from benchmarks.uav.mission.policy_table import wilson
from benchmarks.uav.mission.simulation import fly
from benchmarks.uav.mission.table_twin import TableTwin
from benchmarks.uav.mission.watch_study import told_limit
from femlib.dataset import published_strains
from femlib.wing import reduced_twin, uav_wing

SHARED = Path(__file__).parents[3] / "shared" / "uav" / "strains.csv"


@pytest.fixture(scope="module")
def aircraft(tmp_path_factory: pytest.TempPathFactory) -> Aircraft:
    with pytest.MonkeyPatch.context() as patch:  # a coarse mesh: the course is the same
        patch.setattr("benchmarks.uav.mission.aircraft.uav_twin", lambda: reduced_twin(uav_wing(refinement=0.35)))
        return build_aircraft(tmp_path_factory.mktemp("mission"), depth=2)


@pytest.fixture(scope="module")
def flight(aircraft: Aircraft) -> Flight:
    return recorded(aircraft, "paper", 0)


# The wing and the course


def test_a_table_twin_is_the_wing_at_its_levels_and_close_between_them(aircraft: Aircraft):
    columns = [aircraft.wing.gauges.names.index(gauge) for gauge in aircraft.gauges]
    reduced = aircraft.twin.effects["damage_outside_library"].twin
    at_level, between = np.array([[0.3, 0.6]]), np.array([[0.35, 0.55]])
    exact, near = (aircraft.wing.strains_microstrain(state, 1.0)[:, columns] for state in (at_level, between))
    assert aircraft.strains(at_level) == pytest.approx(reduced.predict_states(at_level, 1.0)[:, columns], abs=1e-6)
    bound = reduced.error_bound(at_level, 1.0)[:, columns]
    assert (np.abs(aircraft.strains(at_level) - exact) <= bound).all()
    assert aircraft.strains(between) == pytest.approx(near, abs=0.5)


def test_the_published_table_is_a_twin():
    if not SHARED.exists():
        pytest.skip(f"{SHARED} is not there")
    table = published_strains(SHARED)
    assert TableTwin.of(table).predict({"mu1": 0.2, "mu2": 0.6}, 3.0) == pytest.approx(table.strain_microstrain[8])


def test_the_lines_of_the_course_ask_for_no_more_than_they_say_and_clear_the_obstacles():
    assert 2.9 < course.largest_load(0.0) <= 3.0
    assert 1.9 < course.largest_load(1.0) <= 2.0
    x = np.linspace(0.0, course.GOAL, 2000)
    for width in (0.0, 0.3, 1.0):
        y = course.height(x, np.full(len(x), width))
        away = np.hypot(x[:, None] - np.array(course.OBSTACLES), (y - 5.0)[:, None])
        assert away.min() > course.RADIUS


@pytest.mark.parametrize("is_cautious", [False, True])
def test_a_step_is_as_long_as_it_says(is_cautious):
    x, width = np.zeros(1), np.zeros(1)
    way = [(0.0, 0.0)]
    while x[0] < course.GOAL:
        x, width = course.advance(x, width, np.array([is_cautious]))
        way.append((x[0], course.height(x, width)[0]))
    lengths = np.hypot(*np.diff(way, axis=0).T)  # to cross to the other line while climbing takes a little more
    assert lengths[20:] == pytest.approx(course.STEP_LENGTH, rel=0.03)
    assert lengths.max() < 1.25 * course.STEP_LENGTH
    assert len(way) - 1 == (102 if is_cautious else 92)


def test_a_wing_bears_three_g_to_forty_percent_and_two_at_eighty():
    damage = np.array([[0.0, 0.0], [0.4, 0.1], [0.1, 0.6], [0.8, 0.8]])
    assert capability(damage) == pytest.approx([3.0, 3.0, 2.5, 2.0])


# Missions


@pytest.mark.parametrize("kind", KINDS)
def test_histories_are_what_their_kind_says(kind):
    histories = draw(kind, 200, np.random.default_rng(0), (3, 5))
    assert np.all(np.diff(histories.damage, axis=1) >= 0.0)
    assert histories.damage.max() <= 0.8
    assert set(np.unique(histories.dead_gauge)) == ({3, 5} if kind == "dead gauge" else {-1})
    assert (histories.outside > 0).all() == (kind == "outside")


def test_policies_keep_their_order(aircraft: Aircraft):
    lost, steps = {}, {}
    chain = aircraft.filter(10)
    for policy in POLICIES[:-1]:
        rng = np.random.default_rng(3)
        histories = draw("paper", 150, rng, (0,))
        flights = fly(aircraft, histories, Pilot(policy, aircraft, 150, chain, None), rng)
        lost[policy.name], steps[policy.name] = flights.is_lost.mean(), flights.steps[~flights.is_lost]
    assert lost["oracle"] == lost["always cautious"] == 0.0
    assert lost["never cautious"] == 1.0
    assert lost["filter, expected loss"] <= lost["filter, 40 %"] < lost["trees, 40 % (the paper's)"]
    assert steps["oracle"].mean() <= steps["filter, expected loss"].mean() <= steps["always cautious"].mean()


def test_the_expected_loss_is_that_of_drawn_wings(aircraft: Aircraft):
    chain = aircraft.filter(10)
    rng = np.random.default_rng(1)
    for state in (33, 56, 99):
        damage = chain.library.states[state] + rng.uniform(-0.04, 0.04, (20_000, 2))
        fails = (capability(damage, rng.uniform(0.0, 0.5, 20_000)) < 3.0).mean()
        assert loss_of_state(chain)[state] == pytest.approx(fails, abs=0.02)


def test_the_filter_beats_the_tree_and_covers(aircraft: Aircraft):
    rows = filter_rows(aircraft, 60, 4, kinds=("paper",))
    second = next(row for row in rows if row["parameter"] == "mu2" and row["observation"] == "leaf")
    assert second["lower by %"] > 30
    assert 85 < second["coverage, calibrated 90 % sets %"] < 95


def test_the_interval_of_a_share_is_wilsons():
    assert wilson(0, 100) == pytest.approx((0.0, 0.0370), abs=1e-4)
    assert wilson(50, 100) == pytest.approx((0.4038, 0.5962), abs=1e-4)


def test_the_limit_of_the_watch_is_that_of_a_test_told_everything():
    rng = np.random.default_rng(0)
    power = (rng.normal(told_limit(0.01), 1.0, 20_000) > 2.326).mean()  # one normal, a false alarm in a hundred
    assert power == pytest.approx(0.95, abs=0.006)


# The page (what every mission page keeps is tested with octmip.interfaces.report.mission)


def held(page: str) -> dict:
    return json.loads(re.search(r'id="mission">(.*?)</script>', page, re.DOTALL).group(1))


def test_the_page_says_what_the_flight_says(aircraft: Aircraft, flight: Flight):
    page = flight_page(aircraft, flight)
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert "@import" not in page
    assert "fetch(" not in page
    data = held(page)
    assert [step["reason"] for step in data["steps"]] == [step.reason for step in flight.steps]
    assert len(data["trees"]) == 2
    assert len(data["structure"]["regions"]) == 2
    assert len(data["structure"]["gauges"]) == len(aircraft.gauges)
    first_cautious = next(k for k, step in enumerate(flight.steps) if step.is_cautious)
    assert 35 <= first_cautious <= 65  # the path changes at about 40 %
    assert "over 40 %" in flight.steps[first_cautious].reason
    assert f"&#34;2 g, wide turns&#34; from step {first_cautious}" in page
    for step, own in zip(data["steps"], flight.steps, strict=True):
        median = own.result.belief.quantile("mu1", 0.5)[0]
        assert step["belief"][0]["median"] == pytest.approx(median, abs=1e-4)
        assert step["truth"] == pytest.approx([own.truth["mu1"], own.truth["mu2"]], abs=1e-4)
        assert step["at"] == pytest.approx(own.at, abs=0.01)


def test_the_page_opens_in_every_window_and_plays(browser, aircraft: Aircraft, flight: Flight, tmp_path: Path):
    path = tmp_path / "mission.html"
    path.write_text(flight_page(aircraft, flight))
    assert check_page(path, browser, presses=False) == []
    page, last = browser.new_page(viewport={"width": 1280, "height": 900}), len(flight.steps) - 1
    page.goto(path.as_uri())
    page.locator("#slider").fill("30")
    assert page.locator("#step").inner_text() == f"step 30 of {last}"
    assert page.locator("#reason").inner_text() == flight.steps[30].reason
    lit = page.locator("#tree1 .lit").count()
    assert lit == len(held(path.read_text())["steps"][30]["paths"][0])
    page.locator("#slider").fill(str(last - 3))
    page.locator("#play").click()
    assert page.locator("#play").inner_text() == "Pause"
    expect = pytest.importorskip("playwright.sync_api").expect
    expect(page.locator("#play")).to_have_text("Play", timeout=30_000)
    assert page.locator("#step").inner_text() == f"step {last} of {last}"
    assert page.locator("#decision").inner_text() == "2 g, wide turns"
    assert page.locator("#course line.cautious").count() == sum(s.is_cautious for s in flight.steps[:-1])
    page.close()
