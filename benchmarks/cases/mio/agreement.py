"""MIO = exact core = enumeration: one problem, three programs that share no line of their proofs.

The mixed-integer side starts from the tree of a local search and is given neither tree nor bound of the exact core.
Enumeration, the oracle of the tests, takes part where a problem is small.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import chain, combinations

import numpy as np

from benchmarks.cpu import cpu_limit
from benchmarks.data import Table, first_rows, published, uci
from benchmarks.oracles.enumeration import optimum
from benchmarks.oracles.strategies import random_problem
from benchmarks.tables import Line
from octmip.trees.certificate import certify
from octmip.trees.losses import ClassCosts
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.search import local_search
from octmip.trees.mip.flow import solve_flow
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution, Stop
from octmip.trees.tree import Leaf

RANDOM = 50  # small random problems of every kind, depth 1 to 3


def problems() -> Iterator[tuple[str, Problem, bool]]:
    """Yield a name, a problem, and whether enumeration can answer it."""
    tables: dict[str, Callable[[], Table]] = {
        "iris": partial(uci, "iris"),
        "wine": partial(uci, "wine"),
        "published mu1, 175 rows": lambda: first_rows(published("mu1", 0), 175),
        "published mu1, 350 rows": lambda: first_rows(published("mu1", 0), 350),
        "published mu2, 175 rows": lambda: first_rows(published("mu2", 0), 175),
    }
    for seed in range(RANDOM):
        yield f"random {seed}", random_problem(np.random.default_rng(seed), max_samples=8, max_features=2), True
    for name, table in tables.items():
        for depth in (1, 2, 3):
            yield (
                f"{name}, depth {depth}",
                Problem(table().features, table().labels, depth=depth),
                name == "iris" and depth < 3,
            )
        yield from ((f"{name}, depth 2, {words}", problem, False) for words, problem in _variants(table()))


def _variants(table: Table) -> Iterator[tuple[str, Problem]]:
    """Yield the problem with risk weights, with graded costs, with a sensor budget, with a penalty and a leaf size."""
    features, labels = table.features, table.labels
    order = np.unique(labels, return_inverse=True)[1]
    yield "weights", Problem(features, labels, depth=2, weights=(1 + order).astype(np.float64))
    graded = np.abs(np.subtract.outer(np.arange(order.max() + 1), np.arange(order.max() + 1)))
    yield "costs |i - k|", Problem(features, labels, depth=2, loss=ClassCosts(graded))
    yield "one sensor", Problem(features, labels, depth=2, sensor_budget=1)
    yield "penalty 3, leaf size 5", Problem(features, labels, depth=2, leaf_penalty=3, leaf_size=5)


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each problem."""
    for name, problem, is_small in problems():
        start = local_search(problem, limits=Limits(seconds=limit)).tree
        mio = solve_flow(problem, incumbent=start, n_jobs=threads[0], **cpu_limit(limit))
        exact = _exact(problem, limit)
        certify(problem, mio)
        certify(problem, exact)
        proven = [solution.objective for solution in (mio, exact) if solution.is_optimal]
        enumerated = optimum(problem).objective if is_small else None
        proven += [] if enumerated is None else [enumerated]
        within = 1e-6 * max(1.0, mio.objective)
        sound = all(s.bound <= value + within for s in (mio, exact) for value in proven)
        yield {
            "size": name,
            "limit": limit,
            "threads": threads[0],
            "seed": 0,
            "mio": mio.objective,
            "mio_bound": mio.bound,
            "exact": exact.objective,
            "exact_bound": exact.bound,
            "enumeration": enumerated,
            "agree": bool(np.ptp(proven) <= within) if proven else None,
            "bounds_sound": sound,
            "mio_seconds": round(mio.seconds, 3),
            "version": mio.version,
        }


def _exact(problem: Problem, limit: float) -> Solution:
    """Return the exact core's solution; under a budget, which it may not know, the best over all sets of sensors."""
    if problem.sensor_budget is None:
        return branch_and_bound(problem, limits=Limits(seconds=limit))
    sensors = range(len(problem.sensors))
    most = int((np.cumsum(np.sort(problem.sensor_costs)) <= problem.sensor_limit).sum())
    best = None
    for chosen in chain.from_iterable(combinations(sensors, size) for size in range(1, most + 1)):
        if problem.sensor_costs[list(chosen)].sum() > problem.sensor_limit:
            continue
        features = [[j] for j in range(problem.n_features) if problem.sensor_index[j] in chosen]
        allowed = [group for group in features if problem.is_allowed((group[0],))]
        if allowed:
            part = replace(problem, sensor_budget=None, allowed_splits=allowed)
            found = branch_and_bound(part, limits=Limits(seconds=limit))
            best = found if best is None or found.objective < best.objective else best
    if best is not None:
        return best
    leaf = Leaf(int(problem.class_costs().argmin()))
    return Solution(leaf, problem.baseline, problem.baseline, Stop.OPTIMAL, 0.0, 0, "exact", "no sensor affordable", 0)


def summary(lines: list[Line]) -> str:
    """Return the table of the named problems, and one line about the random ones."""
    head = ["problem", "MIO", "its bound", "exact", "its bound", "enumeration", "agree", "MIO wall s"]
    table = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for line in lines:
        if not line["size"].startswith("random"):
            small = "-" if line["enumeration"] is None else f"{line['enumeration']:g}"
            values = [f"{line[key]:g}" for key in ("mio", "mio_bound", "exact", "exact_bound")]
            agree = "yes" if line["agree"] and line["bounds_sound"] else "NO"
            cells = [line["size"], *values, small, agree, f"{line['mio_seconds']:.2g}"]
            table.append("| " + " | ".join(cells) + " |")
    random = [line for line in lines if line["size"].startswith("random")]
    good = sum(bool(line["agree"] and line["bounds_sound"]) for line in random)
    return "\n".join([*table, "", f"Random problems on which all three agree: {good} of {len(random)}."])
