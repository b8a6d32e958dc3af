"""Show a tree file in words on standard output, or write it as a file of the kind that its ending names.

.html  a self-contained page    .md  Markdown    .dot  Graphviz    .txt  words    .svg .png .pdf  a drawing
"""

import argparse
import io
from pathlib import Path

from octmip.cli.answer import printable
from octmip.errors import DataError
from octmip.formats.files import check_writable, write_bytes
from octmip.formats.names import visible
from octmip.formats.tree_file import TreeFile, read_tree_file
from octmip.report.dot import tree_dot
from octmip.report.markdown import code_block, markdown_table
from octmip.report.text import number, percent, tree_text

KINDS = (".html", ".md", ".dot", ".txt", ".svg", ".png", ".pdf")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip report`."""
    parser.add_argument("tree", metavar="TREE.json", help="tree file of octmip solve --out")
    parser.add_argument("--out", metavar="FILE", help=f"one of {', '.join(KINDS)} (default: words on standard output)")


def run(arguments: argparse.Namespace) -> int:
    """Write the report."""
    kind = Path(arguments.out).suffix if arguments.out else ".txt"
    if kind not in KINDS:
        raise DataError(f"--out {arguments.out} ends with {kind!r}; expected one of {', '.join(KINDS)}")
    if arguments.out:
        check_writable(arguments.out)
    file = read_tree_file(arguments.tree)
    if not arguments.out:
        print(printable(_words(file)))
        return 0
    write_bytes(arguments.out, _content(file, kind, Path(arguments.tree).name))
    return 0


def _content(file: TreeFile, kind: str, source: str) -> bytes:
    if kind in (".svg", ".png", ".pdf"):
        from octmip.plot import counted_tree_figure  # needs the extra "report", which words do not

        buffer = io.BytesIO()
        figure = counted_tree_figure(file.tree, file.leaf_counts, file.feature_names, file.class_names)
        figure.savefig(buffer, format=kind[1:], dpi=150)
        return buffer.getvalue()
    if kind == ".html":
        from octmip.report.html import tree_page

        return tree_page(file, source).encode()
    if kind == ".dot":
        return (tree_dot(file.tree, file.feature_names, file.class_names) + "\n").encode()
    return ((_markdown(file) if kind == ".md" else _words(file)) + "\n").encode()


def _words(file: TreeFile) -> str:
    solution = file.solution
    claim = f"objective {number(solution.objective)}, bound {number(solution.bound)}, gap {percent(solution.gap)}"
    tree = tree_text(file.tree, file.feature_names, file.class_names, file.leaf_counts)
    return f"{claim} ({visible(solution.solver)}, stop: {solution.stop})\n\n{tree}"


def _markdown(file: TreeFile) -> str:
    solution = file.solution
    row = {
        "objective": solution.objective,
        "bound": number(solution.bound),
        "gap": percent(solution.gap),
        "stop": str(solution.stop),
        "solver": solution.solver,
        "seconds": solution.seconds,
    }
    tree = tree_text(file.tree, file.feature_names, file.class_names, file.leaf_counts)
    return f"{markdown_table([row])}\n\n{code_block(tree)}"
