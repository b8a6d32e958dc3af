"""Results on their way out: one JSON object, a progress line, what was found in a sentence."""

import contextlib
import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import TracebackType
from typing import Any

from octmip.formats.tree_file import finite_or_none
from octmip.input.names import visible
from octmip.interfaces.report.new_rows import counts_errors
from octmip.interfaces.report.text import number, percent, progress_words
from octmip.trees.answer.certificate import Certificate
from octmip.trees.answer.interruption import held_back
from octmip.trees.answer.scope import limits_in_words
from octmip.trees.answer.solution import Progress, Solution
from octmip.trees.nodes.tree_nodes import encode_tree
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff import Comparison, Score
from octmip.trees.tradeoff.held_out import mean_of_known, recall_precision

INTERVAL = 0.1  # seconds between two progress lines
MOST_CLASSES = 30  # of which a score has the table of confusions


def print_json(content: Mapping[str, Any]) -> None:
    """Print one JSON object on standard output; numbers that JSON lacks must be None by now."""
    print(json.dumps(content, allow_nan=False))


@contextlib.contextmanager
def then_written(
    path: str | None, write: Callable[[str], None], last: str = "", *, is_quiet: bool = False
) -> Iterator[None]:
    """Write a file once the result is shown inside, so that a failure of either loses neither.

    Parameters
    ----------
    path
        of the file; None where none is asked for.
    write
        writes it.
    last
        the last line that is shown, behind the note of what was written.
    is_quiet
        nothing but the result is shown, as with --json.
    """
    with held_back():
        try:
            yield
            sys.stdout.flush()
        finally:
            try:
                if path:
                    write(path)
                    if not is_quiet:
                        print(f"written to {visible(path)}")
            finally:
                if last and not is_quiet:
                    print(last)
                sys.stdout.flush()


def print_notes(notes: Sequence[str]) -> None:
    """Print what became of the table, a line each, and a blank line behind."""
    for note in notes:
        print(f"note: {visible(note)}")
    if notes:
        print()


