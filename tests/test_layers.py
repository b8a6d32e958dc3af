"""The table of levels: a module imports only from lower levels of its own package, and equal levels are strangers.

The picture of the architecture in docs/developing.md and this table are the same table; who moves a module changes
both and says why in the commit.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
LEVELS = {
    "octmip": {
        "errors": 0,
        "_native": 0,
        "formats.cells": 1,
        "formats.checked": 1,
        "formats.files": 1,
        "methods.margin": 1,
        "formats.names": 1,
        "tree": 1,
        "twin": 1,
        "problem_values": 1,
        "problem": 2,
        "solution": 2,
        "run": 3,
        "formats.table": 2,
        "encoding": 3,
        "formats.problem_file": 3,
        "formats.tree_schema": 3,
        "risk": 3,
        "uncertainty": 3,
        "methods.polish": 3,
        "certificate": 3,
        "methods.native_call": 4,
        "methods.merging": 4,
        "methods.checkpoint": 4,
        "methods.ties": 4,
        "formats.tree_file": 4,
        "proof": 4,
        "mip": 5,
        "methods.exact": 5,
        "methods.two_feature": 5,
        "methods.search": 5,
        "methods.cart": 4,
        "solver": 6,
        "tradeoff": 7,
        "estimator": 7,
        "monitor": 7,
        "sensing": 8,
        "gap": 8,
        "plot": 8,
        "report": 9,
        "cli": 10,
    },
    "femlib": {
        "errors": 0,
        "arrays": 0,
        "kept": 0,
        "files": 1,
        "checked": 1,
        "material": 1,
        "geometry": 1,
        "mesh": 2,
        "elements": 3,
        "assembly": 4,
        "components": 5,
        "rom": 6,
        "sensors": 7,
        "dataset": 8,
        "wing": 9,
    },
}
MOST_LINES = 400
EMPTY_NOUNS = {"utils", "util", "helpers", "common", "core", "base", "misc"}


def sources(folder: str) -> list[Path]:
    files = (ROOT / folder).rglob("*.py")
    return sorted(file for file in files if "target" not in file.parts and ".venv" not in file.parts)


def imports(code: str) -> Iterator[str]:
    """Yield the full dotted name of everything that a module imports, wherever in it."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            dots = "." * node.level
            yield from (f"{dots}{node.module or ''}.{alias.name}" for alias in node.names)


def part_of(package: str, rest: str) -> str:
    """Return the line of the table that a dotted name belongs to: its room, or its file in a room of several levels."""
    first, second = (*rest.split("."), "")[:2]
    return f"{first}.{second}" if f"{first}.{second}" in LEVELS.get(package, ()) else first


def complaints(package: str, part: str, code: str) -> list[str]:
    """Return what is wrong with the imports of a module that belongs to `part` of a package."""
    levels, wrong = LEVELS[package], []
    for name in imports(code):
        top, _, rest = name.partition(".")
        other = part_of(top, rest)
        if name.startswith("."):
            wrong.append(f"{package}.{part} imports {name}: imports are absolute")
        elif top in {*LEVELS, "benchmarks", "tests"} - {package}:
            wrong.append(f"{package}.{part} imports {name}: {package} knows nothing of {top}")
        elif top == package and other not in levels:
            wrong.append(f"{package}.{part} imports {name}: {other or 'that'} is not in the table of levels")
        elif top == package and other != part and levels[other] >= levels[part]:
            wrong.append(f"{package}.{part} (level {levels[part]}) imports {name} (level {levels[other]})")
    return wrong


def parts(package: str) -> list[tuple[str, Path]]:
    """Return every module file with the part of the package, a line of the table, that it belongs to."""
    files = [file.relative_to(ROOT / package).with_suffix("") for file in sources(package)]
    dotted = [".".join(file.parts).removesuffix("__init__").rstrip(".") for file in files]
    rooms = {line.partition(".")[0] for line in LEVELS[package]} - set(LEVELS[package])
    found = [(part_of(package, name), file) for name, file in zip(dotted, sources(package), strict=True)]
    return [(part, file) for part, file in found if part and part not in rooms]


