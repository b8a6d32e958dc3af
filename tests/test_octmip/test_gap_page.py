"""What a test engineer reads: the page of words, and the report in a browser."""

import dataclasses
import json
import re

import numpy as np
import pytest

from octmip.gap import diagnose
from octmip.input.names import shown
from octmip.interfaces.report.diagnosis.as_json import as_object
from octmip.interfaces.report.diagnosis.measured import measured_cells
from octmip.interfaces.report.diagnosis.page import report_page
from octmip.interfaces.report.diagnosis.recommendation import recommend
from octmip.interfaces.report.diagnosis.words import page_of_words
from octmip.trees.nodes.tree import Leaf, Split
from tests.oracles.hostile_names import hostile_names
from tests.oracles.page_check import check_page
from tests.test_octmip.beam_twin import Beam, effect, measured, own_effects

TWIN = Beam()
COMMISSIONING = measured(1000)
WARM = effect("temperature_uniform", 10.0)
TREE = Split(
    feature=0, threshold=640.0, left=Leaf(0), right=Split(feature=1, threshold=9e9, left=Leaf(1), right=Leaf(2))
)


def diagnosed(**settings):
    return diagnose(measured(3, change=WARM, **settings), TWIN, None, COMMISSIONING, TREE, TWIN.gauges)


@pytest.fixture(scope="module")
def diagnoses():
    return {
        "known": diagnosed(),
        "one load": diagnosed(loads=(2.0,)),
        "unknown state": diagnosed(states=((0.4, 0.2), (0.0, 0.5)), loads=(1.0, 2.0), known=False),
        "sound": diagnose(measured(4), TWIN, None, COMMISSIONING, TREE, TWIN.gauges),
    }


CASES = ["known", "one load", "unknown state", "sound"]


@pytest.mark.parametrize("case", CASES)
def test_the_page_of_words_fits_a_terminal_and_says_no_nan(diagnoses, case):
    first, *lines = page_of_words(diagnoses[case]).splitlines()
    assert first.startswith("Nothing to do" if case == "sound" else "Add temperature uniform to the twin: size of the")
    assert max(len(line) for line in (first, *lines)) <= 118
    assert "nan" not in page_of_words(diagnoses[case])


def test_the_page_says_what_an_effect_means_and_what_closed(diagnoses):
    page = page_of_words(diagnoses["known"])
    assert "Size of the temperature uniform, in K: size of the field." in page
    assert "of its mean square has closed" in page
    assert "load factor 3 predicted from the others" in page
    assert "With one load and one test nothing can be held out" in page_of_words(diagnoses["one load"])
    assert as_object(diagnoses["one load"])["shrinkage"]["closed"] is None
    assert "T1: mu1 0.0" in page_of_words(diagnoses["unknown state"])
    assert "Detectable sizes" in page_of_words(diagnoses["sound"])


def test_the_json_object_has_its_stable_keys_and_is_json(diagnoses):
    found = json.loads(json.dumps(as_object(diagnoses["known"]), allow_nan=False))
    keys = {"where", "which", "ambiguity", "parameters", "unknown_probability", "noise", "shrinkage", "next_test"}
    assert keys <= set(found)
    assert found["which"][0]["effects"] == ["temperature_uniform"]
    assert (found["kind"], found["parameters"][0]["unit"]) == ("cause", "K")


@pytest.mark.parametrize("case", CASES)
def test_no_code_name_and_no_python_object_is_shown(diagnoses, case):
    text = re.sub("<style>.*?</style>|<script>.*?</script>", "", report_page(diagnoses[case]), flags=re.DOTALL)
    for words in (page_of_words(diagnoses[case]), re.sub("<[^>]*>", " ", text)):
        assert not re.search(r"[a-z]_[a-z]", words)
        assert not re.search(r"\bNone\b(?!:)|\{'|\bnan\b|array\(", words)


