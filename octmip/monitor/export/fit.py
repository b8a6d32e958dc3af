"""Checks of a tree and its names before an export, and the names as JSON for the receiver of the export."""

import json
import math
from collections.abc import Sequence
from typing import Any

from octmip.errors import TreeError
from octmip.formats.columns import Columns, Feature
from octmip.formats.columns.column import Column, set_words
from octmip.formats.columns.written import words_of
from octmip.input.names import shown
from octmip.trees.shape import MAX_DEPTH
from octmip.trees.tree import Leaf, Node, leaves, splits


def names_json(feature_names: Sequence[str], class_names: Sequence[Any], columns: Columns | None = None) -> str:
    """Return ``{"features": [...], "classes": [...]}``, pure ASCII: the names of the places and codes of an export.

    Classes that are numbers stay numbers, all others are text. Where the features were made from the columns of a table
    (`TreeFile.columns`), `inputs` says of each what the receiver must give there.
    """
    names = {"features": [str(name) for name in feature_names], "classes": class_values(class_names)}
    return json.dumps(names if columns is None else names | {"inputs": list(input_words(columns))})


def input_words(columns: Columns) -> tuple[str, ...]:
    """Return for each feature that was made from a column what number stands there, in words.

    "1 where colour is red, else 0"; "age, NaN or NULL where it is missing"; for the two features of older tree files
    "age, at least 20; -33 where it is missing".
    """
    return tuple(_input_of(column, feature) for column in columns.columns for feature in column.features)


def _input_of(column: Column, feature: Feature) -> str:
    if feature.kind == "is":
        return f"1 where {column.name} is {feature.value}, else 0"
    if feature.kind == "is-missing":
        return f"1 where {column.name} is missing, else 0"
    if feature.kind == "among":
        return f"1 where {column.name} is in {set_words(feature.members)}, else 0"
    ranks = ", ".join(f"{k}: {value}" for k, value in enumerate(column.values))
    number = column.name if column.kind == "number" else f"the rank of {column.name} ({ranks})"
    if column.form:
        number = f"{number} in {words_of(column.form)}"
    if feature.kind in ("number", "order"):
        return f"{number}, NaN or NULL where it is missing" if column.has_missing else number
    (below, above), is_left = column.beyond, feature.kind == "missing-left"
    least, most = (column.least, column.most) if column.kind == "number" else (0.0, len(column.values) - 1.0)
    end = f"at least {least!r}; {below!r}" if is_left else f"at most {most!r}; {above!r}"
    return f"{number}, {end} where it is missing"


def class_values(class_names: Sequence[Any]) -> list[Any]:
    """Return class names as JSON has them: numbers and booleans as they are, all others as text."""
    plain = [name.item() if hasattr(name, "item") else name for name in class_names]
    return [name if _is_json_number(name) else str(name) for name in plain]


def _is_json_number(value: Any) -> bool:
    return isinstance(value, int) or (isinstance(value, float) and math.isfinite(value))


def check_fit(tree: Node, feature_names: Sequence[str], class_names: Sequence[Any] | None = None) -> None:
    """Refuse a tree that the names do not cover, or deeper than any problem allows.

    Raises
    ------
    TreeError
        it reads a feature or predicts a class without a name, or has more than `MAX_DEPTH` levels.
    """
    _check_depth(tree)
    highest = max((split.features[-1] for split in splits(tree)), default=-1)
    if highest >= len(feature_names):
        raise TreeError(
            f"the tree reads feature {highest} but feature_names has {len(feature_names)} entries; expected at least "
            f"{highest + 1}; name every feature of a reading, in its order"
        )
    label = max(leaf.label for leaf in leaves(tree))
    if class_names is not None and label >= len(class_names):
        raise TreeError(
            f"the tree predicts class {label} but class_names has {len(class_names)} entries; expected at least "
            f"{label + 1}; name every class, in the order of the problem's"
        )


def _check_depth(tree: Node) -> None:
    """Refuse a tree that is too deep, without recursion: it may be deeper than Python's stack."""
    level = [tree]
    for _ in range(MAX_DEPTH + 1):
        level = [side for node in level if not isinstance(node, Leaf) for side in (node.left, node.right)]
        if not level:
            return
    raise TreeError(
        f"the tree has more than {MAX_DEPTH} levels of splits; expected a depth that a problem can have, which "
        "compilers and databases hold too; find a tree with Problem(depth=...) of at most that"
    )


def check_column(name: str) -> str:
    """Return a feature's name, refused where no database takes it for a column.

    Raises
    ------
    TreeError
        it holds a NUL character or half of a surrogate pair.
    """
    name = str(name)
    if "\0" in name or any(0xD800 <= ord(character) < 0xE000 for character in name):
        what = "a NUL character" if "\0" in name else "half of a surrogate pair, which is no character"
        raise TreeError(
            f"feature name {shown(name)} holds {what}; expected text that a database takes for the name of a column; "
            "rename the feature and the column"
        )
    return name
