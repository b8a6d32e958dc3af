"""A fitted tree for people: words, a figure, a page, and the picture below scikit-learn's diagram in a notebook."""

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING

from octmip.certificate import certify
from octmip.estimator.notebook import MOST_LEAVES, notebook_html, tree_svg
from octmip.formats.columns import Columns
from octmip.formats.files import PathLike, check_writable, write_bytes
from octmip.formats.names import shown
from octmip.formats.tree_file import leaf_counts, record_tree
from octmip.problem import Problem
from octmip.report.text import condition, leaf_note
from octmip.solution import Solution
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, leaves, tree_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure


Question = Callable[[Split | HyperplaneSplit], str]


def question_words(problem: Problem, columns: Columns) -> Question:
    """Return what says the condition for going left at a split, in the words of the columns of X."""

    def question(split: Split | HyperplaneSplit) -> str:
        if isinstance(split, Split):
            return shown(columns.left_words(split.feature, split.threshold))
        return condition(split, problem.feature_names)

    return question


def words_of(problem: Problem, tree: Node, columns: Columns) -> str:
    """Return a tree as indented lines, with the training samples of each leaf."""
    rows = iter(leaf_counts(problem, tree).tolist())

    def decision(leaf: Leaf) -> str:
        return f"{shown(problem.class_names[leaf.label])}{leaf_note(next(rows), leaf.label)}"

    return "\n".join(tree_lines(tree, question_words(problem, columns), decision))


def notebook_picture(problem: Problem, solution: Solution, columns: Columns) -> str:
    """Return the tree and its proof as HTML for the cell of a notebook."""
    assert solution.tree is not None
    rows = iter(leaf_counts(problem, solution.tree).tolist())

    def decision(leaf: Leaf) -> str:
        counts = next(rows)
        wrong = sum(counts) - counts[leaf.label]
        return f"{shown(problem.class_names[leaf.label])}\n{sum(counts)}" + (f", {wrong} wrong" if wrong else "")

    if len(leaves(solution.tree)) > MOST_LEAVES:
        picture = f"<pre>{escape(words_of(problem, solution.tree, columns))}</pre>"
    else:
        picture = tree_svg(solution.tree, question_words(problem, columns), decision)
    errors = certify(problem, solution).errors
    claim = str(solution).splitlines()[0]
    return notebook_html(picture, f"{errors} of {problem.n_samples} training samples wrong; {claim}")


def figure_of(problem: Problem, tree: Node, title: str | None) -> "Figure":
    """Return the drawing of a tree.

    Raises
    ------
    MissingExtraError
        matplotlib is not installed.
    """
    from octmip.plot import tree_figure  # needs the extra "report", which fitting does not

    return tree_figure(problem, tree, title)


def write_page(path: PathLike, problem: Problem, solution: Solution, title: str) -> None:
    """Write the page about a tree, an HTML file that is whole in itself.

    Raises
    ------
    MissingExtraError
        what draws the page is not installed.
    DataError
        the file cannot be written.
    """
    from octmip.report.html import tree_page

    check_writable(path)
    write_bytes(path, tree_page(record_tree(problem, solution), title).encode())
