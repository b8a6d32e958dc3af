"""A page bears the reader's title, asset, day and units, and prints whole; the map shows where gauges sit."""

import datetime
import re
from pathlib import Path

import numpy as np
import pytest
from jinja2 import UndefinedError

from octmip import Problem, solve
from octmip.errors import DataError, TwinError
from octmip.formats.tree_file import record_tree
from octmip.gap import CachedTwin, Recorded, diagnose, function_twin, gathered
from octmip.interfaces.cli import main
from octmip.interfaces.report import page
from octmip.interfaces.report.diagnosis.page import report_page
from octmip.interfaces.report.diagnosis.words import page_of_words
from octmip.interfaces.report.html import tree_page
from octmip.interfaces.report.page import Masthead, page_facts, render
from octmip.twin import units_of
from tests.oracles.page_check import check_page
from tests.test_octmip.beam_twin import Beam

OWN = Masthead("Span 3 <b>", "Bridge & road", datetime.date(2026, 3, 14))
GAUGES = tuple(f"g{k}" for k in range(1, 9))


CARD = '{"readings": {"w1": "mm", "w2": "mm"}, "loads": ["force"], "parameters": {"k": [1, 0.5, 2, "kN/mm"]}}'


MODEL = "def spring(p, loads):\n    return [loads['force'] / p['k'], 2 * loads['force'] / p['k']]\n"


def bent(parameters, loads):
    return loads["force"] * np.linspace(810.0, 180.0, 8) - 12.0 * parameters["temperature"]


@pytest.fixture(scope="module")
def diagnosis():
    seats = {name: (0.25 * k, 0.5) for k, name in enumerate(GAUGES)}
    units = dict.fromkeys(GAUGES, "microstrain")
    twin = function_twin(bent, units, {"temperature": (0, -30, 30, "K")}, ("force",), positions=seats)
    rng, off = np.random.default_rng(1), 60.0 * (np.arange(8) == 5)
    tests = [Recorded(twin.predict({}, f) + off + rng.normal(0, 20, (40, 8)), {"force": f}) for f in (0, 1, 2)]
    return diagnose(gathered(twin, tests), twin)


def tree_file():
    problem = Problem(np.array([[0.0], [1.0]]), ["no", "yes"], depth=1, feature_names=("a",))
    return record_tree(problem, solve(problem), "side")


def test_every_page_bears_the_readers_heading(diagnosis):
    for text in (tree_page(tree_file(), masthead=OWN), report_page(diagnosis, masthead=OWN)):
        assert "<h1>Span 3 &lt;b&gt;</h1>" in text
        assert '<p class="asset">Bridge &amp; road</p>' in text
        assert "<title>Span 3 &lt;b&gt;, Bridge &amp; road</title>" in text
        assert "14 March 2026" in text