@pytest.mark.parametrize("case", CASES)
def test_the_page_holds_in_every_window_and_shows_all_figures(browser, diagnoses, tmp_path, case):
    path, diagnosis = tmp_path / "report.html", diagnoses[case]
    path.write_text(report_page(diagnosis, data="campaign.csv", twin="beam:Beam"))
    if case in ("known", "unknown state"):  # those with most on them
        assert check_page(path, browser, presses=case == "known") == []
    page = browser.new_page()
    page.goto(path.as_uri())
    maps, is_sound = page.locator("svg.map"), case == "sound"
    assert maps.count() == (1 if is_sound else 2)
    assert maps.first.locator("circle").count() == 20
    cells = diagnosis.posterior.model.inputs.campaign.cells
    panels = page.locator(".panels:not(.small) svg")
    assert panels.count() == len(cells)
    assert panels.first.locator("circle").count() == (20 if is_sound else 40)
    assert page.locator(".panels.small svg").count() == 20
    assert page.locator("svg > title").count() == page.locator("svg > desc").count() == page.locator("svg").count()
    heads = page.locator("h2").all_inner_texts()
    sizes = ["Detectable sizes"] if is_sound else []
    assert heads[:3] == ["Measured against predicted", "Where the gap lies", "Which effect explains it"]
    assert heads[3:6] == [*sizes, "How far the gap closes", "Which test to run next"][:3]
    assert page.locator(".verdict").inner_text() == recommend(diagnosis)
    assert "campaign.csv" in page.locator("footer").inner_text()
    page.close()


def test_the_figures_show_the_mean_readings_and_the_effect_closes_them(diagnoses):
    cells = measured_cells(diagnoses["known"])
    campaign = diagnoses["known"].posterior.model.inputs.campaign
    for cell, own in zip(cells, campaign.cells, strict=True):
        assert cell.measured == pytest.approx(own.mean)
        assert cell.half_width == pytest.approx(1.645 * 31.6 / np.sqrt(50), rel=0.15)
    assert np.abs([cell.before.mean() + 25.0 for cell in cells]).max() < 5.0
    assert np.abs([cell.after.mean() for cell in cells]).max() < 5.0
    sound = measured_cells(diagnoses["sound"])
    assert all(np.array_equal(cell.twin, cell.repaired) for cell in sound)


@pytest.fixture(scope="module")
def hostile():
    """A diagnosis in which every gauge, test and effect has a hostile name."""
    drawn = [name for _, name in hostile_names(120) if len(name) < 100]
    names = ["\x1b[2J", *(name for name in drawn if not {"/", "<"} & set(name))][:20]  # the signs join two gauges
    worse = ["<img src=x onerror=window.__pwned=1>", "</pre><script>alert(1)</script>", *drawn[:3]]
    effects = [dataclasses.replace(e, name=n) for e, n in zip(own_effects().values(), worse, strict=True)]
    twin = Beam(gauges=tuple(names), effects={effect.name: effect for effect in effects})
    campaign = measured(3, change=WARM)
    tests = tuple("<script>window.__pwned=1</script>\x1b[2J" for _ in campaign.test)
    campaign = dataclasses.replace(campaign, gauges=twin.gauges, test=tests)
    return diagnose(campaign, twin, tree=TREE, feature_names=twin.gauges, noise_sd=5.0), names


def test_names_in_the_page_of_words_do_not_act(hostile):
    diagnosis, _ = hostile
    page = page_of_words(diagnosis)
    assert all(line.isprintable() for line in page.split("\n"))
    assert "\\x1b[2J" in page


def test_names_in_the_report_run_nothing_even_without_its_policy(browser, hostile, tmp_path):
    diagnosis, names = hostile
    text = report_page(diagnosis)
    without = re.sub('<meta http-equiv="Content-Security-Policy"[^>]*>', "", text)
    assert len(text) - len(without) > 100
    assert all(line.isprintable() for line in text.split("\n") if line.strip())
    path = tmp_path / "report.html"
    path.write_text(without)
    page = browser.new_page()
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("dialog", lambda dialog: (said.append(dialog.message), dialog.dismiss()))
    page.on("request", lambda request: said.append(request.url) if request.url != path.as_uri() else None)
    page.goto(path.as_uri())
    assert said == []
    assert page.evaluate("typeof window.__pwned") == "undefined"
    titles = page.locator("svg.map circle title").all_text_contents()
    assert {title.rpartition(":")[0] for title in titles} == {shown(name) for name in names}
    page.close()


def _lines(diagnosis):
    """The places of every predicted line on the page, gauge by gauge."""
    found = re.findall(r'<polyline points="([^"]*)" class="before"/>', report_page(diagnosis))
    return [[tuple(map(float, place.split(","))) for place in points.split()] for points in found]


def test_what_is_predicted_is_drawn_where_each_test_has_one_load(diagnoses):
    """One point was a line of no length."""
    campaign = measured(3, change=WARM)
    named = dataclasses.replace(campaign, test=tuple(f"at {load:g}" for load in campaign.load_factor))
    lines = _lines(diagnose(named, TWIN, None, COMMISSIONING))
    assert {len(line) for line in lines} == {len(set(campaign.load_factor))}
    assert all(np.ptp([x for x, _ in line]) > 0.0 for line in [*lines, *_lines(diagnoses["one load"])])
