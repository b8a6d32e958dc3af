"""A tree as one SQL expression over columns named like the features.

A decimal literal is not read to the last bit by every database, so a number is written as a whole number over a power
of two, both exact in float64, and so is their quotient. NULL, which also stands for NaN, is on no side of a split.
"""

import math
from collections.abc import Sequence
from typing import Any

from octmip.tree import Leaf, Node, Split

LARGEST = 62
"""Powers of two up to 2**62 are whole numbers of every database."""


def sql_expression(tree: Node, feature_names: Sequence[str], class_names: Sequence[Any] = ()) -> str:
    """Return the expression for ``SELECT <expression> FROM readings``: the index of the class, -1 for no answer.

    With `class_names` the expression ends in a comment that names them.
    """
    note = "; ".join(f"{k}: {name}" for k, name in enumerate(class_names)).replace("*/", "").replace("/*", "")
    return _case(tree, feature_names, "") + (f" /* {note} */" if note else "")


def _case(node: Node, names: Sequence[str], indent: str) -> str:
    if isinstance(node, Leaf):
        return str(node.label)
    if isinstance(node, Split):
        asked, threshold = _column(names[node.feature]), node.threshold
    else:
        terms = zip(node.coefficients, node.features, strict=True)
        products = [f"{_exact(c)} * {_column(names[j])}" for c, j in terms]
        asked, threshold = products[0], node.offset
        for product in products[1:]:
            asked = f"({asked} + {product})"
    inner = indent + "  "
    return (
        f"CASE\n{indent}WHEN {asked} <= {_exact(threshold)} THEN {_case(node.left, names, inner)}\n"
        f"{indent}WHEN {asked} > {_exact(threshold)} THEN {_case(node.right, names, inner)}\n{indent}ELSE -1 END"
    )


def _column(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _exact(number: float) -> str:
    """Return a number as an expression that is exact in float64."""
    numerator, denominator = number.as_integer_ratio()
    shift = (numerator & -numerator).bit_length() - 1 if denominator == 1 and numerator else 0
    text = f"CAST({numerator >> shift} AS DOUBLE PRECISION)"
    for power in _powers(shift):
        text = f"{text} * CAST({power} AS DOUBLE PRECISION)"
    for power in _powers(round(math.log2(denominator))):
        text = f"{text} / CAST({power} AS DOUBLE PRECISION)"
    return f"({text})"


def _powers(exponent: int) -> list[int]:
    whole, rest = divmod(exponent, LARGEST)
    return [2**LARGEST] * whole + ([2**rest] if rest else [])
