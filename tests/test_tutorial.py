"""The tutorial runs from its first line to its last, in an empty environment with the built wheel and one extra."""

import doctest
import json
import re
from pathlib import Path

from tests.installed import Installed

PAGE = Path(__file__).parent.parent / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```(python|text|console)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
RUNNER = """
import contextlib, io, json, shlex, subprocess, sys, warnings
warnings.simplefilter("error")
namespace, said = {}, []
for kind, code in json.load(open("blocks.json")):
    if kind == "python":
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(code, namespace)
        said.append(out.getvalue())
    else:
        done = subprocess.run(shlex.split(code), capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{code} ended with {done.returncode}: {done.stderr}")
        said.append(done.stdout)
json.dump(said, open("said.json", "w"))
"""


def steps_of(text: str) -> list[tuple[str, str, str]]:
    """Return kind, code and shown output of every step of a page."""
    steps: list[tuple[str, str, str]] = []
    for kind, content in BLOCK.findall(text):
        if kind == "text":
            steps[-1] = (*steps[-1][:2], content)
        elif kind == "python":
            steps.append((kind, content, ""))
        else:
            for command in re.split(r"^\$ ", content, flags=re.MULTILINE)[1:]:
                line, _, wanted = command.partition("\n")
                steps.append((kind, line, wanted))
    return steps


def test_the_tutorial_runs_from_installation_to_page(installed_octmip_plot: Installed, tmp_path: Path) -> None:
    steps = steps_of(PAGE.read_text())
    assert [line for kind, line, _ in steps if kind == "console" and not line.startswith("octmip ")] == []
    (tmp_path / "runner.py").write_text(RUNNER)
    (tmp_path / "blocks.json").write_text(json.dumps([step[:2] for step in steps]))
    done = installed_octmip_plot.run("python", "runner.py", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    checker, options = doctest.OutputChecker(), doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    said = json.loads((tmp_path / "said.json").read_text())
    assert len(said) == len(steps) > 10
    for got, (_, code, wanted) in zip(said, steps, strict=True):
        assert checker.check_output(wanted, got, options), f"{code}\nprinted\n{got}\nbut the page says\n{wanted}"
    page = (tmp_path / "tree.html").read_text()
    assert page.lower().startswith("<!doctype html>")
    assert re.search(r"""(src|href)=["']?(https?:)?//""", page) is None