def printable(text: str) -> str:
    """Return a text without what a terminal would obey: names come from files, and files from strangers."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def rounded(value: float | None) -> float | None:
    """Return a figure of a printed table to six digits; whole numbers stay whole."""
    return value if value is None or isinstance(value, int) else float(f"{value:.6g}")


def describe(problem: Problem, solution: Solution, certificate: Certificate) -> dict[str, Any]:
    """Return the JSON object of a solution: bound and gap are None without a proof."""
    samples = problem.samples
    return {
        "objective": solution.objective,
        "loss": problem.loss.spelling,
        "class_order": list(samples.class_order) if problem.shape.monotone is not None else None,
        **certificate.measures,
        "n_samples": samples.n_samples,
        "n_missing": samples.n_missing,
        "bound": finite_or_none(solution.bound),
        "gap": finite_or_none(solution.gap),
        "is_optimal": solution.is_optimal,
        "scope": certificate.scope,
        "scope_is_whole": not solution.scope,
        "stop": str(solution.stop),
        "seconds": solution.seconds,
        "n_nodes": solution.n_nodes,
        "method": solution.solver,
        "version": solution.version,
        "seed": solution.seed,
        "depth": certificate.depth,
        "n_splits": certificate.n_splits,
        "sensors": list(certificate.sensors),
        "sensor_cost": certificate.sensor_cost,
        "baseline": problem.baseline,
        "normalised_objective": finite_or_none(certificate.normalised_objective),
        "alpha": problem.shape.leaf_penalty / problem.baseline if problem.baseline > 0 else None,
        "tolerance": solution.tolerance,
        "details": dict(solution.details),
        "tree": encode_tree(solution.tree, samples.feature_names, samples.class_names),
    }


def verdict(problem: Problem, solution: Solution, certificate: Certificate) -> str:
    """Return what is known of a tree in one sentence, for the last line on the screen."""
    wrong = problem.loss.short_words_of(certificate.measures, problem.samples.n_samples)
    trees, counts = _trees(problem, solution), _counts_errors(problem)
    if solution.meets_bound:
        no_better = "makes fewer errors" if counts else f"has an objective below {number(solution.bound)}"
        return f"In training, proven optimal: {wrong}; no {trees} {no_better}."
    if math.isinf(solution.bound):
        who = f"the method {visible(solution.solver)} proves nothing about other trees"
        return f"In training, not proven optimal: {wrong}; {who}."
    least = number(solution.bound)
    bound = f"makes {least} errors or more" if counts else f"has an objective of {least} or more"
    why = f"stop: {solution.stop}, gap {percent(solution.gap)}"
    return f"In training, not proven optimal ({why}): {wrong}; every {trees} {bound}."


def _trees(problem: Problem, solution: Solution) -> str:
    """Return the trees that a bound holds for, in words that follow "no" and "every"."""
    scope = solution.scope
    trees = f"tree among {visible(scope)}" if scope else f"tree {limits_in_words(problem)}"
    return f"{trees}," if "," in trees else trees


def _counts_errors(problem: Problem) -> bool:
    """Whether the objective is the number of wrong samples."""
    return problem.shape.leaf_penalty == 0 and counts_errors(problem)


def comparison_text(problem: Problem, found: Comparison) -> str:
    """Return errors on training and held-out samples, of a tree and of CART beside it, as a small table."""
    assert found.held_out is not None
    head = ("", f"{found.training.n_samples} training samples", f"{found.held_out.n_samples} held out")
    rows = [head]
    for name, train, held in (
        ("this tree", found.training, found.held_out),
        ("CART", found.cart_training, found.cart_held_out),
    ):
        assert held is not None
        rows.append((name, _score_text(problem, train), _score_text(problem, held)))
    widths = [max(len(row[k]) for row in rows) for k in range(3)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def _score_text(problem: Problem, score: Score) -> str:
    if problem.loss.predicts == "number":
        return problem.loss.short_words_of(score.measures, score.n_samples)
    cost = "" if _counts_errors(problem) else f", cost {number(score.cost)}"
    return f"{score.errors} wrong ({percent(score.error_rate)}){cost}"


def score_json(score: Score | None) -> dict[str, Any] | None:
    """Return a score as a JSON object, None without one; figures of classes in the order of the confusion."""
    if score is None:
        return None
    found = {"n_samples": score.n_samples, **score.measures, "cost": score.cost}
    if score.confusion is None or len(score.confusion) > MOST_CLASSES:
        return found
    recall, precision = recall_precision(score.confusion)
    auroc = score.rank and score.rank().auroc
    by_class = {"recall": recall, "precision": precision} | ({} if auroc is None else {"auroc": auroc})
    return found | {
        "balanced_accuracy": score.balanced_accuracy,
        "mean_auroc": None if auroc is None else finite_or_none(mean_of_known(auroc)),
        "confusion": score.confusion.tolist(),
        **{name: [finite_or_none(value) for value in values.tolist()] for name, values in by_class.items()},
    }


def comparison_json(found: Comparison) -> dict[str, Any]:
    """Return the entries `training`, `held_out`, `cart` and `difference` of a JSON object."""
    cart = {"training": score_json(found.cart_training), "held_out": score_json(found.cart_held_out)}
    own = {"training": score_json(found.training), "held_out": score_json(found.held_out)}
    return own | {"cart": cart, "difference": found.difference and found.difference.to_json()}


class ProgressLine:
    """One line on a terminal that says how far a solver is; nothing where standard error is no terminal."""

    def __init__(self, prefix: str = "") -> None:
        self._prefix = prefix
        self._shown_at = -INTERVAL
        self._is_shown = False
        self._is_terminal = sys.stderr.isatty()

    def __enter__(self) -> "ProgressLine":
        return self

    def __call__(self, state: Progress) -> None:
        """Show a state of the solver."""
        if not self._is_terminal or time.monotonic() - self._shown_at < INTERVAL:
            return
        self._shown_at = time.monotonic()
        self._is_shown = True
        print(f"\r\x1b[2K{self._prefix}{progress_words(state)}", end="", file=sys.stderr, flush=True)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._is_shown:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)
