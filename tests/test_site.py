"""The documentation builds into a site without a warning; links lead somewhere; nothing is asked of the network."""

import importlib.util
import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest

from tests.oracles.page_check import violations
from tests.test_docs_search import SEARCHES

ROOT = Path(__file__).parent.parent
NEEDED = ("sphinx", "furo", "myst_parser", "sphinx_copybutton", "sphinx_design", "sphinxcontrib.bibtex")
LOADED = {"img": "src", "script": "src", "link": "href", "iframe": "src", "source": "src"}


class Page(HTMLParser):
    """What a page links to, what it loads, and the places in it that a link may name."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.places: set[str] = set()
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take one element."""
        values = dict(attrs)
        self.places |= {values["id"] or ""} if "id" in values else set()
        if tag == "a" and values.get("href"):
            self.links.append(values["href"] or "")
        if (tag in LOADED and values.get(LOADED[tag])) and values.get("rel") not in ("next", "prev", "canonical"):
            self.loaded.append(values[LOADED[tag]] or "")


def built(out: Path, *settings: str) -> Path:
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"the site is built with the extra docs; {', '.join(missing)} is not installed")
    # The theme of the site takes as long again to write its menus into every page.
    words = ["-W", "--keep-going", "-q", "-b", "html", "-d", f"{out}/read"]
    for setting in ("html_theme=basic", *settings):
        words += ["-D", setting]
    command = [sys.executable, "-m", "sphinx", *words, "docs", f"{out}/html"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out / "html"


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    return built(tmp_path_factory.mktemp("site"))


@pytest.fixture(scope="module")
def pages(site) -> dict[Path, Page]:
    return {path.resolve(): Page(path) for path in site.rglob("*.html")}


@pytest.mark.long
def test_every_page_of_the_documentation_is_on_the_site(site):
    wanted = {page.relative_to(ROOT / "docs").with_suffix(".html") for page in (ROOT / "docs").rglob("*.md")}
    assert len(wanted) > 50
    assert {name for name in wanted if not (site / name).exists()} == set()
    notebook = json.loads((site / "tutorial.ipynb").read_text())
    assert [cell["cell_type"] for cell in notebook["cells"]].count("code") > 10
    assert '<a href="tutorial.ipynb"' in (site / "tutorial.html").read_text()


@pytest.mark.long
def test_links_lead_to_pages_and_places(pages):
    broken = []
    for path, page in pages.items():
        for link in page.links:
            target, place = urldefrag(link)
            if re.match(r"[a-z]+:", target):
                continue
            there = (path.parent / unquote(target)).resolve() if target else path
            if not there.exists() or (place and there in pages and unquote(place) not in pages[there].places):
                broken.append(f"{path.name}: {link}")
    assert broken == []


@pytest.mark.long
def test_a_reader_by_keyboard_and_ear_gets_levels_names_and_focus(site):
    found = {path: path.read_text() for path in site.rglob("*.html")}
    wrong = ("<pre>", 'role="heading">', "doc-biblioentry", '<th class="head"></th>', "(</span><dl>", "<p></p></th>")
    assert not [(path.name, sign) for path, text in found.items() for sign in wrong if sign in text]
    assert '<span class="sig-line">' in found[site / "api" / "solve.html"]


@pytest.mark.long
def test_the_site_loads_nothing_from_elsewhere(pages):
    for path, page in pages.items():
        assert [name for name in page.loaded if re.match(r"(https?:)?//", name)] == [], path
        assert [name for name in page.loaded if not (path.parent / urldefrag(name)[0].split("?")[0]).exists()] == [], (
            path
        )


@pytest.mark.long
def test_every_example_and_result_page_shows_a_picture(pages, site):
    for name in ("index", "examples/command", "examples/risk", "uav", "mission", "sensing", "wing", "how-long"):
        page = pages[(site / f"{name}.html").resolve()]
        assert any("_images/" in picture for picture in page.loaded), name


@pytest.mark.long
def test_the_search_of_the_site_lists_the_page_that_answers(site):
    """The search of Sphinx asks for every word, by its stem, in the text or the title of a page."""
    from sphinx.search.en import SearchEnglish

    text = (site / "searchindex.js").read_text()
    index, language = json.loads(text[text.index("(") + 1 : text.rindex(")")]), SearchEnglish({})
    without = []
    assert len(SEARCHES) > 80
    for search, page in SEARCHES.items():
        place = index["docnames"].index(page)
        stems = [language.stem(word) for word in language.split(search.lower()) if language.word_filter(word)]
        lists = [[index[kind].get(stem, []) for kind in ("terms", "titleterms")] for stem in stems]
        without += [
            search for pair in lists if not any(place in (one if isinstance(one, list) else [one]) for one in pair)
        ]
    assert without == []


def test_a_page_of_each_kind_is_built_without_a_warning(tmp_path):
    kinds = ("tutorial", "api/certificate", "howto/monotone", "examples/risk")
    absent = "ref.python,myst.xref_missing,toc.not_included"  # the other pages
    some = "include_patterns=" + ",".join(f"{page}.md" for page in kinds)
    small = built(tmp_path, "master_doc=tutorial", some, f"suppress_warnings={absent}")
    found = {page: Page(small / f"{page}.html") for page in kinds}
    assert "octmip.trees.answer.certificate.Certificate.errors" in found["api/certificate"].places
    assert any("_images/" in picture for picture in found["examples/risk"].loaded)
    assert (small / "tutorial.ipynb").exists()
    for page in found.values():
        assert [name for name in page.loaded if re.match(r"(https?:)?//", name)] == []


def test_a_card_of_the_gallery_has_one_picture_of_its_own():
    text = (ROOT / "docs" / "examples" / "gallery.md").read_text()
    cards = re.findall(r"^:::\{grid-item-card\}.*?^:::$", text, re.MULTILINE | re.DOTALL)
    pictures = [re.findall(r"^:img-top: (\S+)$", card, re.MULTILINE) for card in cards]
    assert [len(found) for found in pictures] == [1] * len(cards)
    assert len({one for (one,) in pictures}) == len(cards) > 10
    assert all((ROOT / "docs" / "examples" / one).is_file() for (one,) in pictures)
    assert all(re.search(r"^:img-alt: \S", card, re.MULTILINE) for card in cards)
    linked = {*re.findall(r"^:link: (\S+)$", text, re.MULTILINE), *re.findall(r"\]\((\S+)\.md\)", text)}
    toctree = text.partition("```{toctree}")[2].split()[1:-1]
    assert linked == set(toctree)


@pytest.mark.parametrize("theme", ['body[data-theme="dark"]', 'body:not([data-theme="light"])'])
def test_a_picture_keeps_paper_of_its_own_on_a_dark_page(theme):
    style = (ROOT / "docs" / "_static" / "site.css").read_text()
    rule = style.partition(f"{theme} article img {{")[2].partition("}")[0]
    assert "background: #ffffff" in rule


@pytest.mark.long
@pytest.mark.parametrize("name", ["index", "examples/command", "theory/two-feature", "api/monitor"])
def test_axe_core_finds_no_violation_in_the_text_of_a_page(browser, site, name):
    page = browser.new_page()
    page.goto((site / f"{name}.html").as_uri())
    assert violations(page, "[role=main]") == []  # what is around it is the theme's
    page.close()
