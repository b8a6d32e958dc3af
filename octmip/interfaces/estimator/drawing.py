"""A fitted tree for people: words, a figure, a page, and the picture below scikit-learn's diagram in a notebook."""

from html import escape
from typing import TYPE_CHECKING, Any

from octmip.formats.columns import Columns
from octmip.formats.tree_file import TreeFile
from octmip.input.files import PathLike, check_writable, write_bytes
from octmip.interfaces.report.text import tree_text
from octmip.interfaces.report.tree.drawing import draw_tree
from octmip.interfaces.report.tree.seen import Seen
from octmip.interfaces.report.tree.svg import drawing_svg
from octmip.interfaces.report.tree.words import Wording
from octmip.trees.answer.certificate import certify, leaf_counts
from octmip.trees.answer.solution import Solution
from octmip.trees.nodes.tree import Node, leaves
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff.held_out import Samples

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_LEAVES = 64
"""With more leaves the picture in a notebook is too wide to be read, and the tree is shown as text."""


def words_of(problem: Problem, tree: Node, columns: Columns) -> str:
    """Return a tree as indented lines, with the training samples of each leaf."""
    counts = leaf_counts(problem, tree)
    return tree_text(tree, problem.samples.feature_names, problem.samples.class_names, counts, _encoded(columns))


def _encoded(columns: Columns) -> Columns | None:
    """Return the columns where they were encoded: a question is then said of them, and else of the features."""
    return None if columns.is_plain else columns


def notebook_picture(problem: Problem, solution: Solution, columns: Columns) -> str:
    """Return the tree and its proof as HTML for the cell of a notebook."""
    tree = solution.tree
    if len(leaves(tree)) > MOST_LEAVES:
        picture = f"<pre>{escape(words_of(problem, tree, columns))}</pre>"
    else:
        wording = Wording(problem.samples.feature_names, problem.samples.class_names, _encoded(columns))
        counts, seen = leaf_counts(problem, tree), Seen.of(problem, tree)
        picture = drawing_svg(draw_tree(tree, wording, counts, seen=seen))
    good = problem.loss.words_of(certify(problem, solution).measures, problem.samples.n_samples)
    claim = str(solution).splitlines()[0]
    below = f'<div style="margin-top:4px;font-family:sans-serif;font-size:13px">training: {good}; {escape(claim)}</div>'
    return f'<div style="overflow-x:auto;margin-top:8px">{picture}</div>{below}'


def figure_of(problem: Problem, tree: Node, columns: Columns, title: str | None, **shown: Any) -> "Figure":
    """Return the drawing of a tree; `shown` are further arguments of `octmip.interfaces.plot.tree_figure`.

    Raises
    ------
    MissingExtraError
        matplotlib is not installed.
    """
    from octmip.interfaces.plot import tree_figure  # needs the extra "plot", which fitting does not

    return tree_figure(problem, tree, title, _encoded(columns), **shown)


def write_page(path: PathLike, problem: Problem, file: TreeFile, held_out: Samples | None, seconds: float) -> None:
    """Write the page about a tree, an HTML file that is whole in itself.

    Parameters
    ----------
    path
        of the file.
    problem, file
        the training samples, and the tree with its claims.
    held_out
        samples that were not trained on; None without such.
    seconds
        for trees of lower depth, with which the page compares this one; 0 leaves them out.

    Raises
    ------
    DataError
        the file cannot be written.
    """
    from octmip.interfaces.report.html import tree_page
    from octmip.interfaces.report.tree.evidence import gather, judged_by

    check_writable(path)
    evidence = gather(file, problem, seconds=seconds)
    if held_out is not None:
        evidence = judged_by(evidence, file, held_out, "the test set")
    write_bytes(path, tree_page(file, evidence=evidence).encode())
