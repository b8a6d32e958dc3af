"""Evaluations and CPU seconds of the exact proof with each prune off: which of them users would miss.

Each case runs with all prunes and then without one at a time, by `branch_and_bound` with no tree to start from. A run
ends at three times the CPU seconds of the whole search.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from benchmarks.cpu import Stopwatch, cpu_limit
from benchmarks.data import Table, published, uci
from benchmarks.tables import Line, markdown
from octmip.trees import _native
from octmip.trees.losses import ClassCosts
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.native_call import without
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution

LARGE = 250_000
WHOLE = "all prunes"
SLOWEST = 3.0
"""A run is stopped at so many times the CPU seconds of the whole search, and half a second more."""
REPEATS = 3
SHORT = 0.3
"""Runs of a case under so many CPU seconds; the least counts."""


def _errors(table: Table, depth: int) -> Problem:
    return Problem(table.features, table.labels, depth=depth)


def _distances(table: Table, depth: int) -> Problem:
    at = np.arange(len(set(table.labels)))
    return Problem(table.features, table.labels, depth=depth, loss=ClassCosts(abs(np.subtract.outer(at, at))))


def _long() -> Problem:
    """Return normal features with classes by a tree of two levels, a tenth of the labels wrong."""
    random = np.random.default_rng(0)
    x = random.normal(size=(LARGE, 10))
    inside = np.where(x[:, 0] > 0.3, x[:, 1] > -0.5, x[:, 2] > 0)
    return Problem(x, inside ^ (random.random(LARGE) < 0.1), depth=2)


def _priced(table: Table, price: float) -> Problem:
    return Problem(table.features, table.labels, leaf_penalty=price * len(table.labels))


CASES: dict[str, Callable[[], Problem]] = {
    "mu1, depth 3": lambda: _errors(published("mu1", 0), 3),
    "mu1, depth 4": lambda: _errors(published("mu1", 0), 4),
    "mu2, depth 3": lambda: _errors(published("mu2", 0), 3),
    "mu1, depth 3, distances": lambda: _distances(published("mu1", 0), 3),
    "ct-wilt, depth 4": lambda: _errors(uci("ct-wilt"), 4),
    "contraceptive-method-choice, depth 4": lambda: _errors(uci("contraceptive-method-choice"), 4),
    "skin-segmentation, depth 3": lambda: _errors(uci("skin-segmentation"), 3),
    "mammographic-mass, depth 4": lambda: _errors(uci("mammographic-mass"), 4),
    "breast cancer, price 0.03": lambda: _priced(uci("breast-cancer-wisconsin-diagnostic"), 0.03),
    "250,000 rows, a tree, depth 2": _long,
}


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield a line for each case and prune; `only`: of these prunes, such as slack,kept."""
    chosen = only.split(",") if only else _native.prunes()
    for case, build in CASES.items():
        problem = build()
        whole, seconds = _timed(problem, limit)
        yield _line(case, WHOLE, whole, seconds)
        for prune in chosen:
            with without(prune):
                found, taken = _timed(problem, min(limit, SLOWEST * seconds + 0.5))
            assert not found.is_optimal or found.objective == whole.objective, f"{case} without {prune}"
            yield _line(case, prune, found, taken)


def _line(case: str, prune: str, found: Solution, seconds: float) -> Line:
    return {
        "size": case,
        "seed": 0,
        "without": prune,
        "outcome": "proven" if found.is_optimal else "not proven",
        "objective": found.objective,
        "bound": found.bound,
        "evaluations": found.n_nodes,
        "cpu_seconds": round(seconds, 4),
    }


def _timed(problem: Problem, limit: float) -> tuple[Solution, float]:
    """Return the solution, and the least CPU seconds of its runs."""
    taken: list[float] = []
    while not taken or (len(taken) < REPEATS and taken[0] < SHORT):
        watch = Stopwatch()
        solution = branch_and_bound(problem, **cpu_limit(limit))
        taken.append(watch.read()[0])
    return solution, min(taken)


def summary(lines: Sequence[Line]) -> str:
    """Return a row for each case and prune: evaluations and CPU seconds, and both beside the whole search."""
    whole = {line["size"]: line for line in lines if line["without"] == WHOLE}
    rows = []
    for line in lines:
        times = [line[key] / max(whole[line["size"]][key], 1e-4) for key in ("evaluations", "cpu_seconds")]
        cells = [line[key] for key in ("size", "without", "outcome", "evaluations")]
        rows.append([*cells, f"{times[0]:.2f}", f"{line['cpu_seconds']:.3g}", f"{times[1]:.2f}"])
    return markdown(["case", "without", "outcome", "evaluations", "times", "CPU s", "times the CPU s"], rows)
