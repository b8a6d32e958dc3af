"""The table of levels: a file uses only lower levels of its own package, and equal levels are strangers.

The table is `benchmarks/source_map/levels.py`; the map in docs/developing.md is drawn from it and from the imports.
"""

import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from benchmarks.source_map.arrows import CRATES, circle, imports, python_arrows, rust_arrows
from benchmarks.source_map.draw import PICTURE, parts_arrows, svg
from benchmarks.source_map.levels import LEVELS, part_of

ROOT = Path(__file__).parent.parent
PACKAGES = ("octmip", "femlib")
MOST_LINES = 400
ORACLE = "oracle"  # a crate of the tests
EMPTY_NOUNS = {"utils", "util", "helpers", "common", "core", "base", "misc"}


def sources(folder: str) -> list[Path]:
    files = (ROOT / folder).rglob("*.py")
    return sorted(file for file in files if "target" not in file.parts and ".venv" not in file.parts)


def complaints(package: str, part: str, code: str) -> list[str]:
    """Return what is wrong with the imports of a module that belongs to `part` of a package."""
    levels, wrong = LEVELS[package], []
    for name in imports(code):
        top, _, rest = name.partition(".")
        other = part_of(top, rest)
        if name.startswith("."):
            wrong.append(f"{package}.{part} imports {name}: imports are absolute")
        elif top in {*PACKAGES, "benchmarks", "tests"} - {package}:
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
    rooms = {line[:end] for line in LEVELS[package] for end, letter in enumerate(line) if letter == "."}
    rooms -= set(LEVELS[package])
    found = [(part_of(package, name), file) for name, file in zip(dotted, sources(package), strict=True)]
    return [(part, file) for part, file in found if part and part not in rooms]


@pytest.mark.parametrize("package", PACKAGES)
def test_every_module_is_in_the_table_of_levels(package):
    assert {part for part, _ in parts(package)} <= set(LEVELS[package])


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_go_only_to_lower_levels(package):
    wrong = [line for part, file in parts(package) for line in complaints(package, part, file.read_text())]
    assert not wrong, "\n".join(wrong)


def test_folders_of_octmip_stand_on_each_other_without_a_circle():
    used: dict[str, set[str]] = {}
    for file in sources("octmip"):
        folder = file.relative_to(ROOT / "octmip").with_suffix("").parts[0]
        names = {name.split(".")[1] for name in imports(file.read_text()) if name.startswith("octmip.")}
        used.setdefault(folder, set()).update(names - {folder})
    del used["__init__"]
    order = list(TopologicalSorter(used).static_order())  # raises CycleError
    assert order.index("input") < order.index("trees") < order.index("formats") < order.index("interfaces")


def test_no_files_use_each_other_in_a_circle():
    assert circle(python_arrows()) == []
    assert circle(rust_arrows()) == []


def test_a_circle_is_found(tmp_path):
    (tmp_path / "tool").mkdir()
    for name, code in {
        "a": "import tool.b",
        "b": "def f():\n    from tool.c import g",
        "c": "from tool import a",
    }.items():
        (tmp_path / "tool" / f"{name}.py").write_text(code)
    assert circle(python_arrows(("tool",), tmp_path)) == ["tool.a", "tool.b", "tool.c"]
    (tmp_path / "parent.rs").write_text("mod child;\nuse child::g;\npub fn f() {}\n")
    (tmp_path / "parent").mkdir()
    (tmp_path / "parent" / "child.rs").write_text("use super::f;\npub fn g() {}\n")
    assert circle(rust_arrows({"native": tmp_path})) == ["native.parent", "native.parent.child"]


