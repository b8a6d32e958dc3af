"""The page of a mission: any library, any twin, with or without what a monitor may lack; in a real browser."""

import datetime
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.oracles.hostile_names import hostile_names
from benchmarks.oracles.page_check import check_page
from octmip.errors import DataError
from octmip.interfaces.report.mission import Course, MissionStep, Region, mission_page
from octmip.monitor import (
    Filter,
    LeafLikelihood,
    ModelSelector,
    Monitor,
    ParameterTree,
    Watch,
    grid_states,
    library_of,
    steady_growth,
)
from octmip.trees.tree import Leaf, Split

LEVELS = (0.0, 0.4, 0.8)


class Bridge:
    gauges, parameters, effects = tuple(f"g{k}" for k in range(1, 7)), ("east", "west"), {}
    gauge_positions = np.column_stack([np.zeros(6), np.linspace(0.0, 30.0, 6)])
    outline = np.array([[-1.0, 0.0], [1.0, 0.0], [1.0, 30.0], [-1.0, 30.0]])
    is_linear_in_load = True

    def predict(self, state, load_factor):
        wear = np.linspace(0.0, 1.0, 6) * state.get("east", 0.0) + np.linspace(1.0, 0.0, 6) * state.get("west", 0.0)
        return load_factor * (500.0 + 300.0 * wear)


TWIN = Bridge()
LIBRARY = library_of(TWIN, grid_states([LEVELS, LEVELS]), 20.0)
CELLS = library_of(TWIN, grid_states([np.arange(0.05, 1.0, 0.1)] * 2), 20.0, widths=(0.1, 0.1))
TREES = [
    ParameterTree("east", Split(5, 560.0, Leaf(0), Split(5, 680.0, Leaf(1), Leaf(2))), LEVELS, TWIN.gauges),
    ParameterTree("west", Split(0, 640.0, Leaf(0), Leaf(2)), LEVELS, TWIN.gauges),
]
LIMITS = {"east": 0.4}


@pytest.fixture(scope="module")
def steps():
    """A bridge whose east bearing wears out; gauge g3 goes wrong at step 20, and reading 5 is too short."""
    rng = np.random.default_rng(0)
    selector = ModelSelector.of_trees(LIBRARY, TREES)
    chain = Filter(LeafLikelihood(selector.tree, CELLS), steady_growth(CELLS, (0.002, 0.02), 0.0005, 0.01))
    truth = [{"east": 0.02 * k} for k in range(40)]
    fault = 150.0 * np.eye(6)[2]
    readings = [TWIN.predict(t, 1.0) + rng.normal(0, 20.0, 6) + fault * (k >= 20) for k, t in enumerate(truth)]
    stream = [(1.0, r.tolist() if k != 5 else r.tolist()[:2]) for k, r in enumerate(readings)]
    found = []
    for result in Monitor(selector, chain, Watch(LIBRARY, horizon=40), start_state=0).run(stream):
        k = result.number
        worn = k != 5 and result.belief.quantile("east", 0.5)[0] > 0.4
        decision = "light traffic only" if worn else "open"
        row = readings[k] if k != 5 else np.full(6, np.nan)
        found.append(
            MissionStep(result, 1.0, row, decision, worn, f"Reason {k}.", truth[k], (float(k), 0.0), {"Cars": f"{k}"})
        )
    return found


def page_of(steps, **settings):
    chosen = {"twin": TWIN, "limits": LIMITS, "made": datetime.date(2026, 3, 1), "data": "bridge", **settings}
    return mission_page(steps, CELLS, TREES, **chosen)


def held(page):
    return json.loads(re.search(r'id="mission">(.*?)</script>', page, re.DOTALL).group(1))


