"""The mutation run: mutants are drawn by tools, tried in a copy by the nearest tests, and told from the sound tree."""

import os
import shutil

import numpy as np
import pytest

from benchmarks.mutants import pytest_runs, study
from benchmarks.mutants.draws import Mutant, python_mutant
from benchmarks.mutants.nearest import NearestTests
from benchmarks.mutants.pytest_runs import PytestRuns

SUMS = "BIG = 1e99\n\n\ndef double(x: int | None) -> int:\n    return min(x + x, 100)\n"
LOOPS = "def down(x):\n    while x > 0:\n        x -= 1\n    return x\n"
FILES = {
    "octmip/__init__.py": "from octmip.sums import double\n",
    "octmip/sums.py": SUMS,
    "octmip/loops.py": LOOPS,
    "tests/octmip/test_all.py": "from octmip import double\n\n\ndef test_double():\n    assert double(2) == 4\n",
    "tests/octmip/test_down.py": "from octmip.loops import down\n\n\ndef test_down():\n    assert down(9) == 0\n",
}


@pytest.fixture
def tree(tmp_path, monkeypatch):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / name).write_text(text)
        os.utime(tmp_path / name, (0, 0))  # older than any mutant of it
    monkeypatch.setattr(study, "ROOT", tmp_path)
    monkeypatch.setattr(pytest_runs, "IMPORTED", ())
    return tmp_path


def test_lines_are_drawn_alike_and_what_is_no_behaviour_stays(tree):
    rng = np.random.default_rng(0)
    lines = [python_mutant(rng, tree, ["octmip/loops.py"]).line for _ in range(60)]
    assert np.bincount(lines)[2:4].min() > 15
    changes = {str(python_mutant(rng, tree, ["octmip/sums.py"])).partition(" ")[2] for _ in range(90)}
    assert {
        "return min(x + x, 100) -> return max(x + x, 100)",
        "return min(x + x, 100) -> return min(x + x, 101)",
    } < changes
    assert not [change for change in changes if not change.startswith(("return", "BIG = 1e99 -> BIG = None"))]


@pytest.mark.parametrize(
    ("before", "after", "types", "outcome", "by"),
    [
        ("x + x", "x - x", "true", "killed", "test_double"),
        ("100", "101", "true", "survived", ""),
        ("100", "101", "false", "killed", "mypy"),
    ],
)
def test_a_mutant_is_killed_or_lives(before, after, types, outcome, by, tree, monkeypatch):
    file = "octmip/sums.py"
    monkeypatch.setattr(study, "TYPES", (types,))
    mutants = (python_mutant(np.random.default_rng(seed), tree, [file]) for seed in range(200))
    mutant = next(one for one in mutants if one.after == FILES[file].replace(before, after))
    shutil.copytree(tree, tree / "copy")
    with PytestRuns(tree / "copy") as asked:
        found = study._Runs(tree / "copy", 4.0, asked).line(mutant)
    assert (found["outcome"], found["by"].rpartition(":")[2]) == (outcome, by)
    assert (tree / "copy" / file).read_text() == FILES[file]


CARGO = """#!/bin/sh
mkdir -p target/checks
if [ $1 = build ]; then cp src/lib.rs target/checks/lib_native.so && ! grep unviable src/lib.rs
else ! sed -n "s/killed/test own ... FAILED/p" src/lib.rs | grep FAILED; fi
"""  # what it builds of a source is that source
CORE = """from pathlib import Path
def test_core():
    core = next(Path("octmip/trees").glob("*.so")).read_text()
    assert "wrong" not in core
    while "slow" in core: pass
"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("after", "outcome", "by"),
    [
        ("unviable", "unviable", ""),
        ("killed", "killed", "own"),
        ("wrong", "killed", "test_core"),
        ("slow", "time", "test_core"),
        ("other", "survived", ""),
    ],
)
def test_a_mutant_of_the_core_is_compiled_and_asked_by_both_kinds_of_tests(after, outcome, by, tree, monkeypatch):
    place = tree / "octmip/trees/native"
    for file, text in {
        place / "src/lib.rs": "sound",
        tree / "octmip/trees/_native.so": "old",
        tree / "tests/octmip/test_core.py": CORE,
        tree / "bin/cargo": CARGO,
    }.items():
        file.parent.mkdir(exist_ok=True, parents=True)
        file.write_text(text)
    (tree / "bin/cargo").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tree / 'bin'}:{os.environ['PATH']}")
    monkeypatch.delenv("CARGO_TARGET_DIR", raising=False)
    with PytestRuns(tree) as asked:
        runs = study._Runs(tree, 3.0, asked)
        runs.build()
        found = runs.line(Mutant("octmip/trees/native/src/lib.rs", 1, "FnValue", "sound", after))
    assert (found["outcome"], found["by"].rpartition(":")[2]) == (outcome, by)
    assert runs.core.read_text() == "sound"


@pytest.mark.long
def test_a_run_draws_by_its_seed_and_its_summary_names_who_lives(tree):
    lines = [next(study.results(9.0, [1], only="octmip/sums.py", seed=5, draws=1)) for _ in range(2)]
    assert lines[0]["size"] == lines[1]["size"]
    lines = [line | {"outcome": outcome} for line, outcome in zip(lines, ("survived", "unviable"), strict=True)]
    said = study.summary(lines)
    assert "0 of 1 mutants killed." in said
    assert "| octmip/sums.py | 0 | 0 | 1 | 1 |" in said
    assert f"survived: {lines[0]['size']}" in said


def test_the_nearest_tests_are_those_of_the_name_then_of_the_imports(tree):
    assert NearestTests(tree).of("octmip/loops.py", 3) == ["tests/octmip/test_down.py"]
    assert NearestTests(tree).of("octmip/sums.py", 2) == ["tests/octmip/test_all.py"]
