"""A tree as an ONNX graph in double precision.

The operators of ONNX made for trees keep thresholds in single precision in most runtimes; so the graph is written in
plain comparisons and choices, of which every runtime has the double-precision ones.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from octmip.errors import SolverError
from octmip.tree import Leaf, Node, Split

if TYPE_CHECKING:
    import onnx

OPSET = 16
"""Operator set: the first with comparison (<=) of doubles in all runtimes in use."""
IR_VERSION = 8


def onnx_model(tree: Node, feature_names: Sequence[str], class_names: Sequence[Any]) -> "onnx.ModelProto":
    """Return a model with input "readings" (n, n_features) double and output "label" (n,) int64, -1 for no answer.

    Raises:
        SolverError: the package onnx is not installed.
    """
    try:
        import onnx
    except ImportError as error:
        raise SolverError("export to ONNX needs the package onnx; install it, or octmip[onnx]") from error
    graph = _Graph(onnx, len(feature_names))
    graph.answer(tree)
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
    helper.set_model_props(model, {"features": "\n".join(feature_names), "classes": "\n".join(map(str, class_names))})
    return model


class _Graph:
    """The operators of one graph, in the order in which they are computed."""

    def __init__(self, onnx: Any, n_features: int) -> None:
        self.onnx, self.n_features = onnx, n_features
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def answer(self, tree: Node) -> None:
        """Add everything; the last operator bears the output's name."""
        label = self.label(tree)
        shape = self.add("Mul", self.column(0), self.constant(0.0))  # a leaf alone still answers once a reading
        is_row = self.add("Or", self.add("Equal", shape, shape), self.constant(True))
        self.add("Where", is_row, label, label, output="label")

    def label(self, node: Node) -> str:
        if isinstance(node, Leaf):
            return self.constant(np.int64(node.label))
        total = self.column(node.features[0]) if isinstance(node, Split) else ""
        threshold = node.threshold if isinstance(node, Split) else node.offset
        if not isinstance(node, Split):
            for coefficient, feature in zip(node.coefficients, node.features, strict=True):
                product = self.add("Mul", self.constant(coefficient), self.column(feature))
                total = self.add("Add", total, product) if total else product
        limit = self.constant(threshold)
        left, right = self.add("LessOrEqual", total, limit), self.add("Greater", total, limit)
        other = self.add("Where", right, self.label(node.right), self.constant(np.int64(-1)))
        return self.add("Where", left, self.label(node.left), other)

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
