"""What holds on new rows, in words: how a tree was chosen, what it costs there, and what makes that doubtful."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from octmip.input.names import shown, visible
from octmip.trees.answer.solution import Solution
from octmip.trees.nodes.tree import Node, ValueLeaf, leaf_index, leaves
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff import Comparison

FEW_SAMPLES = 5
"""A leaf of fewer training samples says little about new rows."""


def choice_of(solution: Solution) -> Mapping[str, Any] | None:
    """Return how the tree was chosen where it was (`Choice.to_json`); None where a depth was asked for."""
    choice = solution.details.get("choice")
    return choice if isinstance(choice, Mapping) else None


def choice_text(problem: Problem, solution: Solution) -> str:
    """Return how a tree was chosen and what it costs on new rows, line by line; nothing where a depth was asked for."""
    choice = choice_of(solution)
    if choice is None:
        return ""
    if "reason" in choice:
        return f"not chosen: {visible(str(choice['reason']))}; depth {problem.shape.depth} instead"
    n_kinds = len(choice["families"])
    kinds = f"{n_kinds} kind{'' if n_kinds == 1 else 's'} of trees"
    folds = f"{choice['n_folds']} fold{'' if choice['n_folds'] == 1 else 's'}"
    lines = [
        f"chosen by cross-validation ({folds}, {kinds}): {visible(choice['kind'])}; "
        f"leaf penalty {problem.shape.leaf_penalty:.4g}"
    ]
    if choice["families_left_out"]:
        lines.append(f"the time left out {choice['families_left_out']} more of them; more --seconds try these too")
    if "n_rows" in choice:
        lines.append(
            f"chosen and grown on {choice['n_rows']:,} rows drawn at random, for the time given, and fitted to all; "
            "more --seconds, or --threads, use more"
        )
    if choice["expected"] is not None:
        expected = choice["expected"]
        lines.append(f"expected on new rows: {_interval(problem, expected['tree'])}")
        if expected["cart"] is not None:
            lines.append(f"CART pruned by the same folds: {_interval(problem, expected['cart'])}")
            lines.append(f"difference: {_interval(problem, expected['difference'], is_difference=True)}")
            lines.append("(95 % intervals by bootstrap: chosen again by the rows drawn, judged on the others)")
    return "\n".join(lines)


def expected_words(problem: Problem, solution: Solution) -> str:
    """Return what a chosen tree costs on new rows as a sentence with a blank behind, nothing where none was chosen."""
    expected = (choice_of(solution) or {}).get("expected")
    if not expected:
        return ""
    beside = "" if expected["cart"] is None else f", pruned CART {mean_cost(problem, expected['cart']['mean'])}"
    return f"Expected on new rows: {mean_cost(problem, expected['tree']['mean'])}{beside}. "


def held_out_words(problem: Problem, found: Comparison) -> str:
    """Return what a tree and CART lose on samples held out as a sentence with a blank behind; nothing without any."""
    if found.held_out is None or found.cart_held_out is None:
        return ""
    loss, n = problem.loss, found.held_out.n_samples
    own, cart = (loss.short_words_of(s.measures, n) for s in (found.held_out, found.cart_held_out))
    return f"On rows held out: {own}, CART {cart}. "


def difference_text(problem: Problem, found: Comparison) -> str:
    """Return the difference to CART on samples held out with its interval, on one line; nothing without samples."""
    if found.difference is None:
        return ""
    between = _interval(problem, found.difference.to_json(), is_difference=True)
    return f"difference to CART on rows held out, 95 % interval: {between}"


def counts_errors(problem: Problem) -> bool:
    """Whether a mean cost is a share of wrong rows."""
    is_zero_one = isinstance(problem.loss, ClassCosts) and problem.loss.is_zero_one
    return is_zero_one and bool((problem.samples.weights == 1).all())


def mean_cost(problem: Problem, cost: float) -> str:
    """Return a cost per unit of weight in words."""
    return f"{100 * cost:.3g} % wrong" if counts_errors(problem) else f"mean {problem.loss.words} {cost:.4g}"


def _interval(problem: Problem, found: Mapping[str, float], *, is_difference: bool = False) -> str:
    if counts_errors(problem):
        low, high = 100 * found["low"], 100 * found["high"]
        mean = f"{100 * found['mean']:+.2g} points" if is_difference else f"{100 * found['mean']:.3g} % wrong"
        sign = "+" if is_difference else ""
        return f"{mean} ({low:{sign}.2g} to {high:{sign}.2g})"
    mean = f"{found['mean']:+.4g}" if is_difference else mean_cost(problem, found["mean"])
    return f"{mean} ({found['low']:.4g} to {found['high']:.4g})"


def _one_answer(problem: Problem, tree: Node) -> tuple[str, str] | None:
    """Return what a tree answers for every row, and what may tell rows apart; None where it answers several things."""
    answers = {leaf.value if isinstance(leaf, ValueLeaf) else leaf.label for leaf in leaves(tree)}
    if len(answers) > 1 or any(isinstance(leaf, ValueLeaf) and leaf.features for leaf in leaves(tree)):
        return None
    if problem.loss.predicts == "class":
        cure = "where another class is rare or matters more, --class-weight balanced (or CLASS=WEIGHT) lets it count"
        return shown(problem.samples.class_names[int(answers.pop())]), cure
    other = "absolute" if problem.loss.name == "squared" else "squared"
    why = "a few far numbers may hide what splits are worth: " if other == "absolute" else ""
    return f"{answers.pop():.6g}", f"{why}try --loss {other}, or a --depth"


def warning_text(problem: Problem, tree: Node) -> str:
    """Return what makes a tree doubtful on new rows, a line each: one answer, small leaves, rows learned by heart."""
    if (answer := _one_answer(problem, tree)) is not None:
        return f"warning: the tree answers {answer[0]} for every row; {answer[1]}"
    sizes = np.bincount(leaf_index(tree, problem.samples.features), minlength=len(leaves(tree)))
    small = int((sizes < FEW_SAMPLES).sum())
    if not small:
        return ""
    lines = [f"warning: {small} of {len(sizes)} leaves hold fewer than {FEW_SAMPLES} training samples"]
    if 2 * small >= len(sizes) and len(sizes) > 4:
        lines.append(
            "warning: most leaves hold so few that the tree has learned rows by heart: training figures say nothing "
            "about new rows; try --holdout 0.25, or leave out --depth"
        )
    return "\n".join(lines)
