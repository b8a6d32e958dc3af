"""A fitted tree for people: words, a figure, a page, and the picture below scikit-learn's diagram in a notebook."""

from html import escape
from typing import TYPE_CHECKING

from octmip.formats.columns import Columns
from octmip.formats.files import PathLike, check_writable, write_bytes
from octmip.formats.tree_file import TreeFile, leaf_counts
from octmip.interfaces.estimator.notebook import MOST_LEAVES, drawing_svg, notebook_html
from octmip.interfaces.report.text import tree_text
from octmip.interfaces.report.tree.drawing import draw_tree
from octmip.interfaces.report.tree.words import Wording
from octmip.trees.certificate import certify
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution
from octmip.trees.tradeoff.held_out import Samples
from octmip.trees.tree import Node, leaves

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def words_of(problem: Problem, tree: Node, columns: Columns) -> str:
    """Return a tree as indented lines, with the training samples of each leaf."""
    counts = leaf_counts(problem, tree)
    return tree_text(tree, problem.feature_names, problem.class_names, counts, _encoded(columns))


def _encoded(columns: Columns) -> Columns | None:
    """Return the columns where they were encoded: a question is then said of them, and else of the features."""
    return None if columns.is_plain else columns


def notebook_picture(problem: Problem, solution: Solution, columns: Columns) -> str:
    """Return the tree and its proof as HTML for the cell of a notebook."""
    tree = solution.tree
    assert tree is not None
    if len(leaves(tree)) > MOST_LEAVES:
        picture = f"<pre>{escape(words_of(problem, tree, columns))}</pre>"
    else:
        wording = Wording(problem.feature_names, problem.class_names, _encoded(columns))
        picture = drawing_svg(draw_tree(tree, wording, leaf_counts(problem, tree)))
    good = problem.loss.words_of(certify(problem, solution).measures, problem.n_samples)
    claim = str(solution).splitlines()[0]
    return notebook_html(picture, f"training: {good}; {claim}")


def figure_of(problem: Problem, tree: Node, columns: Columns, title: str | None) -> "Figure":
    """Return the drawing of a tree.

    Raises
    ------
    MissingExtraError
        matplotlib is not installed.
    """
    from octmip.interfaces.plot import tree_figure  # needs the extra "plot", which fitting does not

    return tree_figure(problem, tree, title, _encoded(columns))


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