@pytest.mark.parametrize(
    ("part", "code", "is_allowed"),
    [
        ("trees.nodes.tree", "from octmip.trees.question.problem import Problem", False),
        ("trees.answer.certificate", "def f():\n    from octmip.trees.methods.exact import branch_and_bound", False),
        ("trees.methods.exact", "from octmip.trees.methods.search import local_search", False),
        ("trees.methods.exact", "import octmip.trees.methods.search", False),
        ("trees.methods.exact", "from octmip.trees.methods.nothing import anything", False),
        ("gap", "import femlib.wing", False),
        ("gap", "from benchmarks.uav import study", False),
        ("trees.solver", "from octmip import solve", False),
        ("trees.solver", "from . import cart", False),
        ("trees.solver", "from octmip.helpers import anything", False),
        ("trees.solver", "from octmip.trees.methods.cart import greedy_tree", True),
        ("trees.mip", "from octmip.trees.mip.highs.highs import run", True),
        ("trees.methods.exact", "from octmip.trees import _native", True),
        ("trees.methods.exact", "import numpy", True),
    ],
)
def test_a_forbidden_import_is_found_and_an_allowed_one_passes(part, code, is_allowed):
    assert (complaints("octmip", part, code) == []) == is_allowed


def test_the_crates_of_the_native_core_stand_on_lower_ones():
    levels = LEVELS["native"]
    assert set(CRATES) == {*levels, ORACLE}
    arrows = parts_arrows("native", rust_arrows())
    assert all(arrows[crate] for crate in levels if crate != "check")
    assert not [(crate, used) for crate in levels for used in arrows[crate] if levels[used] >= levels[crate]]


def test_what_only_unit_tests_and_comments_use_is_no_arrow(tmp_path):
    (tmp_path / "search.rs").write_text("")
    (tmp_path / "exact.rs").write_text(
        "// use crate::search::a;\n#[cfg(test)]\nmod tests {\n use crate::search::b;\n}\n"
    )
    assert rust_arrows({"core": tmp_path}) == {"core.search": frozenset(), "core.exact": frozenset()}


def test_every_file_of_the_crates_is_read():
    n_files = sum(
        len([f for f in top.rglob("*.rs") if "target" not in f.relative_to(top).parts]) for top in CRATES.values()
    )
    assert len(rust_arrows()) == n_files


def test_the_map_in_the_documentation_is_drawn_from_the_sources():
    assert PICTURE.read_text(encoding="utf-8") == svg(), "draw it again: python -m benchmarks.source_map.draw"
    assert "(pictures/map.svg)" in (ROOT / "docs" / "developing.md").read_text()


def test_the_top_packages_import_only_themselves():
    for package in PACKAGES:
        init = ROOT / package / "__init__.py"
        names = imports(init.read_text()) if init.exists() else ()
        assert all(name.startswith((package + ".", "typing.", "importlib")) for name in names)


def test_siblings_under_benchmarks_do_not_import_each_other():
    for file in sources("benchmarks"):
        inside = file.relative_to(ROOT / "benchmarks").parts
        for name in imports(file.read_text()):
            package = name.split(".")[1] if name.startswith("benchmarks.") else None
            if len(inside) > 1 and package in {"cases", "uav", "blind"}:
                assert package == inside[0], f"{'/'.join(inside)} imports {name}"
                assert package != "cases", f"a case imports another: {name}"


def test_of_the_tests_only_oracles_are_used_and_only_by_benchmarks():
    for package in ("octmip", "femlib", "benchmarks"):
        for file in sources(package):
            used = [name for name in imports(file.read_text()) if name.split(".")[0] == "tests"]
            assert all(package == "benchmarks" and name.startswith("tests.oracles.") for name in used), file
    for file in sources("tests/oracles"):
        used = {name.split(".")[0] for name in imports(file.read_text())}
        assert "benchmarks" not in used, file


@pytest.mark.parametrize("folder", ["octmip", "femlib", "benchmarks", "tests"])
def test_files_are_short_and_bear_nouns_of_the_field(folder):
    for file in sources(folder):
        assert len(file.read_text().splitlines()) <= MOST_LINES, file
        assert not {file.stem, file.parent.name} & EMPTY_NOUNS, file


@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_bears_the_name_of_a_function_it_exports(package):
    for _, file in parts(package):
        assert not re.search(rf"^def {file.stem}\b", file.read_text(), re.MULTILINE), file
