"""The price of an option: CPU seconds of a proof with it over those of the proof without, on public tables.

The options: a least number of samples in a leaf (2, 5, 20, or 1 % of the rows), the same with a budget of three
columns, one or two splits fewer than the depth has room for, two changes of CART's tree, and a proof log. Of numbers,
the first column of each table by the others: leaves of 5 and other errors over squared error. A proof that its limit
ends counts with the seconds at which it stopped.
"""

import re
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.cpu import Stopwatch, cpu_limit
from benchmarks.public_tables import ordered, samples
from benchmarks.tables import Line, markdown
from octmip.trees.answer.solution import Solution
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.losses import AbsoluteError, NumberLoss, QuantileError, SquaredError
from octmip.trees.question.problem import Problem, ShapeKeywords
from octmip.trees.solver import solve

SETTLED = ("pima-diabetes", "breast-cancer-wisconsin-diagnostic", "ct-wilt", "wine", "vertebral-column-3c", "spambase")
"""Tables that the search was looked at with."""
N_OTHERS = 20
DEPTHS = (2, 3)
SHORTEST = 0.005
"""CPU seconds of the least proof that is divided by: the clock's step, and what every call takes."""

OPTIONS: Mapping[str, Callable[[Problem], ShapeKeywords]] = {
    "leaf size 2": lambda _: {"leaf_size": 2},
    "leaf size 5": lambda _: {"leaf_size": 5},
    "leaf size 20": lambda _: {"leaf_size": 20},
    "leaf size 1 %": lambda free: {"leaf_size": max(1, free.samples.n_samples // 100)},
    "leaf size 5, budget of 3": lambda _: {"leaf_size": 5, "sensor_budget": 3},
    "one split fewer": lambda free: {"max_splits": 2**free.shape.depth - 2},
    "two splits fewer": lambda free: {"max_splits": 2**free.shape.depth - 3},
    "two changes": lambda free: {"old_tree": solve(free, "cart").tree, "max_changes": 2},
    "log": lambda _: {},
    "log, leaf size 5": lambda _: {"leaf_size": 5},
}
OF_NUMBERS: Mapping[str, tuple[NumberLoss, ShapeKeywords]] = {
    "squared, leaf size 5": (SquaredError(), {"leaf_size": 5}),
    "absolute": (AbsoluteError(), {}),
    "0.9 quantile": (QuantileError(0.9), {}),
}


def tables() -> list[str]:
    """Return the tables in their order: those that the search was looked at with, and the smallest of the others."""
    return [*SETTLED, *(name for name, _ in ordered() if name not in SETTLED)][: len(SETTLED) + N_OTHERS]


def results(limit: float, threads: Sequence[int], names: Sequence[str] = (), only: str = "") -> Iterator[Line]:
    """Yield a line for each table, depth and option; an option of a table that is not proven without it is left out."""
    rows, halves = np.arange(4.0)[:, np.newaxis], np.array([0, 0, 1, 1])
    for problem in (Problem(rows, halves, depth=2), Problem(rows, halves, depth=2, loss=SquaredError())):
        proof(problem, limit)  # what is loaded at a first call is no price
    for name in names or tables():
        features, classes = samples(name)
        labels = np.unique(classes, return_inverse=True)[1]
        of_classes = {option: asked for option, asked in OPTIONS.items() if re.search(only, option)}
        of_numbers = {option: asked for option, asked in OF_NUMBERS.items() if re.search(only, option)}
        columns, targets = features[:, 1:], features[:, 0]
        if np.isnan(features).any():
            of_numbers = {}  # proofs for numbers take no missing readings
        for depth in DEPTHS:
            free = Problem(features, labels, depth=depth)
            wanted = {option: free.replace(**asked(free)) for option, asked in of_classes.items()}
            yield from _lines(name, free, wanted, limit)
            if of_numbers:
                free = Problem(columns, targets, depth=depth, loss=SquaredError())
                wanted = {option: free.replace(loss=loss, **asked) for option, (loss, asked) in of_numbers.items()}
                yield from _lines(name, free, wanted, limit)


def _lines(name: str, free: Problem, wanted: Mapping[str, Problem], limit: float) -> Iterator[Line]:
    """Yield a line for each option beside the problem without any, where that is proven."""
    alone, before = proof(free, limit) if wanted else (None, 0.0)
    for option, problem in wanted.items() if alone is not None and alone.is_optimal else ():
        solution, seconds = proof(problem, limit, is_logged="log" in option)
        yield {
            "size": f"{name}, depth {free.shape.depth}, {option}",
            "seed": 0,
            "table": name,
            "depth": free.shape.depth,
            "option": option,
            "outcome": "proven" if solution.is_optimal else "open",
            "objective": solution.objective,
            "bound": solution.bound,
            "free_seconds": round(before, 4),
            "cpu_seconds": round(seconds, 4),
            "price": round(max(seconds, SHORTEST) / max(before, SHORTEST), 2),
        }


def proof(problem: Problem, limit: float, is_logged: bool = False) -> tuple[Solution, float]:
    """Return the answer of the exact method within so many CPU seconds, and those that it took."""
    with tempfile.TemporaryDirectory() as folder:
        options = ExactOptions(proof=Path(folder) / "proof.log") if is_logged else ExactOptions()
        watch = Stopwatch()
        solution = solve(problem, "exact", options=options, **cpu_limit(limit))
        return solution, watch.read()[0]


def summary(lines: Sequence[Line]) -> str:
    """Return a row for each option: mean and worst price by depth, and the proofs that are open."""
    depths = sorted({line["depth"] for line in lines})
    rows = []
    for option in dict.fromkeys(line["option"] for line in lines):
        cells = []
        for depth in depths:
            found = [line for line in lines if (line["option"], line["depth"]) == (option, depth)]
            prices = [line["price"] for line in found]
            n_open = sum(line["outcome"] == "open" for line in found)
            cells += [f"{np.mean(prices):.1f} / {max(prices):.1f}", str(n_open)] if found else ["", ""]
        rows.append([option, *cells])
    heads = [head for depth in depths for head in (f"depth {depth}: mean / worst", "open")]
    return markdown(["option", *heads], rows)