def test_the_page_holds_what_the_mission_held(steps):
    page = page_of(steps)
    assert not re.search(r'(src|href)="(?!data:)|@import|fetch\(|https?://(?!www.w3.org/2000/svg)', page)
    data = held(page)
    assert len(data["steps"]) == 40
    assert data["steps"][5]["refused"].startswith("reading has 2 values")
    assert data["steps"][5]["belief"] == data["steps"][4]["belief"]
    assert data["steps"][5]["paths"] == [[], []]
    assert data["steps"][5]["told"] == [None, None]
    alarm = next(k for k, step in enumerate(data["steps"]) if step["alarm"])
    assert 20 <= alarm <= 25
    assert "gauge g3 is faulty" in data["steps"][alarm]["alarm"]
    for entry, step in zip(data["steps"], steps, strict=True):
        if entry["refused"]:
            continue
        belief = step.result.belief
        state = [belief.quantile(name, 0.5)[0] for name in CELLS.parameters]
        assert [one["median"] for one in entry["belief"]] == pytest.approx(state, abs=1e-4)
        expected = TWIN.predict(dict(zip(CELLS.parameters, state, strict=True)), 1.0)
        shown = [TWIN.gauges.index(name) for name in data["traced"]]
        assert [pair[1] for pair in entry["strain"]] == pytest.approx(expected[shown], abs=0.2)
        assert [pair[0] for pair in entry["strain"]] == pytest.approx(step.reading[shown], abs=0.06)


def test_the_first_sentence_says_how_it_went_and_the_footer_of_what(steps):
    page = page_of(steps)
    alarm = next(k for k, step in enumerate(held(page)["steps"]) if step["alarm"])
    turn = next(k for k, step in enumerate(steps) if step.is_cautious)
    sentence = re.search(r'<p class="verdict">(.*?)</p>', page, re.DOTALL).group(1)
    first = f"&#34;light traffic only&#34; from step {turn}"
    for part in ("At first &#34;open&#34;; ", first, f"alarm of the watch at step {alarm}", "1 reading refused."):
        assert part in sentence
    assert "1 March 2026" in page
    assert "bridge" in page


def test_a_mission_without_watch_filter_trees_twin_and_decisions_has_its_page(steps):
    selector = ModelSelector.of_trees(LIBRARY, TREES)
    stream = [(1.0, step.reading.tolist()) for step in steps if np.isfinite(step.reading).all()]
    results = Monitor(selector).run(stream)
    plain = [MissionStep(r, 1.0, np.array(row)) for r, (_, row) in zip(results, stream, strict=True)]
    page = mission_page(plain, LIBRARY)
    assert "39 readings." in page
    assert "State of the asset" not in page
    assert held(page)["steps"][0]["belief"] is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"steps": []}, "the mission has no step"),
        ({"limits": {"north": 0.4}}, "no parameter 'north'"),
        ({"names": {"north": "N"}}, "no parameter 'north'"),
        ({"traced": ("g99",)}, "no gauge 'g99'"),
        ({"regions": (Region("north", [[0, 0]]),)}, "no parameter 'north'"),
    ],
)
def test_what_does_not_fit_together_is_refused(steps, change, words):
    with pytest.raises(DataError, match=words):
        page_of(**{"steps": steps, **change})


def test_a_reading_of_another_length_is_refused(steps):
    with pytest.raises(DataError, match=r"step 1 of the mission has a reading of shape \(2,\)"):
        page_of([steps[0], replace(steps[1], reading=np.zeros(2))])


COURSE = Course(
    {"straight on": [[0.0, 0.0], [40.0, 0.0]], "round": [[0.0, 5.0], [40.0, 9.0]]}, ((20.0, 4.0, 2.0),), 40.0
)
REGIONS = (Region("east", [[-1, 20], [1, 20], [1, 30], [-1, 30]]), Region("west", [[-1, 0], [1, 0], [1, 10], [-1, 10]]))


@pytest.fixture(scope="module")
def path(steps, tmp_path_factory):
    path = tmp_path_factory.mktemp("mission") / "mission.html"
    path.write_text(page_of(steps, course=COURSE, regions=REGIONS, names={"east": "Wear in the east"}))
    return path


