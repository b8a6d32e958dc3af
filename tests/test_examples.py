"""The examples of the documentation run as the notebooks of their pages, and print what the pages say they print.

`...` stands for what may change (times, versions). Of a ```text shape block only lines and indents must agree: one of
several optimal trees, which may come out another.
"""

import contextlib
import doctest
import io
import re
import shlex
from pathlib import Path

import pytest

from docs._extensions.notebooks import code_of
from octmip.interfaces.cli import main

DOCS = Path(__file__).parent.parent / "docs"
PAGES = [
    DOCS / "index.md",
    DOCS / "tutorial.md",
    *sorted((DOCS / "examples").rglob("*.md")),
    *sorted((DOCS / "howto").glob("*.md")),
]
SHOWN = re.compile(r"!\[[^\]]*\]\((?:\.\./)?pictures/examples/([^)\s]+)\)")


def assert_output(got: str, wanted: str, place: str) -> None:
    checker = doctest.OutputChecker()
    options = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    assert checker.check_output(wanted, got, options), f"{place} printed\n{got}\nbut the page says\n{wanted}"


def indents(text: str) -> list[int]:
    return [len(line) - len(line.lstrip()) for line in text.splitlines()]


def run_python(code: str, namespace: dict[str, object]) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(code, namespace)
    return out.getvalue()


def run_command(words: list[str]) -> str:
    assert words[0] == "octmip"
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(out):
        main(words[1:])
    return out.getvalue()


def run_page(text: str, name: str) -> None:
    namespace: dict[str, object] = {}
    for source, wanted, is_shape in code_of(text):
        is_command = source.startswith("!")
        printed = run_command(shlex.split(source[1:])) if is_command else run_python(source, namespace)
        if is_shape:
            assert indents(printed) == indents(wanted), f"{name} printed\n{printed}\nbut the page says\n{wanted}"
        else:
            assert_output(printed, wanted, f"{name}: {source}" if is_command else name)


@pytest.mark.long(
    "structures/panel",
    "structures/tower",
    "examples/placement",
    "examples/budget",
    "howto/parts",
    "docs/tutorial",
    "examples/command",
    "examples/choosing",
    "howto/near-optimal",
    "examples/wing-dataset",
    "examples/scikit-learn",
)
@pytest.mark.parametrize("page", PAGES, ids=lambda page: f"{page.parent.name}/{page.stem}")
def test_every_example_prints_what_its_page_says(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = page.read_text()
    run_page(text, page.name)
    if page.stem != "gallery":  # it shows what the others draw
        assert [name for name in SHOWN.findall(text) if not (tmp_path / name).exists()] == []


@pytest.mark.parametrize(
    "text",
    [
        "```python\nprint(1)\n```\n```text\n2\n```\n",
        "```python\nprint(1)\n```\n",
        "```console\n$ octmip --version\nsomething else\n```\n",
    ],
)
def test_a_page_that_says_something_else_fails(text):
    with pytest.raises(AssertionError):
        run_page(text, "page")


def test_the_readme_shows_a_diagnosis_and_its_output_as_the_start_page_runs_them():
    start = code_of((DOCS / "index.md").read_text())
    (shown,) = [one for one in code_of((DOCS.parent / "README.md").read_text()) if "diagnose(" in one[0]]
    assert shown[1]
    assert shown in start
