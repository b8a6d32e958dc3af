"""What a stranger installs: the wheel and every extra, each in an empty environment."""

import re
import shlex
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from octmip.errors import EXTRA_OF
from tests.installed import (
    ROOT,
    Installed,
    stranger,
)

MOST_DOWNLOADED = 90_000_000
"""Bytes that `pip install octmip` may fetch."""
TABLE = "a,b,kind\n0,1,no\n1,0,no\n2,5,yes\n3,4,yes\n4,2,no\n5,3,no\n"
PROGRAM = """
import numpy as np

import octmip

problem = octmip.Problem(np.array([[0.0], [1.0], [2.0]]), np.array([0, 1, 0]), depth=2)
solution = octmip.solve(problem)
octmip.certify(problem, solution)
print(octmip.__file__, solution.objective, solution.gap)
"""
README_DATA = """
import numpy as np
import pandas as pd

features, labels = np.array([[0.0, 1], [1, 0], [2, 5], [3, 4], [4, 2], [5, 3]]), np.array([0, 0, 1, 1, 0, 0])
risk = np.ones(6)
table = pd.DataFrame({"a": [1.0, None, 3.0, 4.0, 5.0, 6.0], "text": ["u", "v", "u", None, "v", "v"]})
"""
TYPED = """
import numpy as np
from octmip import Limits, Problem, certify, solve

problem = Problem(np.array([[0.0], [1.0]]), np.array([0, 1]), depth=1)
gap: float = certify(problem, solve(problem, limits=Limits(seconds=1.0))).objective
"""
MISTYPED = """
from femlib.material import isotropic_plate
from octmip import solve

solve("a table")
isotropic_plate("thick", 0.3, 1.0)
"""


@pytest.mark.long
def test_the_wheel_holds_both_packages_whole_and_no_native_source(installed_octmip: Installed) -> None:
    tracked = subprocess.run(["git", "ls-files", "octmip", "femlib"], capture_output=True, text=True, cwd=ROOT)
    if tracked.returncode or not tracked.stdout:
        pytest.skip("this is no git checkout")
    sources = ("octmip/trees/native/", "octmip/trees/verified/")
    wanted = {name for name in tracked.stdout.split("\n") if name and not name.startswith(sources)}
    with zipfile.ZipFile(installed_octmip.wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert {"octmip/py.typed", "femlib/py.typed"} <= names
    assert names == wanted | {"octmip/trees/_native.abi3.so"}
    assert "-abi3-" in installed_octmip.wheel.name


@pytest.mark.long
def test_an_installation_fetches_little_and_no_package_of_an_extra(installed_octmip: Installed) -> None:
    fetched = {file.name: file.stat().st_size for file in installed_octmip.downloads.iterdir()}
    assert sum(fetched.values()) <= MOST_DOWNLOADED, fetched
    extras = {*EXTRA_OF, "pyfe3d"}
    assert not extras & {name.partition("-")[0].lower() for name in fetched}


@pytest.mark.long
def test_the_installed_wheel_solves_and_certifies(installed_octmip: Installed, tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    done = installed_octmip.run("python", "-W", "error", "program.py", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    place, objective, gap = done.stdout.split()
    assert Path(place).is_relative_to(installed_octmip.packages)
    assert (float(objective), float(gap)) == (0.0, 0.0)


@pytest.mark.long
def test_the_installed_command_goes_from_a_table_to_predictions(installed_octmip: Installed, tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(TABLE)
    for words in (
        "solve table.csv --label kind --depth 2 --out tree.json",
        "certify tree.json table.csv",
        "predict tree.json table.csv --out predicted.csv",
    ):
        done = installed_octmip.run("octmip", *words.split(), cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    predicted = (tmp_path / "predicted.csv").read_text().split()
    assert [line.split(",")[-1] for line in predicted[1:]] == ["no", "no", "yes", "yes", "no", "no"]


@pytest.mark.long
def test_the_commands_and_programs_of_the_readme_run_in_an_empty_environment(
    installed_octmip: Installed, tmp_path: Path
) -> None:
    text = (ROOT / "README.md").read_text()
    commands = re.findall(r"```sh\n(.*?)```", text, re.DOTALL)[1].splitlines()
    (tmp_path / "DATA.csv").write_text(TABLE.replace("kind", "COLUMN"))
    for line in commands:
        done = installed_octmip.run(*shlex.split(line, comments=True), cwd=tmp_path)
        assert done.returncode == 0, f"{line}: {done.stderr}"
    assert (tmp_path / "TREE.html").read_text().lower().startswith("<!doctype html>")
    programs = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (tmp_path / "program.py").write_text("\n".join([README_DATA, *programs]))
    done = installed_octmip.run("python", "program.py", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "tree.html").exists()


@pytest.mark.long
def test_mypy_sees_the_types_of_the_installed_packages(installed_octmip: Installed, tmp_path: Path) -> None:
    (tmp_path / "typed.py").write_text(TYPED)
    (tmp_path / "mistyped.py").write_text(MISTYPED)
    words = ["--strict", "--cache-dir", ".cache", "--python-executable", str(installed_octmip.python)]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *words, "typed.py", "mistyped.py"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=stranger(),
    )
    faults = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert [fault.partition(" ")[0] for fault in faults] == ["mistyped.py:5:", "mistyped.py:6:"], done.stdout
    assert all("[arg-type]" in fault for fault in faults)


def test_what_builds_the_wheel_is_in_this_environment() -> None:
    rules = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert set(rules["build-system"]["requires"]) <= set(rules["project"]["optional-dependencies"]["test"])
