"""A tree as one C function without memory, loops or libraries: for the smallest processor.

Numbers are hexadecimal (C99), so no bit is lost in reading them. Products go through a volatile double, because a
compiler may otherwise fuse multiplication and addition into one rounding, and the result could then differ.

No name of a feature or class is part of the source: a comment that held one could be ended by it, or go on after a
backslash (``names_json`` has the names).
"""

import re
from collections.abc import Sequence
from typing import Any

from octmip.errors import TreeError
from octmip.monitor.export.fit import check_fit
from octmip.trees.tree import SIDES, HyperplaneSplit, Leaf, Node, Split, splits

KEYWORDS = frozenset(
    [
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
        "bool",
        "true",
        "false",
        "nullptr",
        "class",
        "new",
        "delete",
        "this",
        "template",
        "typename",
        "namespace",
        "using",
        "try",
        "catch",
        "throw",
        "operator",
    ]
)
"""Of C, and those of C++ that a header would meet."""


def c_source(tree: Node, feature_names: Sequence[str], class_names: Sequence[Any], name: str = "octmip_label") -> str:
    """Return the source of ``int name(const double reading[])``, C99.

    A reading holds the features in the order of `feature_names`; the result is an index of `class_names`, or -1.

    Raises
    ------
    TreeError
        `name` is no C name, or the names do not cover the tree.
    """
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) or name in KEYWORDS:
        raise TreeError(
            f"function name {name!r} is no C name; expected letters, digits and _, no digit first and no word of the "
            "language; choose another"
        )
    check_fit(tree, feature_names, class_names)
    features, classes = len(feature_names), len(class_names)
    lines = [f"/* {features} features, reading[0] to reading[{features - 1}]; answers 0 to {classes - 1},"]
    lines += ["   or -1: no number where the tree asks for one */", f"int {name}(const double *reading)", "{"]
    if any(isinstance(split, HyperplaneSplit) for split in splits(tree)):
        lines.append("    volatile double product, total;")
    if isinstance(tree, Leaf):
        lines.append("    (void)reading;")
    return "\n".join([*lines, *_statements(tree, "    "), "}"]) + "\n"


def _statements(node: Node, indent: str) -> list[str]:
    if isinstance(node, Leaf):
        return [f"{indent}return {node.label};"]
    left, right = _conditions(node)
    return [
        *(_total(node, indent) if isinstance(node, HyperplaneSplit) else []),
        f"{indent}if ({left}) {{",
        *_statements(node.left, indent + "    "),
        f"{indent}}} else if ({right}) {{",
        *_statements(node.right, indent + "    "),
        f"{indent}}} else {{",
        f"{indent}    return -1;",
        f"{indent}}}",
    ]


def _conditions(split: Split | HyperplaneSplit) -> tuple[str, str]:
    """Return when a reading goes left and when it goes right; what is missing differs from itself."""
    missing = " || ".join(f"reading[{j}] != reading[{j}]" for j in split.features)
    if isinstance(split, Split) and split.threshold is None:
        present = missing.replace("!=", "==")
        return (missing, present) if split.missing == "left" else (present, missing)
    asked = f"reading[{split.feature}]" if isinstance(split, Split) else "total"
    given = split.threshold if isinstance(split, Split) else split.offset
    assert given is not None
    threshold = float(given).hex()
    lost = {side: f" || {missing}" if split.missing == side else "" for side in SIDES}
    if isinstance(split, HyperplaneSplit):  # a sum that is no number goes right, where no reading is missing
        present = "1" if split.missing else missing.replace("!=", "==").replace("||", "&&")
        return f"{asked} <= {threshold}{lost['left']}", present
    return f"{asked} <= {threshold}{lost['left']}", f"{asked} > {threshold}{lost['right']}"


def _total(split: HyperplaneSplit, indent: str) -> list[str]:
    lines = [f"{indent}total = 0.0;"]
    for feature, coefficient in zip(split.features, split.coefficients, strict=True):
        factor = float(coefficient).hex()
        lines += [f"{indent}product = {factor} * reading[{feature}];", f"{indent}total = total + product;"]
    return lines