def test_the_command_gives_a_page_its_heading(tmp_path: Path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text("a,side\n0,no\n1,yes\n")
    assert main(["solve", "t.csv", "--label", "side", "--depth", "1", "--out", "t.json"]) == 0
    own = ["--title", "Doors", "--asset", "Hall 2", "--date", "2026-03-14"]
    assert main(["report", "t.json", "--out", "t.html", *own]) == 0
    page = Path("t.html").read_text()
    assert "<title>Doors, Hall 2</title>" in page
    assert "14 March 2026" in page
    for words, told in (
        (["report", "t.json", "--title", "x"], "--title is for a page; write one with --out PAGE.html"),
        (["report", "t.json", "--out", "u.html", "--date", "14.3.26"], "--date is '14.3.26'; expected a day such as"),
    ):
        assert main(words) == 2
        assert told in capsys.readouterr().err


def test_the_diagnosis_takes_the_same_heading_and_units_of_a_twin_that_names_none(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    Path("springs_of_test.py").write_text(MODEL)
    Path("card.json").write_text(CARD)
    rows = [f"pull,{f},{f + d},{2 * f - d}" for f in (1.0, 2.0, 3.0) for d in (-0.02, 0.0, 0.01, 0.01)]
    Path("c.csv").write_text("\n".join(["test,force,w1,w2", *rows]))
    asked = ["diagnose", "c.csv", "--twin", "python:springs_of_test:spring", "--card", "card.json"]
    assert main([*asked, "--out", "p.html", "--asset", "Rig 1", "--unit", "mm"]) == 0
    assert '<p class="asset">Rig 1</p>' in Path("p.html").read_text()
    assert main([*asked, "--unit", "w2=N"]) == 2
    assert "the twin says that 'w2' is in mm, but N was given" in capsys.readouterr().err
    assert main([*asked, "--unit", "w3=mm"]) == 2
    assert "--unit names 'w3', which is no reading of the twin" in capsys.readouterr().err


def test_stated_units_are_those_of_the_twin():
    twin = CachedTwin(Beam())
    assert units_of(twin.in_units({Beam().gauges[0]: "mm"}))[:2] == ("mm", "microstrain")
    with pytest.raises(TwinError, match="is in mm, but N was given"):
        twin.in_units(dict.fromkeys(Beam().gauges, "mm")).in_units({Beam().gauges[0]: "N"})


def test_the_diagnosis_shows_where_the_gauge_sits(diagnosis):
    assert diagnosis.which[0].parameters[0].place == "g6"
    assert "g6 sits at x 1.25 m, y 0.5 m." in page_of_words(diagnosis)
    page = report_page(diagnosis)
    assert "g6 sits at x 1.25 m, y 0.5 m." in page
    assert page.count('class="ring"') == 2  # before and after
    ring, dot = (re.search(rf'<circle cx="([\d.]+)" cy="([\d.]+)" r="\d+"[^>]*{end}', page) for end in RINGED)
    assert ring is not None
    assert dot is not None
    assert ring.groups() == dot.groups()


RINGED = ('class="ring"', r'class="gauge"><title>g6:')


@pytest.mark.parametrize(
    ("places", "told"),
    [
        ({"w1": (0, 0)}, "'w2' has no place in 'positions'"),
        ({"w1": (0, 0), "w2": (1, 0), "w3": (1, 1)}, "'w3' is no reading, but has a place"),
        ({"w1": (0, 0), "w2": (1, 0, 2)}, r"'w2' the place \[1.0, 0.0, 2.0\]; expected x and y"),
    ],
)
def test_places_that_are_none_are_refused(places, told):
    with pytest.raises(DataError, match=told):
        function_twin(bent, {"w1": "mm", "w2": "mm"}, positions=places)


TEMPLATE = """{% extends "base.html" %}{% from "parts.html" import cards, table, technical %}
{% block title %}{{ name }}{% endblock %}{% block verdict %}{{ value }}{% endblock %}
{% block sections %}{{ table(["a", "b"], [[name, 1234567]], right=(1,)) }}{% endblock %}
{% block embedded %}{{ embed("data", {"name": name}) }}{% endblock %}"""


@pytest.fixture(autouse=True)
def _template(monkeypatch: pytest.MonkeyPatch) -> None:
    from jinja2 import ChoiceLoader, DictLoader

    environment = page._environment(None)
    monkeypatch.setattr(environment, "loader", ChoiceLoader([DictLoader({"try.html": TEMPLATE}), environment.loader]))


def test_a_page_asks_for_nothing_from_elsewhere_and_runs_only_its_own_scripts():
    text = render("try.html", name="iris", value="all well", facts=[])
    assert not re.search(r"(src|href)=|url\(|@import|https?://", text)
    assert "default-src &#39;none&#39;" in text
    assert len(re.findall("sha256-", text)) == len(re.findall("<script>", text)) == 1


def test_hostile_text_stays_text_in_words_and_in_data():
    text = render("try.html", name="</script><b>\u202e\x1b", value="ok", facts=[])
    assert "<b>" not in text
    assert "&lt;/script&gt;&lt;b&gt;\\u202e\\x1b" in text
    assert '{"name":"\\u003c/script\\u003e\\u003cb\\u003e\\u202e\\u001b"}' in text


@pytest.mark.parametrize("value", [{"a": 1}, [1], None, True, 0.5])
def test_a_value_that_has_no_form_for_readers_is_refused(value: object):
    with pytest.raises(TypeError, match="expected text or a whole number"):
        render("try.html", name="iris", value=value, facts=[])


def test_a_value_that_is_not_given_is_refused_and_whole_numbers_are_grouped():
    with pytest.raises(UndefinedError, match="value"):
        render("try.html", name="iris", facts=[])
    assert "1,234,567" in render("try.html", name="iris", value="ok", facts=[])


def test_the_footer_names_day_data_digest_and_version():
    facts = page_facts("iris.csv", "ab", datetime.date(2026, 3, 1), twin_model="wing")
    assert facts[:4] == [
        ("Made", "1 March 2026"),
        ("Data", "iris.csv"),
        ("SHA-256 of the data", "ab"),
        ("twin model", "wing"),
    ]
    assert facts[4][0] == "octmip"


BAD = """<!doctype html><html><body style="background:#fff;color:#000"><p style="width:3000px">wide</p>
<p style="font-size:8px">small</p><p style="color:#bbb">pale</p><button onclick="console.log('x')"></button>
<div tabindex="0" style="outline:none">unseen</div>
<svg width="100" viewBox="0 0 200 100"><text y="20">drawn</text></svg>
</body></html>"""


def test_the_check_of_pages_finds_each_kind_of_fault(browser, tmp_path: Path):
    path = tmp_path / "bad.html"
    path.write_text(BAD)
    found = " ".join(check_page(path, browser))
    for kind in ("width: 3", "px (small)", "px (drawn)", "(pale)", "axe: button-name", "focus on DIV", "console x"):
        assert kind in found
