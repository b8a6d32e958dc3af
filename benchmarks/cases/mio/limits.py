"""Time limits of the mixed-integer methods: by how much a run overruns its limit, on models up to 1,750 x 20.

The run is one of wall seconds, from call to Solution, building and decoding counted. Every method starts from CART.
"""

import time
from collections.abc import Callable, Iterator
from functools import partial

from benchmarks.data import Table, first_rows, published, uci
from benchmarks.problem_options import ProblemOptions
from benchmarks.tables import Line
from octmip.trees.certificate import certify
from octmip.trees.mip.benders.solver import solve_benders
from octmip.trees.mip.flow import solve_flow
from octmip.trees.mip.highs import highs
from octmip.trees.mip.oct import solve_oct
from octmip.trees.mip.oct_h import solve_oct_h
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution

SECONDS = (0.5, 1.0, 2.0, 5.0)
AXIS: dict[str, Callable[..., Solution]] = {"oct": solve_oct, "flow": solve_flow, "benders": solve_benders}
PLANES: dict[str, Callable[..., Solution]] = {"oct_h": solve_oct_h, "flow h": solve_flow}
CASES: tuple[tuple[str, Callable[[], Table], ProblemOptions, dict[str, Callable[..., Solution]]], ...] = (
    ("published mu2, 1750 rows, depth 2", lambda: published("mu2", 0), {"depth": 2}, AXIS),
    ("published mu2, 1750 rows, depth 3", lambda: published("mu2", 0), {"depth": 3}, AXIS),
    (
        "published mu2, 1750 rows, depth 2, hyperplanes",
        lambda: published("mu2", 0),
        {"depth": 2, "split": "hyperplane"},
        PLANES,
    ),
    (
        "published mu2, 350 rows, depth 2, two features",
        lambda: first_rows(published("mu2", 0), 350),
        {"depth": 2, "split": "hyperplane", "split_size": 2},
        PLANES,
    ),
    ("wine, depth 2, hyperplanes", partial(uci, "wine"), {"depth": 2, "split": "hyperplane", "split_size": 2}, PLANES),
)


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each case, method and time limit; `limit` has no part in it."""
    for name, table, options, methods in CASES:
        data = table()
        problem = Problem(data.features, data.labels, **options)
        for method, solve in methods.items():
            for seconds in SECONDS:
                began = time.perf_counter()
                found = solve(problem, limits=Limits(seconds=seconds), n_jobs=threads[0])
                wall = time.perf_counter() - began
                certify(problem, found)
                yield {
                    "size": name,
                    "method": method,
                    "seed": 0,
                    "threads": threads[0],
                    "limit": seconds,
                    "stop": str(found.stop),
                    "wall_seconds": round(wall, 3),
                    "over": round(wall - seconds, 3),
                    "version": f"HiGHS {highs.VERSION}",
                }


def summary(lines: list[Line]) -> str:
    """Return the table: seconds over the limit of each case and method."""
    head = ["case", "method", *(f"over {seconds:g} s" for seconds in SECONDS)]
    table = ["| " + " | ".join(head) + " |", "|---|---|" + "---:|" * len(SECONDS)]
    for size, method in dict.fromkeys((line["size"], line["method"]) for line in lines):
        own = [line for line in lines if (line["size"], line["method"]) == (size, method)]
        cells = [f"{line['over']:.2f}" if line["over"] > 0 else line["stop"] for line in own]
        table.append("| " + " | ".join([size, method, *cells]) + " |")
    late = sum(line["over"] > 1 for line in lines)
    return "\n".join([*table, "", f"More than 1 s over its limit: {late} of {len(lines)} runs."])
