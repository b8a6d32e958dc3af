"""Without any extra: the core solves, certifies and predicts, and what needs an extra names it in one sentence."""

import json
import os
import re
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path

import pytest

from femlib import errors as femlib_errors
from octmip import errors as octmip_errors
from octmip.interfaces.cli import doctor

ROOT = Path(__file__).parent.parent
BOTH = (octmip_errors.EXTRA_OF, femlib_errors.EXTRA_OF)
OPTIONAL = ("pyfe3d", "matplotlib", "pyarrow", "onnx", "meshio")

REFUSE = f"""
import sys

class Refused:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {OPTIONAL}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Refused())
"""
"""The import system of an environment without the extras."""

CORE = """
import contextlib, io, json
import numpy as np
from femlib.elements import tria3
from octmip import Problem, certify, predict, solve
from octmip.interfaces.cli import main

features, labels = np.array([[0.0, 1], [1, 0], [2, 5], [3, 4], [4, 2], [5, 3]]), [0, 0, 1, 1, 0, 0]
said = {"gap": {}}
for method in ("cart", "search", "exact", "oct", "oct_h", "flow"):
    problem = Problem(features, labels, depth=2, split="hyperplane" if method == "oct_h" else "axis")
    solution = solve(problem, method)
    certify(problem, solution)
    said["gap"][method] = solution.gap
said["predicted"] = predict(solution.tree, features).tolist()
said["shell"] = tria3.strain_operators(np.eye(3)[None], tria3.MIDDLE).membrane.shape

with open("t.csv", "w") as file:
    file.write("a,b,kind\\n" + "".join(f"{a},{b},{k}\\n" for (a, b), k in zip(features, labels)))
open("t.parquet", "wb").write(b"PAR1PAR1")
ASK = "--label kind --depth 2"
for words in (
    f"solve t.csv {ASK} --out tree.json",
    "certify tree.json t.csv",
    "predict tree.json t.csv",
    f"compare t.csv {ASK}",
    f"frontier t.csv {ASK} --over depth",
    "report tree.json",
    "report tree.json --out tree.md",
    f"frontier t.csv {ASK} --over depth --out f.svg",
    "report tree.json --out tree.svg",
    "report tree.json --out tree.html",
    f"solve t.parquet {ASK}",
):
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        code = main(words.split())
    said[words] = [code, err.getvalue()]


USES = {
    "beam": "from femlib.elements.beam2 import element_library; element_library()",
    "meshes": "import femlib; femlib.read('x.msh')",
    "stored": "from femlib.dataset.parquet import pyarrow_modules; pyarrow_modules()",
    "pictures": "import femlib.wing.export.pictures",
    "plot": "import octmip.interfaces.plot",
    "onnx": "from octmip.monitor.export import onnx_model; onnx_model(solution.tree, ['a', 'b'], [0, 1])",
}
for name, use in USES.items():
    said[name] = ["", "no error"]
    try:
        exec(use)
    except ImportError as error:
        said[name] = [type(error).__module__, str(error)]
print(json.dumps(said))
"""


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """Return what a program says that runs without the extras."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", REFUSE + textwrap.dedent(CORE)],
        capture_output=True,
        text=True,
        cwd=tmp_path_factory.mktemp("core"),
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_every_method_of_the_core_solves_and_predicts_without_an_extra(said):
    proving = {method: gap for method, gap in said["gap"].items() if method not in ("cart", "search")}
    assert set(proving) == {"exact", "oct", "oct_h", "flow"}
    assert all(gap == 0.0 for gap in proving.values()), proving
    assert said["predicted"] == [0, 0, 1, 1, 0, 0]
    assert said["shell"] == [1, 1, 3, 18]


def test_the_command_needs_no_extra_for_what_is_no_picture(said):
    done = {words: told for words, told in said.items() if " " in words and told[0] == 0}
    assert {words.split()[0] for words in done} == {"solve", "certify", "predict", "compare", "frontier", "report"}
    assert len(done) == 8
    assert not any("install octmip[" in err for _, err in done.values())


USES = {
    "beam": "pyfe3d",
    "meshes": "meshio",
    "stored": "pyarrow",
    "pictures": "matplotlib",
    "plot": "matplotlib",
    "onnx": "onnx",
    "frontier t.csv --label kind --depth 2 --over depth --out f.svg": "matplotlib",
    "report tree.json --out tree.svg": "matplotlib",
    "solve t.parquet --label kind --depth 2": "pyarrow",
}
"""Features and commands, and the package that each needs."""


@pytest.mark.parametrize("use", USES)
def test_what_a_package_is_missing_for_names_the_extra_in_one_sentence(said, use):
    source, sentence = said[use]
    assert source == 2 if " " in use else source in ("octmip.errors", "femlib.errors")
    assert sentence.count("\n") == (" " in use)  # a command ends its line
    extra = (octmip_errors.EXTRA_OF | femlib_errors.EXTRA_OF)[USES[use]]
    assert sentence.endswith(
        f"needs the package {USES[use]}, which is not installed; install octmip[{extra}]" + "\n" * (" " in use)
    )


@pytest.mark.parametrize("errors", [octmip_errors, femlib_errors])
def test_the_packages_named_in_errors_are_those_of_the_extras(errors):
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    for package, extra in errors.EXTRA_OF.items():
        assert {"sksparse": "scikit-sparse", "pyoma2": "pyOMA_2"}.get(package, package) in {
            re.split(r"[<>=!\[]", line)[0] for line in extras[extra]
        }


def test_every_extra_of_a_user_stands_in_doctor_and_on_the_page_of_installation():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"].keys()
    modules = {name: {module for errors in BOTH for module in errors if errors[module] == name} for name in extras}
    examined = {name: set(extra.modules) for name, extra in doctor.EXTRAS.items()}
    of_users = {name: found for name, found in modules.items() if found}
    assert examined == of_users | {"meshes": {"meshio", "pyfe3d"}}
    page = (ROOT / "docs" / "install.md").read_text()
    assert not [name for name in extras if f"`{name}`" not in page]


def test_the_first_commands_of_the_readme_are_targets_and_those_of_the_check():
    first = re.findall(r"```sh\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)[0]
    job, tests, package = (line.partition("#")[0].strip() for line in first.splitlines())
    assert (job, package) == ("make uav", "pip install .")
    assert tests in (ROOT / ".ci" / "run").read_text().splitlines()
    makefile = (ROOT / "Makefile").read_text()
    assert all(f"\n{line.split()[1]}:" in makefile for line in (job, tests))


@pytest.mark.parametrize("errors", [octmip_errors, femlib_errors])
def test_a_missing_module_of_nobody_stays_what_it_is(errors):
    with pytest.raises(ModuleNotFoundError, match="no_such_module"), errors.needed_by("this"):
        import no_such_module  # noqa: F401
