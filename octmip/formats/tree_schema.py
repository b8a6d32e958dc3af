"""The schema of tree files: the kind and the range of every value in them, as checks and as JSON Schema.

How names and sizes of a file belong together is no matter of a single value: `octmip.formats.tree_file` checks it.
"""

from dataclasses import dataclass
from typing import Any

from octmip.formats.columns.columns import COLUMNS
from octmip.input.checked import (
    Anything,
    AsItIs,
    Choice,
    Either,
    Kind,
    ListOf,
    MapOf,
    MisfitError,
    Number,
    Record,
    Schema,
    Text,
    Truth,
    Whole,
    maybe,
)
from octmip.input.messages import shown
from octmip.trees.answer.solution import Stop
from octmip.trees.nodes.tree import SIDES
from octmip.trees.question.losses import NUMBER_LOSSES, SAMPLE_COSTS, ClassCosts
from octmip.trees.question.shape import MAX_DEPTH

FORMAT, VERSION = "octmip-tree", 4
COST, COUNT = Number(low=0.0), Whole(1, 2**53)
NAME, CLASS = Text(), AsItIs(Either((Text(), Truth(), Number())))


@dataclass(frozen=True, slots=True)
class NodeKind:
    """A node of a tree: a leaf, a split on one feature, or one on several, by the entries that it has."""

    words: str = (
        "a node: label, or value, or left and right with feature and threshold, or features, coefficients and offset"
    )

    def take(self, value: Any) -> dict[str, Any]:
        """Return the node and all below it."""
        marks = [mark for mark in _NODES if type(value) is dict and mark.split()[0] in value]
        kind = next((_NODES[mark] for mark in marks if mark.endswith(" missing") == ("missing" in value)), None)
        if kind is None:
            raise MisfitError(
                f"is {shown(value)} and lacks the entry 'label', 'value' or 'left'; expected {self.words}"
            )
        return kind.take(value)

    def schema(self) -> Schema:
        """Return the reference to the definition, which holds itself."""
        return {"$ref": "#/$defs/node"}


NODE = NodeKind()
_SIDES: dict[str, Kind] = {"left": NODE, "right": NODE}
_PLANE: dict[str, Kind] = {"features": ListOf(NAME, 1), "coefficients": ListOf(Number(), 1), "offset": Number()}
_MISSING: dict[str, Kind] = {"missing": Choice(SIDES)}
_NODES = {
    "label": Record({"label": CLASS}, closed=True),
    "value": Record({"value": Number(), "features": ListOf(NAME), "coefficients": ListOf(Number())}, closed=True),
    "feature": Record({"feature": NAME, "threshold": Number(), **_SIDES}, closed=True),
    "feature missing": Record({"feature": NAME, "threshold": maybe(Number()), **_MISSING, **_SIDES}, closed=True),
    "left": Record({**_PLANE, **_SIDES}, closed=True),
    "left missing": Record({**_PLANE, **_MISSING, **_SIDES}, closed=True),
}
"""Nodes by the entry that marks them; "missing" besides where the split has a side for missing readings."""


@dataclass(frozen=True, slots=True)
class LossKind:
    """What `Loss.to_json` returns, by the name that it holds."""

    words: str = "an object with name"

    def take(self, value: Any) -> dict[str, Any]:
        """Return the name, and what belongs to it."""
        return _LOSSES[Record({"name": Choice(tuple(_LOSSES))}).take(value)["name"]].take(value)

    def schema(self) -> Schema:
        """Return the JSON Schema."""
        return {"anyOf": [kind.schema() for kind in _LOSSES.values()]}


_PARAMETERS: dict[str, dict[str, Kind]] = {
    ClassCosts.name: {"costs": ListOf(ListOf(COST))},
    SAMPLE_COSTS: {"costs": ListOf(ListOf(COST))},
    **{name: {key: Number(*ends) for key, ends in loss.parameters.items()} for name, loss in NUMBER_LOSSES.items()},
}
_LOSSES = {name: Record({"name": Choice((name,)), **kinds}, closed=True) for name, kinds in _PARAMETERS.items()}
SETTINGS: dict[str, Kind] = {
    "depth": maybe(Whole(1, MAX_DEPTH)),
    "loss": LossKind(),
    "split": Choice(("axis", "hyperplane")),
    "split_size": maybe(COUNT),
    "leaf_size": COUNT,
    "leaf_weight": maybe(COST),
    "leaf_penalty": COST,
    "leaf_model": Choice(("constant", "linear")),
    "ridge": COST,
    "sensor_of_feature": ListOf(NAME),
    "sensor_cost": MapOf(COST),
    "sensor_budget": maybe(COST),
    "allowed_splits": maybe(ListOf(ListOf(Either((NAME, Whole(0, 2**31))), 1))),
    "integer_normals": maybe(COUNT),
    "max_splits": maybe(Whole()),
    "monotone": maybe(ListOf(Choice(("+", "-", "0")))),
    "fixed_splits": maybe(MapOf(NAME)),
    "path_rules": maybe(ListOf(ListOf(NAME, 2))),
    "old_tree": maybe(NODE),
    "max_changes": maybe(Whole()),
    "takes_missing": Truth(),
}
CLAIMS: dict[str, Kind] = {
    "objective": Number(),
    "bound": maybe(Number()),
    "stop": Choice(tuple(str(stop) for stop in Stop)),
    "seconds": COST,
    "n_nodes": Whole(),
    "solver": NAME,
    "version": NAME,
    "seed": Whole(),
    "tolerance": COST,
    "details": MapOf(Anything()),
}
TRAINING: dict[str, Kind] = {
    "sha256": Text("^[0-9a-f]{64}$", "the 64 digits of a sha256, a text"),
    "n_samples": COUNT,
    "target": maybe(NAME),
    "weights": maybe(NAME),
    "leaf_counts": ListOf(ListOf(Whole(0, 2**53)), 1),
}
TABLE: dict[str, Kind] = {
    "columns": COLUMNS,
    "index": maybe(NAME),
    "rows": Choice(("all", "labelled", "complete")),
    "class_weight": maybe(ListOf(COST)),
}
HELD_OUT: dict[str, Kind] = {
    "share": maybe(Number(low=0.0, high=1.0)),
    "seed": Whole(),
    "n_samples": COUNT,
    "measures": MapOf(COST),
    "cost": COST,
}
CONTENT = Record(
    {
        "tree": NODE,
        "feature_names": ListOf(NAME, 1),
        "class_names": ListOf(CLASS),
        "problem": Record(SETTINGS),
        "training": Record(TRAINING),
        "solution": Record(CLAIMS),
        "table": maybe(Record(TABLE)),
        "held_out": maybe(Record(HELD_OUT, closed=True)),
        "readings": Record({"units": MapOf(NAME), "loads": MapOf(Number())}, closed=True),
    }
)


def schema() -> Schema:
    """Return the JSON Schema of tree files: each value's kind and range, not how names and sizes hang together."""
    content = CONTENT.schema()
    marks = {"format": {"const": FORMAT}, "version": {"const": VERSION}}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "octmip tree file",
        **content,
        "properties": marks | content["properties"],
        "required": [*marks, *content["required"]],
        "$defs": {"node": {"anyOf": [kind.schema() for kind in _NODES.values()]}},
    }
