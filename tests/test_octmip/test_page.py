"""Pages made from templates: whole in themselves, strict about what they are given, safe for any text."""

import datetime
import re
from pathlib import Path

import pytest
from jinja2 import UndefinedError

from octmip.interfaces.report import page
from octmip.interfaces.report.page import page_facts, render
from tests.oracles.page_check import check_page

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
    for kind in ("width: 3", "px (small)", "px (drawn)", "(pale)", "without a name", "focus on DIV", "console x"):
        assert kind in found
