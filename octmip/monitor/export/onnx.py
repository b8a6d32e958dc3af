"""A tree as an ONNX graph in double precision.

The operators of ONNX made for trees keep thresholds in single precision in most runtimes; so the graph is written in
plain comparisons and choices, of which every runtime has the double-precision ones. Names of features and classes are
metadata alone, as JSON: a line end in a name must not make two of it.
"""

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from octmip.errors import needed_by
from octmip.monitor.export.fit import check_fit, class_values
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Split

if TYPE_CHECKING:
    import onnx

OPSET = 16
"""Operator set: the first with comparison (<=) of doubles in all runtimes in use."""
IR_VERSION = 8


def onnx_model(tree: Node, feature_names: Sequence[str], class_names: Sequence[Any]) -> "onnx.ModelProto":
    """Return a model with input "readings" (n, n_features) double and output "label" (n,) int64, -1 for no result.

    Its metadata "features" and "classes" are JSON lists, pure ASCII.

    Raises
    ------
    MissingExtraError
        the package onnx is not installed.
    TreeError
        the names do not cover the tree.
    """
    check_fit(tree, feature_names, class_names)
    with needed_by("export to ONNX"):
        import onnx
    graph = _Graph(onnx, len(feature_names))
    graph.build(tree)
    helper, kinds = onnx.helper, onnx.TensorProto
    made = helper.make_graph(
        graph.nodes,
        "octmip_tree",
        [helper.make_tensor_value_info("readings", kinds.DOUBLE, ["n", len(feature_names)])],
        [helper.make_tensor_value_info("label", kinds.INT64, ["n"])],
        graph.constants,
    )
    opsets = [helper.make_opsetid("", OPSET)]
    model = helper.make_model(made, opset_imports=opsets, ir_version=IR_VERSION, producer_name="octmip")
    names = {"features": [str(name) for name in feature_names], "classes": class_values(class_names)}
    helper.set_model_props(model, {what: json.dumps(listed) for what, listed in names.items()})
    return model


class _Graph:
    """The operators of one graph, in the order in which they are computed."""

    def __init__(self, onnx: Any, n_features: int) -> None:
        self.onnx, self.n_features = onnx, n_features
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def build(self, tree: Node) -> None:
        """Add everything; the last operator bears the output's name."""
        label = self.label(tree)
        shape = self.add("Mul", self.column(0), self.constant(0.0))  # a leaf alone still gives one result per reading
        is_row = self.add("Or", self.add("Equal", shape, shape), self.constant(True))
        self.add("Where", is_row, label, label, output="label")

    def label(self, node: Node) -> str:
        if isinstance(node, Leaf):
            return self.constant(np.int64(node.label))
        left, right = self.sides(node)
        other = self.add("Where", right, self.label(node.right), self.constant(np.int64(-1)))
        return self.add("Where", left, self.label(node.left), other)

    def sides(self, split: Split | HyperplaneSplit) -> tuple[str, str]:
        """Add whether a reading goes left and whether it goes right; neither for what is missing and has no side."""
        if isinstance(split, Split) and split.threshold is None:
            missing = self.missing(split)
            sides = missing, self.add("Not", missing)
            return sides if split.missing == "left" else sides[::-1]
        given = split.threshold if isinstance(split, Split) else split.offset
        assert given is not None
        total, limit = self.total(split), self.constant(float(given))
        left = self.add("LessOrEqual", total, limit)
        if isinstance(split, HyperplaneSplit):  # a sum that is no number goes right, where no reading is missing
            right = self.add("Not", self.missing(split))
        else:
            right = self.add("Greater", total, limit)
        if split.missing == "left":
            left = self.add("Or", left, self.missing(split))
        elif split.missing == "right":
            right = self.add("Or", right, self.missing(split))
        return left, right

    def total(self, split: Split | HyperplaneSplit) -> str:
        if isinstance(split, Split):
            return self.column(split.feature)
        total = ""
        for coefficient, feature in zip(split.coefficients, split.features, strict=True):
            product = self.add("Mul", self.constant(float(coefficient)), self.column(feature))
            total = self.add("Add", total, product) if total else product
        return total

    def missing(self, split: Split | HyperplaneSplit) -> str:
        """Add whether some reading is missing: what is missing does not equal itself."""
        found = ""
        for feature in split.features:
            column = self.column(feature)
            one = self.add("Not", self.add("Equal", column, column))
            found = self.add("Or", found, one) if found else one
        return found

    def column(self, feature: int) -> str:
        return self.add("Gather", "readings", self.constant(np.int64(feature)), axis=1)

    def constant(self, value: Any) -> str:
        name = f"c{len(self.constants)}"
        self.constants.append(self.onnx.numpy_helper.from_array(np.array(value), name))
        return name

    def add(self, operator: str, *inputs: str, output: str = "", **attributes: Any) -> str:
        name = output or f"v{len(self.nodes)}"
        self.nodes.append(self.onnx.helper.make_node(operator, inputs, [name], **attributes))
        return name
