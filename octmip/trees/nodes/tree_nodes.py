"""The nodes of a tree as nested JSON objects, features and classes by name."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from octmip.errors import TreeError
from octmip.input.messages import shown
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, ValueLeaf


def encode_tree(tree: Node, feature_names: tuple[str, ...], class_names: tuple[Any, ...]) -> dict[str, Any]:
    """Return a tree as nested JSON objects, features and classes by name."""
    if isinstance(tree, ValueLeaf):
        return {"value": tree.value, **_terms(tree, feature_names)}
    if isinstance(tree, Leaf):
        return {"label": class_names[tree.label]}
    sides: dict[str, Any] = {
        "left": encode_tree(tree.left, feature_names, class_names),
        "right": encode_tree(tree.right, feature_names, class_names),
    }
    sides = ({} if tree.missing is None else {"missing": tree.missing}) | sides
    if isinstance(tree, Split):
        return {"feature": feature_names[tree.feature], "threshold": tree.threshold, **sides}
    return {**_terms(tree, feature_names), "offset": tree.offset, **sides}


def _terms(node: ValueLeaf | HyperplaneSplit, feature_names: tuple[str, ...]) -> dict[str, Any]:
    return {"features": [feature_names[j] for j in node.features], "coefficients": list(node.coefficients)}


def different(names: Sequence[Any], what: str) -> tuple[Any, ...]:
    """Return names as a tuple.

    Raises
    ------
    TreeError
        one stands there twice.
    """
    if len(set(names)) < len(names):
        twice, times = Counter(names).most_common(1)[0]
        raise TreeError(f"{what} holds {shown(twice)} {times} times; expected a list of different names")
    return tuple(names)


def decode_tree(node: dict[str, Any], feature_names: Sequence[str], class_names: Sequence[Any]) -> Node:
    """Return the tree of nested JSON objects that `NODE` has taken; without class names one of numbers.

    Raises
    ------
    TreeError
        a feature or class is not among the names, a leaf holds a number where there are classes, or a split is none.
    """
    positions = [{name: k for k, name in enumerate(names)} for names in (feature_names, class_names)]
    return _node(node, *positions)


def _node(node: dict[str, Any], features: dict[str, int], classes: dict[Any, int]) -> Node:
    if "label" in node:
        return Leaf(_index(node["label"], classes, "class"))
    if "value" in node:
        if classes:
            raise TreeError(f"a leaf predicts the number {node['value']}; expected one of the {len(classes)} classes")
        return ValueLeaf(node["value"], *_indexed(node, features))
    left, right = _node(node["left"], features, classes), _node(node["right"], features, classes)
    missing = node.get("missing")
    if "feature" in node:
        return Split(_index(node["feature"], features, "feature"), node["threshold"], left, right, missing=missing)
    return HyperplaneSplit(*_indexed(node, features), node["offset"], left, right, missing=missing)


def _indexed(node: dict[str, Any], features: dict[str, int]) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Return the features and coefficients of a node in ascending order of the features."""
    read, coefficients = [_index(name, features, "feature") for name in node["features"]], node["coefficients"]
    if len(read) != len(coefficients):
        raise TreeError(f"a node has {len(read)} features and {len(coefficients)} coefficients; expected one for each")
    terms = sorted(zip(read, coefficients, strict=True))
    return tuple(j for j, _ in terms), tuple(c for _, c in terms)


def _index(name: Any, positions: dict[Any, int], kind: str) -> int:
    if name not in positions:
        raise TreeError(f"a node names the {kind} {shown(name)}, which is not among its {len(positions)} {kind} names")
    return positions[name]
