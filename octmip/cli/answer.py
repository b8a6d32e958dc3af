"""Results on their way out: one JSON object, a progress line, rows of numbers."""

import json
import sys
import time
from collections.abc import Mapping
from types import TracebackType
from typing import Any

from octmip.certificate import Certificate
from octmip.formats.tree_file import finite_or_none
from octmip.formats.tree_nodes import encode_tree
from octmip.problem import Problem
from octmip.report.text import number, percent
from octmip.solution import Progress, Solution, relative_gap

INTERVAL = 0.1  # seconds between two progress lines


def print_json(content: Mapping[str, Any]) -> None:
    """Print one JSON object on standard output; numbers that JSON lacks must be None by now."""
    print(json.dumps(content, allow_nan=False))


def printable(text: str) -> str:
    """Return a text without what a terminal would obey: names come from files, and files from strangers."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def describe(problem: Problem, solution: Solution, certificate: Certificate) -> dict[str, Any]:
    """Return the JSON object of a solution: bound and gap are None without a proof."""
    assert solution.tree is not None
    return {
        "objective": solution.objective,
        "errors": certificate.errors,
        "n_samples": problem.n_samples,
        "bound": finite_or_none(solution.bound),
        "gap": finite_or_none(solution.gap),
        "is_optimal": solution.is_optimal,
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
        "alpha": problem.leaf_penalty / problem.baseline if problem.baseline > 0 else None,
        "tolerance": solution.tolerance,
        "details": dict(solution.details),
        "tree": encode_tree(solution.tree, problem.feature_names, problem.class_names),
    }


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
        gap = percent(relative_gap(state.objective, state.bound))
        line = (
            f"{self._prefix}{state.seconds:.1f} s  objective {number(state.objective)}  bound {number(state.bound)}  "
            f"gap {gap}  nodes {state.n_nodes}"
        )
        print(f"\r\x1b[2K{line}", end="", file=sys.stderr, flush=True)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._is_shown:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)
