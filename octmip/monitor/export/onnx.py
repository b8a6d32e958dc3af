"""A tree as an ONNX graph in double precision.

The operators of ONNX made for trees keep thresholds in single precision in most runtimes, and of two classes some
answer another than scores more; so the graph is written in plain comparisons and choices, of which every runtime has
the double-precision ones. What readings and answers are is metadata alone, as JSON.
"""

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from octmip.errors import TreeError, needed_by
from octmip.formats.columns import Columns
from octmip.formats.columns.cells import UNKNOWN
from octmip.formats.columns.column import Column
from octmip.formats.columns.written import words_of
from octmip.input.cells import EXACT_INTEGERS
from octmip.input.names import shown
from octmip.monitor.export.legend import Legend
from octmip.monitor.export.questions import (
    Answer,
    Asked,
    ClassNames,
    NumberAsked,
    OwnTree,
    Part,
    Term,
    TextAsked,
    own_tree,
)
from octmip.trees.nodes.tree import SIDES, Node, Side

if TYPE_CHECKING:
    import onnx

OPSETS = {False: (16, 8), True: (19, 9)}
"""Operator set and IR version without and with texts: the first that compares doubles, and texts."""
OUTPUT = "prediction"


def onnx_model(
    tree: Node,
    columns: Columns | Sequence[str],
    class_names: ClassNames = None,
    *,
    legend: Legend | None = None,
) -> "onnx.ModelProto":
    """Return a model whose output "prediction" (n,) is what `predict` returns.

    Where all columns hold numbers, it has one input "readings" (n, n_columns), double: a date as days since 1970-01-01
    (UTC), a Boolean as 1 or 0, NaN where a cell is missing. Where some hold texts, every column that the tree reads is
    an input of its own, (n, 1), by its name: double, or text, which is empty where a cell is missing. The output is
    double, NaN without an answer (Booleans are 1 and 0), or text, empty without one. The metadata "readings" and
    "answers" are JSON, pure ASCII.

    Raises
    ------
    MissingExtraError
        the package onnx is not installed.
    TreeError
        the names do not cover the tree, or ONNX has no such name or answer.

    Examples
    --------
    >>> model = onnx_model(Split(0, 2.5, Leaf(0), Leaf(1)), ["g1"], ["sound", "damaged"])
    >>> [one.name for one in model.graph.output]
    ['prediction']
    """
    own = own_tree(tree, columns, class_names)
    _check(own)
    with needed_by("export to ONNX"):
        import onnx
    has_texts = any(column.kind not in ("number", "empty") for column in own.columns)
    graph = _Graph(onnx, own, has_texts)
    graph.build()
    helper, kinds = onnx.helper, onnx.TensorProto
    answer = kinds.STRING if own.answers_text else kinds.DOUBLE
    made = helper.make_graph(
        graph.nodes,
        "octmip_tree",
        graph.inputs(),
        [helper.make_tensor_value_info(OUTPUT, answer, ["n"])],
        graph.constants,
    )
    opset, version = OPSETS[has_texts]
    model = helper.make_model(
        made, opset_imports=[helper.make_opsetid("", opset)], ir_version=version, producer_name="octmip"
    )
    helper.set_model_props(model, {what: json.dumps(told) for what, told in _told(own, legend or Legend()).items()})
    return model


def _told(own: OwnTree, legend: Legend) -> dict[str, Any]:
    """Return what the model says of itself."""
    readings = [
        {"name": column.name, "unit": legend.readings.units.get(column.name, ""), "cells": _cells(column)}
        for column in own.columns
    ]
    return {
        "readings": readings,
        "answers": list(own.answers),
        "answers_are": "indices of classes" if own.are_indices else "values",
        "target": {"name": legend.target, "unit": legend.readings.units.get(legend.target, "")},
        "loads": dict(legend.readings.loads),
    }


def _cells(column: Column) -> str:
    if column.kind != "number":
        return "none" if column.kind == "empty" else "texts"
    return words_of(column.form) if column.form else "Booleans, 1 or 0" if column.stored == "truths" else "numbers"


def _check(own: OwnTree) -> None:
    """Refuse what the tensors of ONNX cannot tell apart or hold."""
    beyond = [value for value in own.answers if isinstance(value, int) and abs(value) > EXACT_INTEGERS]
    if beyond:
        raise TreeError(
            f"the class {beyond[0]} is beyond 2^53, and the output is double; expected a smaller one; make the classes "
            "texts"
        )
    texts = [*own.answers, *(column.name for column in own.columns), *(v for c in own.columns for v in c.values)]
    for text in texts:
        if isinstance(text, str) and any(0xD800 <= ord(character) < 0xE000 for character in text):
            raise TreeError(f"{shown(text)} holds half of a surrogate pair, which no text of ONNX can hold; rename it")
    if OUTPUT in (own.columns[k].name for k in own.read):
        raise TreeError(f"a column is called {OUTPUT!r}, as the model's output is; rename the column and train again")
    for what, values in (("the classes", own.answers), *((f"column {shown(c.name)}", c.values) for c in own.columns)):
        if "" in values:
            raise TreeError(f"{what} hold an empty text, which stands for a missing one in ONNX; rename the value")


