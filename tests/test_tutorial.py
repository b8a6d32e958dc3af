"""The tutorial runs from its first line to its last, in an empty environment with the built wheel and one extra."""

import doctest
import json
import re
from pathlib import Path

import pytest

from docs._extensions.notebooks import code_of
from tests.installed import Installed

PAGE = Path(__file__).parent.parent / "docs" / "tutorial.md"
RUNNER = """
import contextlib, io, json, shlex, subprocess, sys, warnings
warnings.simplefilter("error")
namespace, said = {}, []
for code in json.load(open("cells.json")):
    if not code.startswith("!"):
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(code, namespace)
        said.append(out.getvalue())
    else:
        done = subprocess.run(shlex.split(code[1:]), capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{code} ended with {done.returncode}: {done.stderr}")
        said.append(done.stdout)
json.dump(said, open("said.json", "w"))
"""


@pytest.mark.long
def test_the_tutorial_runs_from_installation_to_page(installed_octmip_plot: Installed, tmp_path: Path) -> None:
    cells = code_of(PAGE.read_text())
    (tmp_path / "runner.py").write_text(RUNNER)
    (tmp_path / "cells.json").write_text(json.dumps([source for source, _, _ in cells]))
    done = installed_octmip_plot.run("python", "runner.py", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    checker, options = doctest.OutputChecker(), doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    said = json.loads((tmp_path / "said.json").read_text())
    assert len(said) == len(cells) > 10
    for got, (code, wanted, _) in zip(said, cells, strict=True):
        assert checker.check_output(wanted, got, options), f"{code}\nprinted\n{got}\nbut the page says\n{wanted}"
    page = (tmp_path / "tree.html").read_text()
    assert page.lower().startswith("<!doctype html>")
    assert re.search(r"""(src|href)=["']?(https?:)?//""", page) is None
