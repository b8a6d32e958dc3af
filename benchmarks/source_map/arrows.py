"""Arrows: which file uses which, read from the sources of Python packages and Rust crates.

A file is named by the dotted path of its module ("octmip.trees.mip.flow", "exact.node.kept" of the crate `exact`). The
file of a package (`__init__.py`) or of a Rust module with children (`node.rs`, `lib.rs`) bears the name of that.
"""

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
PACKAGES = ("octmip", "femlib", "benchmarks")
CORE = ROOT / "octmip/trees/native"
CRATES = {"python": CORE / "src"} | {top.parent.name: top for top in sorted(CORE.glob("*/src"))}
NATIVE = "octmip.trees._native"  # what Python sees of the crate `python`
IMPORTED = "octmip_"  # how the name begins by which one crate uses another
ROOT_FILES = {"lib", "main"}

Arrows = Mapping[str, frozenset[str]]

_USE = re.compile(r"^\s*(?:pub(?:\([a-z ]+\))?\s+)?use\s+([^;]+);", re.MULTILINE)
_PATH = re.compile(r"(?<![\w:])((?:crate|super|self|octmip_\w+)(?:::\w+)+)")
_MODULE = re.compile(r"(?:octmip|femlib|benchmarks)(?:\.\w+){2,}")  # a registry names the modules that it loads late
_TESTS = re.compile(r"^#\[cfg\(test\)\]\s*mod\b", re.MULTILINE)


def python_arrows(packages: tuple[str, ...] = PACKAGES, root: Path = ROOT) -> Arrows:
    """Return what each Python file imports of the packages, or names as a module in a string, wherever in the file."""
    files = {_module(file.relative_to(root)): file for package in packages for file in (root / package).rglob("*.py")}
    files = {name: file for name, file in files.items() if "native.target" not in name}
    known = {*files, NATIVE}
    found = {
        name: frozenset(_known(used, known) for part in _names(file.read_text()) for used in part) - {name, ""}
        for name, file in files.items()
    }
    return {**found, NATIVE: frozenset()}


def rust_arrows(crates: Mapping[str, Path] = CRATES) -> Arrows:
    """Return what each Rust file uses of the crates, by `use` or by a path in its code; unit tests are left out."""
    files = {_rust_module(crate, file.relative_to(top)): file for crate, top in crates.items() for file in _rust(top)}
    return {
        name: frozenset(_known(used, set(files)) for used in _used(name, file.read_text())) - {name, ""}
        for name, file in files.items()
    }


def circle(arrows: Arrows) -> list[str]:
    """Return the files of a circle of arrows, sorted; none where data flows one way."""
    try:
        TopologicalSorter(arrows).prepare()
    except CycleError as error:
        return sorted(set(error.args[1]))
    return []


def _module(file: Path) -> str:
    return ".".join(file.with_suffix("").parts).removesuffix(".__init__")


def imports(code: str) -> tuple[str, ...]:
    """Return the full dotted name of everything that a module imports, wherever in it."""
    return _names(code)[0]


@cache
def _names(code: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return what a module imports, and what it names as a module in a string."""
    imported, named = [], []
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            imported += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            imported += [f"{'.' * node.level}{node.module or ''}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and _MODULE.fullmatch(node.value):
            named.append(node.value)
    return tuple(imported), tuple(named)


def _known(dotted: str, known: set[str]) -> str:
    """Return the file that a dotted name lies in: its longest beginning that is one."""
    parts = dotted.split(".")
    names = (".".join(parts[:n]) for n in range(len(parts), 0, -1))
    return next((name for name in names if name in known), "")


def _rust(top: Path) -> list[Path]:
    return sorted(file for file in top.rglob("*.rs") if "target" not in file.relative_to(top).parts)


def _rust_module(crate: str, file: Path) -> str:
    if file.stem in ROOT_FILES:
        return crate if file.stem == "lib" else f"{crate}.{file.stem}"
    return ".".join((crate, *file.with_suffix("").parts))


def _used(name: str, code: str) -> Iterator[str]:
    code = _TESTS.split(re.sub(r"//.*", "", code))[0]
    paths = [path for statement in _USE.findall(code) for path in _expanded(re.sub(r"\s+", " ", statement))]
    for path in [*paths, *_PATH.findall(_USE.sub("", code))]:
        yield _absolute(name, [step.split(" as ")[0].strip() for step in path.split("::")])


def _expanded(statement: str) -> list[str]:
    """Return the single paths of `a::{b, c::{d, e}}`."""
    if "{" not in statement:
        return [statement.strip()]
    head, inside = statement.split("{", 1)
    inside, depth, parts = inside[: inside.rindex("}")], 0, [""]
    for letter in inside:
        depth += (letter == "{") - (letter == "}")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [head.strip() + path for part in parts if part.strip() for path in _expanded(part)]


def _absolute(name: str, steps: list[str]) -> str:
    crate, *inside = name.split(".")
    if steps[0].startswith(IMPORTED):
        return ".".join((steps[0].removeprefix(IMPORTED), *steps[1:]))
    if steps[0] == "crate":
        return ".".join((crate, *steps[1:]))
    if steps[0] not in {"super", "self"}:
        return ".".join((name, *steps))  # a child of this module, or another crate, which no file is found for
    while steps and steps[0] in {"super", "self"}:
        inside = inside[:-1] if steps[0] == "super" else inside
        steps = steps[1:]
    return ".".join((crate, *inside, *steps))
