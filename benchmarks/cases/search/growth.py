"""Local search against the number of samples, beside scikit-learn's CART: first answer and convergence.

First answer: `restarts=1, perturbations=0`, one descent from the greedy tree with exact blocks of two levels where they
pay.
One restart: that with four perturbations in a row, beginning, blocks and end included: what should grow as n log n.
Convergence: one restart of default effort, which ends when so many perturbations in a row have not helped. Both kinds
of splits.
`--limit` is CPU seconds per search.
"""

import math
import statistics
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from benchmarks.cpu import Stopwatch, cpu_limit
from benchmarks.tables import Line
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution, Stop

SAMPLES = (1_000, 10_000, 100_000, 1_000_000)
DEPTH = 4
REPEATS = 3
SHORT = 10_000  # longer runs are measured once
PERTURBATIONS = 4  # of the restart whose time is held against n log n
SPLITS: tuple[Literal["axis", "hyperplane"], ...] = ("axis", "hyperplane")
KINDS = ("CART", "first answer", "one restart", "converged")
ENDED = (str(Stop.FINISHED), str(Stop.OPTIMAL))


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each size and kind of answer; CPU seconds are the median of three runs where they are short."""
    for n in SAMPLES:
        for split in SPLITS:
            problem = _problem(n, split)
            yield _measured(n, split, "CART", partial(greedy_tree, problem))
            yield _measured(n, split, "first answer", _answer(problem, limit, 0))
            yield _measured(n, split, "one restart", _answer(problem, limit, PERTURBATIONS), 1)
            yield _measured(n, split, "converged", _answer(problem, limit, None), 1)


def _answer(problem: Problem, limit: float, perturbations: int | None) -> Callable[[], Solution]:
    return lambda: local_search(
        problem, options=SearchOptions(restarts=1, perturbations=perturbations), **cpu_limit(limit)
    )


def _problem(n: int, split: Literal["axis", "hyperplane"]) -> Problem:
    """Return 20 normal features, five classes by four of them along slopes, and a tenth of the labels drawn again."""
    rng = np.random.default_rng(0)
    features = rng.normal(size=(n, 20))
    score = features[:, 0] + 0.5 * features[:, 1] + (features[:, 2] > 0) * features[:, 3]
    labels = np.digitize(score, (-1.2, -0.4, 0.4, 1.2))
    noisy = rng.random(n) < 0.1
    return Problem(features, np.where(noisy, rng.integers(0, 5, n), labels), depth=DEPTH, split=split)


def _measured(n: int, split: str, kind: str, answer: Callable[[], Solution], repeats: int = REPEATS) -> Line:
    cpu = []
    for _ in range(repeats if n <= SHORT else 1):
        watch = Stopwatch()
        solution = answer()
        cpu.append(watch.read()[0])
    return {
        "size": f"{n} x 20, depth {DEPTH}, {split}, {kind}",
        "n": n,
        "split": split,
        "kind": kind,
        "seed": 0,
        "objective": solution.objective,
        "stop": str(solution.stop),
        "cpu_seconds": round(statistics.median(cpu), 5),
    }


def exponent(lines: Sequence[Line], split: str, kind: str) -> float:
    """Return b of seconds = a n^b, least squares on logarithms of the runs that ended by themselves."""
    chosen = [line for line in lines if (line["split"], line["kind"]) == (split, kind) and line["stop"] in ENDED]
    if len(chosen) < 2:
        return math.nan
    logs = np.log([[line["n"], max(line["cpu_seconds"], 1e-6)] for line in chosen])
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])


def picture(lines: Sequence[Line], path: Path) -> None:
    """Draw CPU seconds against samples, both axes logarithmic, one panel for each kind of split."""
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    for axes, split in zip(figure.subplots(1, 2, sharey=True), SPLITS, strict=True):
        for kind in KINDS:
            chosen = [line for line in lines if (line["split"], line["kind"]) == (split, kind)]
            sizes, seconds = [line["n"] for line in chosen], [line["cpu_seconds"] for line in chosen]
            axes.plot(sizes, seconds, "o-", label=f"{kind}: n^{exponent(lines, split, kind):.2f}")
        start = next(line for line in lines if (line["split"], line["kind"]) == (split, "one restart"))
        sizes = [line["n"] for line in lines if (line["split"], line["kind"]) == (split, "one restart")]
        slope = start["cpu_seconds"] / (start["n"] * math.log(start["n"]))
        axes.plot(sizes, [slope * n * math.log(n) for n in sizes], "k:", label="n log n")
        axes.set(xscale="log", yscale="log", xlabel="samples", ylabel="CPU seconds", title=split)
        axes.grid(alpha=0.3)
        axes.legend()
    with rc_context({"svg.fonttype": "none"}):
        figure.savefig(path)


def _at_least(line: Line) -> str:
    return "" if line["stop"] in ENDED else "> "


def summary(lines: Sequence[Line]) -> str:
    """Return the table of sizes with the ratios to CART, and the fitted exponents."""
    rows = []
    for split in SPLITS:
        for n in dict.fromkeys(line["n"] for line in lines):
            found = {line["kind"]: line for line in lines if (line["n"], line["split"]) == (n, split)}
            cart = found["CART"]["cpu_seconds"]
            cells = [
                f"{line['objective']:g} | {_at_least(line)}{line['cpu_seconds']:.3g} | {line['cpu_seconds'] / cart:.1f}"
                for line in (found["first answer"], found["converged"])
            ]
            restart = found["one restart"]
            per_n_log_n = 1e6 * restart["cpu_seconds"] / (n * math.log2(n))
            cells.append(f"{_at_least(restart)}{restart['cpu_seconds']:.3g} | {_at_least(restart)}{per_n_log_n:.3g}")
            rows.append(f"| {split}, {n:,} | {found['CART']['objective']:g} | {cart:.3g} | {' | '.join(cells)} |")
    fits = [
        f"{split}, {kind}: CPU seconds grow as n^{exponent(lines, split, kind):.2f}."
        for split in SPLITS
        for kind in KINDS[1:]
    ]
    head = "| | CART errors | CPU s | first: errors | CPU s | x CART | converged: errors | CPU s | x CART |"
    head += " one restart: CPU s | / (n log2 n) [us] |"
    return "\n".join([head, "|" + "---|" * 11, *rows, "", *fits])
