"""A fitted tree for people: words, a figure, a page, and the picture below scikit-learn's diagram in a notebook."""

from html import escape
from typing import TYPE_CHECKING

from octmip.certificate import certify
from octmip.estimator.notebook import MOST_LEAVES, notebook_html, tree_svg
from octmip.formats.columns import Columns
from octmip.formats.files import PathLike, check_writable, write_bytes
from octmip.formats.names import shown
from octmip.formats.table.preparation import Preparation
from octmip.formats.tree_file import leaf_counts, record_tree
from octmip.problem import Problem
from octmip.report.text import condition, tree_text
from octmip.solution import Solution
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, leaves

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE_SECONDS = 5.0
"""Time for the trees of lower depth on a page [s]."""


def words_of(problem: Problem, tree: Node, columns: Columns) -> str:
    """Return a tree as indented lines, with the training samples of each leaf."""
    counts = leaf_counts(problem, tree)
    return tree_text(tree, problem.feature_names, problem.class_names, counts, _encoded(columns))


def _encoded(columns: Columns) -> Columns | None:
    """Return the columns where they were encoded: a question is then said of them, and else of the features."""
    return None if columns.is_plain else columns


def notebook_picture(problem: Problem, solution: Solution, columns: Columns) -> str:
    """Return the tree and its proof as HTML for the cell of a notebook."""
    assert solution.tree is not None
    rows = iter(leaf_counts(problem, solution.tree).tolist())
    encoded = _encoded(columns)

    def question(split: Split | HyperplaneSplit) -> str:
        return condition(split, problem.feature_names, encoded)

    def decision(leaf: Leaf) -> str:
        counts = next(rows)
        wrong = sum(counts) - counts[leaf.label]
        return f"{shown(problem.class_names[leaf.label])}\n{sum(counts)}" + (f", {wrong} wrong" if wrong else "")

    if len(leaves(solution.tree)) > MOST_LEAVES:
        picture = f"<pre>{escape(words_of(problem, solution.tree, columns))}</pre>"
    else:
        picture = tree_svg(solution.tree, question, decision)
    errors = certify(problem, solution).errors
    claim = str(solution).splitlines()[0]
    return notebook_html(picture, f"{errors} of {problem.n_samples} training samples wrong; {claim}")


def figure_of(problem: Problem, tree: Node, columns: Columns, title: str | None) -> "Figure":
    """Return the drawing of a tree.

    Raises
    ------
    MissingExtraError
        matplotlib is not installed.
    """
    from octmip.plot import tree_figure  # needs the extra "report", which fitting does not

    return tree_figure(problem, tree, title, _encoded(columns))


def write_page(path: PathLike, problem: Problem, solution: Solution, columns: Columns, title: str) -> None:
    """Write the page about a tree, an HTML file that is whole in itself.

    Raises
    ------
    MissingExtraError
        what draws the page is not installed.
    DataError
        the file cannot be written.
    """
    from octmip.report.html import tree_page
    from octmip.report.tree.evidence import gather

    check_writable(path)
    file = record_tree(problem, solution, preparation=Preparation(columns))
    evidence = gather(file, problem, seconds=PAGE_SECONDS)
    write_bytes(path, tree_page(file, None, evidence, title=title).encode())