@pytest.mark.parametrize("package", LEVELS)
def test_every_module_is_in_the_table_of_levels(package):
    assert {part for part, _ in parts(package)} <= set(LEVELS[package])


@pytest.mark.parametrize("package", LEVELS)
def test_imports_go_only_to_lower_levels(package):
    wrong = [line for part, file in parts(package) for line in complaints(package, part, file.read_text())]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("part", "code"),
    [
        ("tree", "from octmip.problem import Problem"),
        ("certificate", "def f():\n    from octmip.methods.exact import branch_and_bound"),
        ("methods.exact", "from octmip.methods.search import local_search"),
        ("methods.exact", "import octmip.methods.search"),
        ("methods.exact", "from octmip.methods.nothing import anything"),
        ("gap", "import femlib.wing"),
        ("gap", "from benchmarks.uav import study"),
        ("solver", "from octmip import solve"),
        ("solver", "from . import cart"),
        ("solver", "from octmip.helpers import anything"),
    ],
)
def test_a_forbidden_import_is_found(part, code):
    assert complaints("octmip", part, code)


@pytest.mark.parametrize(
    ("part", "code"),
    [
        ("solver", "from octmip.methods.cart import greedy_tree"),
        ("mip", "from octmip.mip.highs.highs import run"),
        ("methods.exact", "from octmip import _native"),
        ("methods.exact", "import numpy"),
    ],
)
def test_an_allowed_import_passes(part, code):
    assert not complaints("octmip", part, code)


def test_the_picture_in_the_documentation_is_this_table():
    picture = (ROOT / "docs" / "developing.md").read_text().split("```")[1]
    for package, text in zip(LEVELS, re.split(r"^\w+$", picture, flags=re.MULTILINE)[1:], strict=True):
        for level, names in re.findall(r"(\d+) {3}(.*?)(?= {3}|$)", text, flags=re.MULTILINE):
            plain = re.sub(r"\(.*?\)|, which.*", "", names).replace("/", "")
            for name in re.split(r"[,;]\s*", plain.strip()):
                assert LEVELS[package].get(name.strip()) == int(level), f"{package}: {level} {name}"


def test_the_top_packages_import_only_themselves():
    for package in LEVELS:
        init = ROOT / package / "__init__.py"
        names = imports(init.read_text()) if init.exists() else ()
        assert all(name.startswith(package + ".") for name in names)


def test_siblings_under_benchmarks_do_not_import_each_other():
    for file in sources("benchmarks"):
        inside = file.relative_to(ROOT / "benchmarks").parts
        for name in imports(file.read_text()):
            package = name.split(".")[1] if name.startswith("benchmarks.") else None
            if len(inside) > 1 and package in {"cases", "uav", "blind"}:
                assert package == inside[0], f"{'/'.join(inside)} imports {name}"
                assert package != "cases", f"a case imports another: {name}"


def test_nothing_imports_the_tests_but_tests():
    for package in ("octmip", "femlib", "benchmarks"):
        for file in sources(package):
            assert not [name for name in imports(file.read_text()) if name.split(".")[0] == "tests"], file


@pytest.mark.parametrize("folder", ["octmip", "femlib", "benchmarks", "tests"])
def test_files_are_short_and_bear_nouns_of_the_field(folder):
    for file in sources(folder):
        assert len(file.read_text().splitlines()) <= MOST_LINES, file
        assert not {file.stem, file.parent.name} & EMPTY_NOUNS, file


@pytest.mark.parametrize("package", LEVELS)
def test_no_module_bears_the_name_of_a_function_it_exports(package):
    for _, file in parts(package):
        defined = {node.name for node in ast.parse(file.read_text()).body if isinstance(node, ast.FunctionDef)}
        assert file.stem not in defined, file
