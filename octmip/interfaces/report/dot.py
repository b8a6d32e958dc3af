"""A tree in the DOT language of Graphviz."""

from collections.abc import Sequence
from typing import Any

from octmip.formats.columns import Columns
from octmip.interfaces.report.text import condition, leaf_text
from octmip.trees.tree import Leaf, Node

LONGEST_LINE = 100
"""Characters in one line of a label: Graphviz draws no edge past a node that is 65,535 points wide, so labels wrap."""


def tree_dot(
    tree: Node, feature_names: Sequence[str], class_names: Sequence[Any], columns: Columns | None = None
) -> str:
    """Return a tree as a DOT digraph: boxes for splits, ellipses for leaves, yes to the left.

    `columns` are how the columns of a table became the features, None where they are the features.
    """
    lines: list[str] = []

    def add(node: Node) -> int:
        index = len(lines)
        lines.append("")
        if isinstance(node, Leaf):
            lines[index] = f"  n{index} [label={_quoted(leaf_text(node, feature_names, class_names))}, shape=ellipse];"
            return index
        left, right = add(node.left), add(node.right)
        lines[index] = (
            f"  n{index} [label={_quoted(condition(node, feature_names, columns))}];\n"
            f'  n{index} -> n{left} [label="yes"];\n'
            f'  n{index} -> n{right} [label="no"];'
        )
        return index

    add(tree)
    return "\n".join(["digraph tree {", "  node [shape=box];", *lines, "}"])


def _quoted(text: str) -> str:
    r"""Return a label that is drawn as it stands: no escape of Graphviz (``\\N``, ``\\l``), no entity (``&lt;``)."""
    lines = [text[k : k + LONGEST_LINE] for k in range(0, len(text), LONGEST_LINE)]
    escaped = [p.replace("&", "&amp;").replace("\\", "\\\\").replace('"', '\\"') for p in lines]
    return '\\n" + "'.join(escaped).join('""')  # a sum of strings: no single one may have more than 16,384 bytes
