"""Rules of the house that imports do not show.

What is frozen keeps nothing, and octmip knows nothing of femlib's effects.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from octmip.gap.effects import CHAIN
from octmip.gap.next_test import OTHER_TESTS
from octmip.twin import QUANTITIES

ROOT = Path(__file__).parent.parent
MUTABLE = {"dict", "list", "set", "bytearray", "defaultdict", "deque", "Counter", "OrderedDict"}

LONGEST_LINE = 120
EFFECTS = ROOT / "femlib" / "wing" / "effects"


def frozen_classes(code: str) -> Iterator[ast.ClassDef]:
    """Yield the dataclasses of a module that say they are frozen."""
    for node in ast.walk(ast.parse(code)) if "frozen=True" in code else ():
        decorators = node.decorator_list if isinstance(node, ast.ClassDef) else []
        for call in (d for d in decorators if isinstance(d, ast.Call)):
            words = {keyword.arg: keyword.value for keyword in call.keywords}
            if ast.unparse(call.func).endswith("dataclass") and ast.unparse(words.get("frozen", call)) == "True":
                yield node


def holds_mutable(annotation: ast.expr) -> bool:
    """Return whether a field of this annotation can change although its class is frozen; what it returns may."""
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        return holds_mutable(ast.parse(annotation.value, mode="eval").body)
    if isinstance(annotation, ast.Name | ast.Attribute):
        return ast.unparse(annotation).split(".")[-1] in MUTABLE
    if isinstance(annotation, ast.Subscript) and ast.unparse(annotation.value).endswith("Callable"):
        return False
    parts = (node for node in ast.iter_child_nodes(annotation) if isinstance(node, ast.expr))
    return any(holds_mutable(node) for node in parts)


def caches(code: str) -> set[str]:
    """Return the fields that can change, and the methods that set fields after `__post_init__`, as Class.name."""
    found = set()
    for node in frozen_classes(code):
        fields = [line for line in node.body if isinstance(line, ast.AnnAssign)]
        found |= {f"{node.name}.{ast.unparse(line.target)}" for line in fields if holds_mutable(line.annotation)}
        if "object.__setattr__" not in code:
            continue
        methods = {line.name: ast.unparse(line) for line in node.body if isinstance(line, ast.FunctionDef)}
        early = {"__post_init__"}
        while more := {name for name in methods if any(f"self.{name}(" in methods.get(m, "") for m in early)} - early:
            early |= more
        found |= {f"{node.name}.{name}" for name in methods.keys() - early if "object.__setattr__" in methods[name]}
    return found


@pytest.mark.parametrize("package", ["octmip", "femlib"])
def test_what_is_frozen_keeps_nothing(package):
    files = sorted((ROOT / package).rglob("*.py"))
    found = {str(file.relative_to(ROOT)): caches(file.read_text()) for file in files}
    assert not any(found.values()), {name: fields for name, fields in found.items() if fields}


@pytest.mark.parametrize(
    ("field", "is_cache"),
    [
        ("kept: dict[str, int] = field(default_factory=dict)", True),
        ("rows: 'list[int]'", True),
        ("rows: tuple[dict[int, float], ...]", True),
        ("rows: set[int] | None = None", True),
        ("rows: tuple[int, ...]", False),
        ("rows: Mapping[str, Sequence[int]]", False),
        ("ask: Callable[[], dict[str, int]]", False),
    ],
)
def test_a_cache_in_a_frozen_class_is_found(field, is_cache):
    assert bool(caches(f"@dataclass(frozen=True, slots=True)\nclass Kept:\n    {field}\n")) == is_cache
    assert not caches(f"@dataclass(slots=True)\nclass Kept:\n    {field}\n")


def test_a_field_that_is_set_late_is_found():
    late = "    def ask(self):\n        object.__setattr__(self, 'x', 1)\n"
    early = "    def __post_init__(self):\n        self.ask()\n"
    assert caches(f"@dataclass(frozen=True)\nclass Kept:\n{late}") == {"Kept.ask"}
    assert not caches(f"@dataclass(frozen=True)\nclass Kept:\n{early}{late}")


def test_links_between_pages_lead_somewhere():
    for page in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]:
        links = re.findall(r"\]\(([^)#\s]+)", page.read_text())
        assert not [link for link in links if ":" not in link and not (page.parent / link).exists()], page


def source_files(suffix: str) -> Iterator[Path]:
    for folder in ("octmip", "femlib", "benchmarks"):
        files = (ROOT / folder).rglob(f"*.{suffix}")
        yield from (file for file in files if "target" not in file.parts)


def test_every_file_that_the_documentation_walks_through_exists():
    text = (ROOT / "docs" / "developing.md").read_text()
    named = re.findall(r"`((?:octmip|femlib|benchmarks|tests)/[\w/]+\.(?:py|rs|md))`", text)
    assert len(named) > 60
    assert not [name for name in named if not (ROOT / name).is_file() and "NAME" not in name]


def test_no_line_of_a_comment_is_long():
    for file in source_files("rs"):
        for k, line in enumerate(file.read_text().splitlines(), 1):
            assert len(line) <= LONGEST_LINE or not line.lstrip().startswith("//"), f"{file}:{k}"


def wing_cards() -> list[dict[str, object]]:
    """Return name and seen_by of every effect of the wing, as its file says them."""
    calls = [node for file in sorted(EFFECTS.rglob("*.py")) for node in ast.walk(ast.parse(file.read_text()))]
    cards = []
    for call in (node for node in calls if isinstance(node, ast.Call)):
        words = {keyword.arg: keyword.value for keyword in call.keywords}
        if {"name", "separated_by"} <= words.keys():
            cards.append({key: ast.literal_eval(words[key]) for key in ("name", "seen_by") if key in words})
    return cards


def test_octmip_names_no_effect_of_the_wing():
    names = {card["name"] for card in wing_cards()}
    assert len(names) >= 13
    quoted = re.compile(rf"""["']({"|".join(names)})["']""")
    for file in sorted((ROOT / "octmip").rglob("*.py")):
        assert not quoted.search(file.read_text()), file


def test_every_effect_is_seen_by_quantities_that_some_test_measures():
    assert set(OTHER_TESTS) == set(QUANTITIES)
    seen = [card.get("seen_by", ()) for card in wing_cards()] + [getattr(e, "seen_by", ()) for e in CHAIN.values()]
    assert {quantity for quantities in seen for quantity in quantities} == set(QUANTITIES)
