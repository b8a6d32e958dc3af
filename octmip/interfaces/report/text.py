"""A tree in words, and a solution in three lines."""

import math
from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from octmip.formats.columns import Columns
from octmip.input.names import shown, visible
from octmip.trees.answer.certificate import Certificate
from octmip.trees.answer.solution import Progress, Solution, relative_gap
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, ValueLeaf, prediction, tree_lines
from octmip.trees.nodes.tree import condition as named_condition
from octmip.trees.question.classes import words_of_order
from octmip.trees.question.problem import Problem


def condition(split: Split | HyperplaneSplit, feature_names: Sequence[str], columns: Columns | None = None) -> str:
    """Return the condition for going left on one line.

    With `columns` it is said of the columns that the features were made from: "colour is not red" instead of
    "colour is red <= 0.5".
    """
    if columns is None:
        return named_condition(split, lambda feature: shown(feature_names[feature]))
    if isinstance(split, Split):
        return visible(columns.left_words(split))
    return named_condition(split, lambda feature: f"[{shown(feature_names[feature])}]")


def tree_text(
    tree: Node,
    feature_names: Sequence[str],
    class_names: Sequence[Any],
    counts: NDArray[Any] | None = None,
    columns: Columns | None = None,
) -> str:
    """Return a tree as indented lines, with the training samples of each leaf where `counts` are given.

    `columns` puts the conditions in words of the table that the features were made from, where these are no plain
    numbers. `counts` are those of `octmip.trees.answer.certificate.leaf_counts`, leaves from the left.
    """
    rows = iter([] if counts is None else counts.tolist())
    columns = None if columns is None or columns.is_plain else columns

    def decision(leaf: Leaf) -> str:
        return f"{leaf_text(leaf, feature_names, class_names)}{leaf_note(next(rows, None), leaf.label)}"

    return "\n".join(tree_lines(tree, lambda split: condition(split, feature_names, columns), decision))


def leaf_text(leaf: Leaf, feature_names: Sequence[str], class_names: Sequence[Any]) -> str:
    """Return what a leaf predicts on one line: the name of its class, or a number."""
    if isinstance(leaf, ValueLeaf):
        return prediction(leaf, lambda j: shown(feature_names[j]))
    return shown(class_names[leaf.label])


def leaf_note(counts: list[int] | None, label: int) -> str:
    """Return the samples of a leaf and how many of them are wrong, nothing where they are unknown."""
    if counts is None:
        return ""
    total, wrong = sum(counts), sum(counts) - counts[label]
    samples = f"{total} sample{'s' * (total != 1)}"
    return f"    ({samples}, {wrong} wrong)" if wrong else f"    ({samples})"


def number(value: float | None) -> str:
    """Return a number in at most six digits; a dash for what is unknown or infinite."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.6g}"


def percent(share: float) -> str:
    """Return a share as percent; a dash where it is infinite."""
    return f"{100 * share:.3g} %" if math.isfinite(share) else "-"


def solution_text(problem: Problem, solution: Solution, certificate: Certificate) -> str:
    """Return what a solution claims and its certificate found, in three lines."""
    loss, is_number = problem.loss, problem.loss.predicts == "number"
    proof = "proven optimal" if solution.meets_bound else f"gap {percent(solution.gap)}"
    if math.isinf(solution.bound):
        proof = "no proof"
    elif scope := visible(solution.scope):
        proof += f" among {scope}"
    elif is_number and solution.tolerance > 0:
        proof += f" within {solution.tolerance:.1g}"
    proof += f" ({loss.words})" if is_number else ""
    splits = f"{certificate.n_splits} split" + ("" if certificate.n_splits == 1 else "s")
    sensors = f"sensors {', '.join(map(shown, certificate.sensors))}" if certificate.sensors else "no sensor"
    measured = loss.words_of(certificate.measures, problem.samples.n_samples)
    order = (
        f"{visible(words_of_order(problem.samples.class_order))}\n"
        if problem.shape.monotone is not None and not is_number
        else ""
    )
    return (
        f"objective {number(solution.objective)}, bound {number(solution.bound)}: {proof}\n"
        f"in training {measured}; depth {certificate.depth}, {splits}, {sensors}\n{order}"
        f"{visible(solution.solver)} {visible(solution.version)}, {solution.seconds:.3g} s, stop: {solution.stop}"
    )


def progress_words(state: Progress) -> str:
    """Return how far a solver is, on one line."""
    gap = percent(relative_gap(state.objective, state.bound))
    known = f"objective {number(state.objective)}  bound {number(state.bound)}  gap {gap}"
    return f"{state.seconds:.1f} s  {known}  nodes {state.n_nodes}"
