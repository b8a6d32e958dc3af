"""A tree as one C function without memory, loops or libraries: for the smallest processor.

Numbers are hexadecimal (C99), so no bit is lost in reading them. Products go through a volatile double, because a
compiler may otherwise fuse multiplication and addition into one rounding, and the answer could then differ.
"""

import re
from collections.abc import Sequence
from typing import Any

from octmip.errors import TreeError
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, splits


def c_source(tree: Node, feature_names: Sequence[str], class_names: Sequence[Any], name: str = "octmip_label") -> str:
    """Return the source of ``int name(const double reading[])``, C99.

    Raises:
        TreeError: `name` is no C name.
    """
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        raise TreeError(f"function name {name!r} is no C name; expected letters, digits and _, no digit first")
    lines = [f"/* reading: {', '.join(f'[{j}] {_plain(f)}' for j, f in enumerate(feature_names))}"]
    lines += [f"   answer {k}: {_plain(c)}" for k, c in enumerate(class_names)]
    lines += ["   answer -1: no number where the tree asks for one */", f"int {name}(const double *reading)", "{"]
    if any(isinstance(split, HyperplaneSplit) for split in splits(tree)):
        lines.append("    volatile double product, total;")
    return "\n".join([*lines, *_statements(tree, "    "), "}"]) + "\n"


def _plain(name: Any) -> str:
    return re.sub(r"[^ -~]|\*/|\\", "?", str(name))


def _statements(node: Node, indent: str) -> list[str]:
    if isinstance(node, Leaf):
        return [f"{indent}return {node.label};"]
    asked, threshold, before = f"reading[{node.features[0]}]", "", []
    if isinstance(node, Split):
        threshold = node.threshold.hex()
    else:
        asked, threshold, before = "total", node.offset.hex(), _total(node, indent)
    return [
        *before,
        f"{indent}if ({asked} <= {threshold}) {{",
        *_statements(node.left, indent + "    "),
        f"{indent}}} else if ({asked} > {threshold}) {{",
        *_statements(node.right, indent + "    "),
        f"{indent}}} else {{",
        f"{indent}    return -1;",
        f"{indent}}}",
    ]


def _total(split: HyperplaneSplit, indent: str) -> list[str]:
    lines = [f"{indent}total = 0.0;"]
    for feature, coefficient in zip(split.features, split.coefficients, strict=True):
        lines += [f"{indent}product = {coefficient.hex()} * reading[{feature}];", f"{indent}total = total + product;"]
    return lines
