"""Every data file beside a page is named by a page, in a section that says its command, or the commit that made it."""

import importlib.util
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from benchmarks.registry import FAMILIES

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
FILES = sorted(str(file.relative_to(DOCS)) for file in DOCS.rglob("data/**/*.csv"))
MODULE = re.compile(r"python -m (benchmarks[.\w]*)")
LINK = re.compile(r"\]\(([^)\s]+\.csv)\)")


def sections(text: str) -> Iterator[str]:
    """Yield each section of a page after the texts of those around it: the page's first, then by level."""
    around: dict[int, str] = {}
    for part in re.split(r"^(?=#+ )", text, flags=re.MULTILINE):
        level = len(part) - len(part.lstrip("#"))
        around = {above: kept for above, kept in around.items() if above < level} | {level: part}
        yield "\n".join(around.values())


def commands(text: str) -> list[str]:
    """Return the commands in a text: modules of benchmarks, families of `benchmarks.run`, targets of make, commits.

    A finished study is gone from the sources; the commit that its section names still has it.
    """
    code = re.findall(r"`([^`]+)`", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    named = [words.split()[0] for words in code if words.strip() and words.split()[0] in FAMILIES]
    return [*MODULE.findall(text), *named, *re.findall(r"(?<=`)make \w+|commit `[0-9a-f]{8}", text)]


@cache
def places() -> dict[str, list[str]]:
    """Return, for each data file, the sections that link to it."""
    found: dict[str, list[str]] = {file: [] for file in FILES}
    for page in DOCS.rglob("*.md"):
        for section in sections(page.read_text()):
            own = section.rpartition("\n#")[2]
            for link in LINK.findall(own):
                there = str((page.parent / link).resolve().relative_to(DOCS))
                found.setdefault(there, []).append(section)
    return found


@pytest.mark.parametrize("file", FILES)
def test_a_page_links_to_a_data_file_and_says_its_command(file):
    sections_of_file = places()[file]
    assert sections_of_file, f"no page links to {file}; link to it, or delete it"
    assert any(commands(text) for text in sections_of_file), f"no section that links to {file} names its command"


def test_every_link_to_a_data_file_leads_to_one():
    assert set(places()) == set(FILES)


def test_every_module_that_a_page_calls_is_there():
    for page in DOCS.rglob("*.md"):
        for module in MODULE.findall(page.read_text()):
            assert importlib.util.find_spec(module.rstrip(".")), f"{page.name}: {module}"


def test_a_section_has_the_commands_of_those_around_it_and_not_of_its_neighbours():
    page = "# A\n`make uav`\n## B\n`exact_uci --limit 3`\n### C\n[rows](c.csv)\n## D\n`no_such`\n"
    *_, inner, last = [commands(section) for section in sections(page)]
    assert inner == ["exact_uci", "make uav"]
    assert last == ["make uav"]
