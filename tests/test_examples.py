"""The examples of the documentation run, in the order of each page, and print what the page says they print.

A ```python block runs in the namespace of its page; the ```text block after it is its output. A ```console block runs
commands: lines with `$` are the command, the others its output. `...` stands for what may change (times, versions). Of
a ```text shape block only lines and indents must agree: one of several optimal trees, which may come out another.
"""

import contextlib
import doctest
import io
import re
import shlex
from pathlib import Path

import pytest

from octmip.interfaces.cli import main

DOCS = Path(__file__).parent.parent / "docs"
PAGES = [DOCS / "index.md", *sorted((DOCS / "examples").rglob("*.md")), *sorted((DOCS / "howto").glob("*.md"))]
SHOWN = re.compile(r"!\[[^\]]*\]\((?:\.\./)?pictures/examples/([^)\s]+)\)")
BLOCK = re.compile(r"^```(python|text shape|text|console)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


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
    printed = ""
    for kind, content in BLOCK.findall(text):
        if kind == "python":
            assert printed == "", f"{name} does not show what was printed:\n{printed}"
            printed = run_python(content, namespace)
        elif kind == "text":
            assert_output(printed, content, name)
            printed = ""
        elif kind == "text shape":
            assert indents(printed) == indents(content), f"{name} printed\n{printed}\nbut the page says\n{content}"
            printed = ""
        else:
            for command in re.split(r"^\$ ", content, flags=re.MULTILINE)[1:]:
                line, _, wanted = command.partition("\n")
                assert_output(run_command(shlex.split(line)), wanted, f"{name}: {line}")
    assert printed == "", f"{name} does not show what was printed:\n{printed}"


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
    start = (DOCS / "index.md").read_text()
    blocks = BLOCK.findall((DOCS.parent / "README.md").read_text())
    (first,) = [k for k, (_, content) in enumerate(blocks) if "diagnose(" in content and "import" in content]
    kinds = [kind for kind, _ in blocks[first : first + 2]]
    assert kinds == ["python", "text"]
    assert all(content in start for _, content in blocks[first : first + 2])