def test_the_page_holds_in_every_window(browser, path):
    assert check_page(path, browser) == []


@pytest.fixture
def page(browser, path):
    opened = browser.new_page(viewport={"width": 1280, "height": 900})
    opened.goto(path.as_uri())
    yield opened
    opened.close()


def test_every_control_moves_the_mission(page, steps):
    step = page.locator("#step")
    assert step.inner_text() == "step 39 of 39"  # the whole mission at first
    page.locator("#slider").fill("30")
    assert step.inner_text() == "step 30 of 39"
    assert page.locator("#reason").inner_text() == "Reason 30."
    assert "Cars30" in page.locator("#numbers").inner_text()
    page.locator("#back").click()
    assert step.inner_text() == "step 29 of 39"
    page.locator("#on").click()
    assert step.inner_text() == "step 30 of 39"
    alarm = page.locator(".events li", has_text="gauge g3 is faulty")
    alarm.locator("button").click()
    assert step.inner_text() == f"step {alarm.locator('button').get_attribute('data-step')} of 39"
    assert "gauge g3 is faulty" in page.locator("#found").inner_text()
    assert page.locator("#structure circle.off").count() >= 1
    page.locator("#slider").fill("5")
    assert page.locator("#reason").inner_text().startswith("This reading is refused: reading has 2 values")
    assert page.locator("#tree1 .lit").count() == 0
    page.locator("#slider").fill("0")
    assert page.locator("#tree1 .lit").count() == 2
    assert page.locator("#course line.bold").count() == 0


def test_play_runs_to_the_end_and_the_keyboard_steps(page):
    expect = pytest.importorskip("playwright.sync_api").expect
    step, play = page.locator("#step"), page.locator("#play")
    page.locator("#slider").fill("36")
    play.click()
    expect(play).to_have_text("Play", timeout=30_000)
    assert step.inner_text() == "step 39 of 39"
    page.locator("#slider").focus()
    page.keyboard.press("Home")
    for key in ("ArrowRight", "ArrowRight", "ArrowLeft"):
        page.keyboard.press(key)
    assert step.inner_text() == "step 1 of 39"
    page.keyboard.press("PageDown")
    assert step.inner_text() == "step 11 of 39"
    page.keyboard.press("Space")
    expect(play).to_have_text("Pause")
    page.keyboard.press("Space")
    expect(play).to_have_text("Play")
    play.focus()
    page.keyboard.press("Space")  # heard once: by the button
    expect(play).to_have_text("Pause")
    page.keyboard.press("Enter")
    expect(play).to_have_text("Play")


def test_names_run_nothing_even_without_the_policy(browser, steps, tmp_path):
    names = [name for _, name in hostile_names(60) if len(name) < 100]
    library, gauges = CELLS, tuple(names[:6])
    library = replace(library, gauges=gauges)
    trees = [replace(tree, gauges=gauges) for tree in TREES]
    worse = "</script><script>window.__pwned=1</script>\x1b"
    changed = [replace(s, decision=worse, reason=names[k], figures={names[k]: worse}) for k, s in enumerate(steps)]
    text = mission_page(changed, library, trees, title=worse, names={"east": worse}, data=worse)
    path = tmp_path / "mission.html"
    path.write_text(re.sub('<meta http-equiv="Content-Security-Policy"[^>]*>', "", text), encoding="utf-8")
    assert "Content-Security-Policy" in text
    opened = browser.new_page()
    said = []
    opened.on("console", lambda message: said.append(message.text))
    opened.on("pageerror", lambda error: said.append(str(error)))
    opened.on("dialog", lambda dialog: (said.append(dialog.message), dialog.dismiss()))
    opened.goto(path.as_uri())
    opened.locator("#slider").fill("30")
    assert said == []
    assert opened.evaluate("typeof window.__pwned") == "undefined"
    opened.close()
