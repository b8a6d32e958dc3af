"""Mutants drawn at random: of Python by the operators of mutmut and `confused_name`, of Rust by cargo-mutants.

Texts and what is raised stay as they are: a message has no definition but itself. Annotations, decorators and imports
are no behaviour.
"""

import json
import subprocess
from collections import defaultdict
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import libcst as cst
import numpy as np
from libcst import matchers
from libcst.metadata import MetadataWrapper, PositionProvider
from mutmut.mutation.mutators import mutation_operators, operator_string

NATIVE = "octmip/trees/native"
CONFUSED = {"min": "max", "any": "all", "floor": "ceil", "argmin": "argmax"}
CONFUSED |= {other: name for name, other in CONFUSED.items()} | dict.fromkeys(("mean", "median", "sum"), "max")
CONFUSED |= {"abs": "float", "sorted": "list"}
"""Functions that take the same arguments."""


class Mutant(NamedTuple):
    """One wrong change: file from the tree's root, line, operator, and the file's text before and after."""

    file: str
    line: int
    operator: str
    before: str
    after: str

    def __str__(self) -> str:
        """Return the place and the first changed line as it was and as it is."""
        pairs = zip(*([*text.splitlines(), ""] for text in (self.before, self.after)), strict=False)
        was, now = next((a.strip(), b.strip()) for a, b in pairs if a != b)
        return f"{self.file}:{self.line} {was} -> {now}"


def confused_name(call: cst.Call) -> Iterable[cst.Call]:
    """Yield the call of another function that takes the same arguments."""
    name = call.func.attr if isinstance(call.func, cst.Attribute) else call.func
    if isinstance(name, cst.Name) and name.value in CONFUSED:
        yield call.with_deep_changes(name, value=CONFUSED[name.value])


TYPE_ALIAS = matchers.Assign(
    [matchers.AssignTarget(matchers.Name(matchers.MatchRegex("[A-Z][A-Za-z]*[a-z]")))], matchers.Subscript()
)
OPERATORS: list[tuple[type, Callable[[Any], Iterable[cst.CSTNode]]]] = [
    *(pair for pair in mutation_operators if pair[1] is not operator_string),
    (cst.Call, confused_name),
]


class _Visitor(cst.CSTVisitor):
    METADATA_DEPENDENCIES = (PositionProvider,)

    def __init__(self) -> None:
        self.found = defaultdict[int, list[tuple[str, cst.CSTNode, Any]]](list)

    def on_visit(self, node: cst.CSTNode) -> bool:
        if isinstance(node, (cst.Annotation, cst.Decorator, cst.ImportFrom, cst.Import, cst.Raise)):
            return False
        if matchers.matches(node, TYPE_ALIAS):
            return False
        for kind, operator in OPERATORS:
            for other in operator(node) if isinstance(node, kind) else ():
                if getattr(node, "evaluated_value", node) == getattr(other, "evaluated_value", other):
                    continue  # 1e120 + 1
                line = self.get_metadata(PositionProvider, node).start.line
                self.found[line].append((operator.__name__.removeprefix("operator_"), node, other))
        return True


def python_mutant(rng: np.random.Generator, root: Path, parts: Iterable[str]) -> Mutant:
    """Return a mutant of some folders and files of Python; each line that can be changed is as likely as any other."""
    files = [file for part in parts for file in sorted((root / part).rglob("*.py")) or [root / part]]
    sizes = np.array([file.read_bytes().count(b"\n") for file in files])
    found, visitor = files[0], _Visitor()
    while not visitor.found:
        found = files[rng.choice(len(files), p=sizes / sizes.sum())]
        module = MetadataWrapper(cst.parse_module(found.read_text(encoding="utf-8"))).visit(visitor := _Visitor())
    line = sorted(visitor.found)[rng.integers(len(visitor.found))]
    operator, node, other = visitor.found[line][rng.integers(len(visitor.found[line]))]
    after = cst.ensure_type(module.deep_replace(node, other), cst.Module).code
    return Mutant(str(found.relative_to(root)), line, operator, module.code, after)


def rust_mutant(rng: np.random.Generator, root: Path) -> Mutant:
    """Return a mutant of the native core."""
    every = _of_rust(root / NATIVE)
    one = every[rng.integers(len(every))]
    file, start = f"{NATIVE}/{one['file']}", one["span"]["start"]
    text = (root / file).read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    ends = [one["span"][end] for end in ("start", "end")]
    first, last = (sum(map(len, lines[: end["line"] - 1])) + end["column"] - 1 for end in ends)
    return Mutant(file, start["line"], one["genre"], text, text[:first] + one["replacement"] + text[last:])


@cache
def _of_rust(crate: Path) -> list[dict[str, Any]]:
    command = ["cargo", "mutants", "--list", "--json", "--workspace"]
    found: list[dict[str, Any]] = json.loads(subprocess.check_output(command, cwd=crate, stderr=subprocess.DEVNULL))
    return found
