"""Mutants drawn at random: each line of the sources that a tool can change is as likely as any other.

Python is changed by the operators of mutmut and by `confused_name`, Rust by those of cargo-mutants. Texts stay as they
are: a message has no definition but itself. Annotations and decorators are no behaviour.
"""

import json
import subprocess
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import libcst as cst
import numpy as np
from libcst.metadata import MetadataWrapper, PositionProvider
from mutmut.mutation.mutators import mutation_operators, operator_string

PYTHON = ("octmip/trees", "octmip/gap", "octmip/formats", "femlib/strength.py", "femlib/rom")
NATIVE = "octmip/trees/native"
CONFUSED = {"min": "max", "any": "all", "floor": "ceil", "argmin": "argmax"}
CONFUSED |= {other: name for name, other in CONFUSED.items()} | dict.fromkeys(("mean", "median", "sum"), "max")
CONFUSED |= {"abs": "float", "sorted": "list"}
"""Functions of arrays and numbers that take the same arguments."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """One wrong change: the file from the tree's root, the line, the operator, and the file's whole new text."""

    file: str
    line: int
    operator: str
    text: str

    @property
    def is_rust(self) -> bool:
        """Whether the native core has to be built for it."""
        return self.file.endswith(".rs")

    def difference(self, root: Path) -> str:
        """Return the first changed line as it was and as it is."""
        texts = (root / self.file).read_text(encoding="utf-8"), self.text
        pairs = zip(*([*text.splitlines(), ""] for text in texts), strict=False)
        before, after = next((a, b) for a, b in pairs if a != b)
        return f"{before.strip()} -> {after.strip()}"


def drawn(rng: np.random.Generator, root: Path, parts: Sequence[str]) -> Iterator[Mutant]:
    """Yield mutants without end; `parts` are folders and files of Python, or the native core alone."""
    is_rust = tuple(parts) == (NATIVE,)
    files = [file for part in parts for file in sorted((root / part).rglob("*.py")) or [root / part]]
    sizes = np.array([file.read_bytes().count(b"\n") for file in files])
    while True:
        found = _of_rust(root) if is_rust else _of_python(files[rng.choice(len(files), p=sizes / sizes.sum())], root)
        if found:
            of_line = found[sorted(found)[rng.integers(len(found))]]
            yield of_line[rng.integers(len(of_line))].made(root)


@dataclass(frozen=True, slots=True)
class _Change:
    """A possible mutant, whose text is made when it is drawn."""

    file: str
    line: int
    operator: str
    make: Any

    def made(self, root: Path) -> Mutant:
        return Mutant(self.file, self.line, self.operator, self.make((root / self.file).read_text(encoding="utf-8")))


def confused_name(call: cst.Call) -> Iterable[cst.Call]:
    """Yield the call of another function that takes the same arguments."""
    name = call.func.attr if isinstance(call.func, cst.Attribute) else call.func
    if isinstance(name, cst.Name) and name.value in CONFUSED:
        yield call.with_deep_changes(name, value=CONFUSED[name.value])


OPERATORS = [*(pair for pair in mutation_operators if pair[1] is not operator_string), (cst.Call, confused_name)]


class _Visitor(cst.CSTVisitor):
    METADATA_DEPENDENCIES = (PositionProvider,)

    def __init__(self) -> None:
        self.found: list[tuple[int, str, cst.CSTNode, Any]] = []

    def on_visit(self, node: cst.CSTNode) -> bool:
        if isinstance(node, (cst.Annotation, cst.Decorator, cst.ImportFrom, cst.Import)):
            return False
        for kind, operator in OPERATORS:
            for other in operator(node) if isinstance(node, kind) else ():
                line = self.get_metadata(PositionProvider, node).start.line
                self.found.append((line, operator.__name__.removeprefix("operator_"), node, other))
        return True


@cache
def _of_python(file: Path, root: Path) -> dict[int, list[_Change]]:
    """Return the mutants of a file by line."""
    visitor = _Visitor()
    module = MetadataWrapper(cst.parse_module(file.read_text(encoding="utf-8"))).visit(visitor)
    changes = defaultdict(list)
    for line, operator, node, other in visitor.found:

        def make(_: str, node: cst.CSTNode = node, other: cst.CSTNode = other) -> str:
            return str(cst.ensure_type(module.deep_replace(node, other), cst.Module).code)

        changes[line].append(_Change(str(file.relative_to(root)), line, operator, make))
    return changes


@cache
def _of_rust(root: Path) -> dict[tuple[str, int], list[_Change]]:
    """Return the mutants of the native core by file and line."""
    command = ["cargo", "mutants", "--list", "--json", "--workspace"]
    listed = subprocess.run(command, cwd=root / NATIVE, capture_output=True, text=True, check=True).stdout
    changes = defaultdict(list)
    for one in json.loads(listed):

        def make(text: str, one: dict[str, Any] = one) -> str:
            lines = text.splitlines(keepends=True)
            start, end = (
                sum(map(len, lines[: place["line"] - 1])) + place["column"] - 1
                for place in (one["span"]["start"], one["span"]["end"])
            )
            return text[:start] + one["replacement"] + text[end:]

        file, line = f"{NATIVE}/{one['file']}", one["span"]["start"]["line"]
        changes[file, line].append(_Change(file, line, one["genre"], make))
    return changes
