"""Branch and bound = mixed-integer programs on HiGHS = enumeration: two-feature trees, three programs, no shared proof.

`oct_h` and `flow` ask every sample to keep a distance from the line, HiGHS's tolerance over the range of the features;
branch and bound asks for none. So a mixed-integer optimum may lie above its optimum, never below, and where it does the
bound of the program is one of fewer trees. Each side starts from a local search of its own and knows nothing of the
others.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from benchmarks.cpu import cpu_limit
from benchmarks.data import Table, first_rows, uci
from benchmarks.oracles.two_feature import best_objective
from benchmarks.oracles.two_feature_problems import random_two_feature_problem
from benchmarks.tables import Line
from benchmarks.two_feature import strains
from octmip.trees.certificate import certify
from octmip.trees.methods.search import local_search
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.mip.flow import solve_flow
from octmip.trees.mip.oct_h import solve_oct_h
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution

RANDOM = 60  # small random problems of every sort, half of depth 1 and half of depth 2
MIO: dict[str, Callable[..., Solution]] = {"flow": solve_flow, "oct_h": solve_oct_h}


def problems() -> Iterator[tuple[str, Problem, bool]]:
    """Yield a name, a problem, and whether enumeration can answer it."""
    for seed in range(RANDOM):
        rng = np.random.default_rng([63, seed])
        yield f"random {seed}", random_two_feature_problem(rng, depth=1 + seed % 2, max_samples=7), True
    tables: dict[str, Callable[[], Table]] = {
        "iris, every tenth row": lambda: _every(uci("iris"), 10),
        "iris": partial(uci, "iris"),
        "published mu1, 25 x 2": lambda: first_rows(strains("mu1", 175, 2), 25),
        "published mu1, 175 x 2": partial(strains, "mu1", 175, 2),
        "published mu2, 25 x 2": lambda: first_rows(strains("mu2", 175, 2), 25),
        "published mu2, 175 x 2": partial(strains, "mu2", 175, 2),
    }
    for name, table in tables.items():
        for depth in (1, 2):
            data = table()
            problem = Problem(data.features, data.labels, depth=depth, split="hyperplane", split_size=2)
            yield f"{name}, depth {depth}", problem, problem.n_samples <= (30 if depth == 1 else 15)


def _every(table: Table, step: int) -> Table:
    return Table(table.features[::step], table.labels[::step])


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each problem."""
    for name, problem, is_small in problems():
        yield {"size": name, "seed": 0} | compared(problem, is_small, limit, threads[0])


def compared(problem: Problem, is_small: bool, limit: float, n_threads: int) -> Line:
    """Return what each program finds and proves of a problem, and the verdict."""
    exact = two_feature_branch_and_bound(problem, limits=Limits(seconds=limit), n_jobs=n_threads)
    certify(problem, exact)
    line: Line = {"limit": limit, "threads": n_threads, "exact": exact.objective, "exact_bound": exact.bound}
    line["enumeration"] = best_objective(problem) if is_small else None
    start = local_search(problem, limits=Limits(seconds=limit)).tree
    for method, solve in MIO.items():
        mio = solve(problem, incumbent=start, n_jobs=n_threads, **cpu_limit(limit))
        certify(problem, mio)
        line |= {method: mio.objective, f"{method}_bound": mio.bound, f"{method}_proven": mio.is_optimal}
    return line | {"verdict": verdict(line)}


def verdict(line: Line) -> str:
    """Return "agree", "mu" (the mixed-integer optimum keeps a distance that costs), or what contradicts what."""
    within = 1e-6 * max(1.0, line["exact"])
    best = line["exact"] if line["exact_bound"] >= line["exact"] - within else None
    if line["enumeration"] is not None and (best is None or abs(line["enumeration"] - best) > within):
        return "NO: enumeration"
    is_short = False
    for method in MIO:
        if line[method] < line["exact_bound"] - within:
            return f"NO: {method} has a better tree"
        is_short |= line[f"{method}_bound"] > line["exact"] + within
    if is_short:
        return "mu"
    return (
        "agree" if any(line[f"{method}_proven"] for method in MIO) or line["enumeration"] is not None else "one proof"
    )


def summary(lines: list[Line]) -> str:
    """Return the table of the named problems, and one line about the random ones."""
    head = ["problem", "branch and bound", "enumeration", "flow", "its bound", "oct_h", "its bound", "verdict"]
    table = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for line in lines:
        if not line["size"].startswith("random"):
            small = "-" if line["enumeration"] is None else f"{line['enumeration']:g}"
            values = [f"{line[key]:g}" for key in ("flow", "flow_bound", "oct_h", "oct_h_bound")]
            table.append(
                "| " + " | ".join([line["size"], f"{line['exact']:g}", small, *values, line["verdict"]]) + " |"
            )
    verdicts = [line["verdict"] for line in lines if line["size"].startswith("random")]
    counts = {verdict: verdicts.count(verdict) for verdict in sorted(set(verdicts))}
    return "\n".join([*table, "", f"{len(verdicts)} random problems: {counts}."])