class _Graph:
    """The operators of one graph, in the order in which they are computed."""

    def __init__(self, onnx: Any, own: OwnTree, has_texts: bool) -> None:
        self.onnx, self.own, self.has_texts = onnx, own, has_texts
        self.nodes: list[Any] = []
        self.constants: list[Any] = []
        self.cells: dict[int, str] = {}
        self.prefix = "octmip "
        while any(column.name.startswith(self.prefix) for column in own.columns):
            self.prefix += "_"
        self.none: Any = "" if own.answers_text else np.nan

    def inputs(self) -> list[Any]:
        """Return the inputs: one of all columns, or one for each."""
        kinds, make = self.onnx.TensorProto, self.onnx.helper.make_tensor_value_info
        if not self.has_texts:
            return [make("readings", kinds.DOUBLE, ["n", len(self.own.columns)])]
        read = [self.own.columns[k] for k in self.own.read or (0,)]
        return [make(c.name, kinds.DOUBLE if c.kind == "number" else kinds.STRING, ["n", 1]) for c in read]

    def build(self) -> None:
        """Add everything; the last operator bears the output's name."""
        answer = self.answer(self.own.root)
        cell = self.column(next(iter(self.own.read), 0))  # a leaf alone still gives one result per row
        is_row = self.add("Or", self.add("Equal", cell, cell), self.constant(True))
        self.add("Where", is_row, answer, answer, output=OUTPUT)

    def answer(self, part: Part) -> str:
        if isinstance(part, Answer):
            if not part.terms:
                return self.constant(part.value if isinstance(part.value, str) else float(part.value))
            total = self.total(part.terms, self.constant(part.value))
            gone = self.add("Sub", total, total)  # 0 where the sum is finite
            return self.add("Where", self.add("Equal", gone, self.constant(0.0)), total, self.constant(np.nan))
        left, right = self.sides(part.asked)
        other = self.add("Where", right, self.answer(part.right), self.constant(self.none))
        return self.add("Where", left, self.answer(part.left), other)

    def sides(self, asked: Asked) -> tuple[str, str]:
        """Add whether a row goes left and whether it goes right; neither for what has no answer."""
        if isinstance(asked, NumberAsked | TextAsked):
            cell, missing = self.column(asked.column), self.missing(asked.column)
            if isinstance(asked, TextAsked):
                left, right = (self.among(asked, cell, missing, side) for side in SIDES)
            elif asked.threshold is None:
                left = right = self.add("Not", missing)
                return (missing, right) if asked.missing == "left" else (left, missing)
            else:
                limit = self.constant(asked.threshold)
                left, right = self.add("LessOrEqual", cell, limit), self.add("Greater", cell, limit)
        else:
            counted = [self.counted(term) for term in asked.terms]
            missing = self.any([self.add("Not", self.add("Equal", one, one)) for one in counted])
            left = self.add("LessOrEqual", self.total(asked.terms, ""), self.constant(asked.offset))
            right = self.add("Not", missing)  # a sum that is no number goes right
        if asked.missing == "left":
            left = self.add("Or", left, missing)
        elif asked.missing == "right":
            right = self.add("Or", right, missing)
        return left, right

    def among(self, asked: TextAsked, cell: str, missing: str, side: Side) -> str:
        """Add whether a text is one of those that go to a side."""
        if asked.others != side:
            return self.any([self.add("Equal", cell, self.constant(text)) for text in asked.texts(side)])
        rest = asked.texts("right" if side == "left" else "left")
        elsewhere = [self.add("Equal", cell, self.constant(text)) for text in rest]
        return self.add("Not", self.any([missing, *elsewhere]))

    def any(self, conditions: Sequence[str]) -> str:
        """Add whether one of some conditions holds."""
        found = self.constant(False)
        for condition in conditions:
            found = self.add("Or", found, condition)
        return found

    def total(self, terms: Sequence[Term], total: str) -> str:
        for term in terms:
            product = self.add("Mul", self.constant(term.coefficient), self.counted(term))
            total = self.add("Add", total, product) if total else product
        return total

    def counted(self, term: Term) -> str:
        """Add what the cell of a term counts, NaN where it counts nothing."""
        cell, missing = self.column(term.column), self.missing(term.column)
        if term.counts:
            found = self.constant(np.nan if term.others is None else term.others)
            for text, number in term.counts:
                found = self.add("Where", self.add("Equal", cell, self.constant(text)), self.constant(number), found)
        else:
            found = cell
            for end, beyond in ((term.least, "Less"), (term.most, "Greater")):
                if end is not None:
                    limit = self.constant(end)
                    found = self.add("Where", self.add(beyond, cell, limit), limit, found)
        return self.add("Where", missing, self.constant(np.nan if term.missing is None else term.missing), found)

    def missing(self, place: int) -> str:
        """Add whether the cell of a column is missing."""
        cell, column = self.column(place), self.own.columns[place]
        if column.kind == "number":
            return self.add("Not", self.add("Equal", cell, cell))  # what is missing does not equal itself
        nothing = [text for text in ("", UNKNOWN) if text not in column.values]
        return self.any([self.add("Equal", cell, self.constant(text)) for text in nothing])

    def column(self, place: int) -> str:
        if place not in self.cells:
            if self.has_texts:
                name = self.own.columns[place].name
                self.cells[place] = self.add("Squeeze", name, self.constant(np.array([1], dtype=np.int64)))
            else:
                self.cells[place] = self.add("Gather", "readings", self.constant(np.int64(place)), axis=1)
        return self.cells[place]

    def constant(self, value: Any) -> str:
        name = f"{self.prefix}constant {len(self.constants)}"
        array = np.array(value, dtype=object) if isinstance(value, str) else np.array(value)
        self.constants.append(self.onnx.numpy_helper.from_array(array, name))
        return name

    def add(self, operator: str, *inputs: str, output: str = "", **attributes: Any) -> str:
        name = output or f"{self.prefix}value {len(self.nodes)}"
        self.nodes.append(self.onnx.helper.make_node(operator, inputs, [name], **attributes))
        return name
