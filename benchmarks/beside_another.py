"""CPU seconds of these sources beside those of another checkout: `python -m benchmarks.beside_another FOLDER`.

Both solve the same problems of exact_uav, search_hits, regression_speed and two_feature, in turn and in processes of
their own. A call is repeated for 0.4 s, and the least of all rounds counts: on a busy machine the least strays least.
One JSON line a problem, then the median of the ratios of each family; `same`: objective and nodes are equal.
"""

import argparse
import importlib
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

FAMILIES = ("exact_uav", "search_hits", "regression_speed", "two_feature")
ROUNDS = 2
REPEATED_FOR = 0.4
Found = dict[str, list[float]]
"""Least CPU seconds, objective and nodes by problem."""


def main() -> None:
    """Measure both checkouts and print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", help="the other checkout, its native core built")
    parser.add_argument("--only", choices=FAMILIES, nargs="+", default=FAMILIES, help="these families alone")
    given = parser.parse_args()
    folder = Path(given.folder).resolve()
    for family in given.only:
        pairs = [(_measured(folder, family), _measured(Path.cwd(), family)) for _ in range(ROUNDS)]
        ratios = []
        for name in pairs[0][0]:
            other, own = (min(pair[side][name][0] for pair in pairs) for side in (0, 1))
            ratios.append(own / other)
            same = pairs[0][0][name][1:] == pairs[0][1][name][1:]
            line = {"case": family, "size": name, "other": other, "own": own, "ratio": round(own / other, 3)}
            print(json.dumps(line | {"same": same}), flush=True)
        print(f"{family}: median ratio {statistics.median(ratios):.3f} of {len(ratios)} problems", flush=True)


def _measured(folder: Path, family: str) -> Found:
    """Return what a checkout needs for the problems of a family, in a process that imports that checkout alone."""
    environment = os.environ | {"PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, __file__, family]
    run = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True)
    found: Found = json.loads(run.stdout)
    return found


def timed(call: Callable[[], Any]) -> list[float]:
    """Return the least CPU seconds of a call, its objective and its nodes."""
    seconds: list[float] = []
    while len(seconds) < 2 or sum(seconds) < REPEATED_FOR:
        start = time.process_time()
        solution = call()
        seconds.append(time.process_time() - start)
    return [min(seconds), solution.objective, solution.n_nodes]


def calls(family: str) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield the problems of a family by name, as calls that solve them."""
    data, problem = importlib.import_module("benchmarks.data"), _octmip("question.problem").Problem
    solve = partial(_octmip("solver").solve, method="exact")
    search, two_feature = _octmip("methods.search").local_search, _octmip("methods.two_feature")
    if family == "exact_uav":
        tables = {f"published {t}, seed {s}": data.published(t, s) for t in ("mu1", "mu2") for s in (0, 1, 2)}
        tables |= {f"synthetic {t}": data.synthetic_uav(t) for t in "AB"}
        for depth in (2, 3):
            for name, table in tables.items():
                yield f"{name}, depth {depth}", partial(solve, problem(table.features, table.labels, depth=depth))
    elif family == "search_hits":
        tables = {f"published {t}": data.published(t, 0) for t in ("mu1", "mu2")}
        for depth in (2, 3):
            for name, table in tables.items():
                for seed in (0, 1):
                    asked = problem(table.features, table.labels, depth=depth)
                    yield f"{name}, depth {depth}, seed {seed}", partial(search, asked, seed=seed)
        for name in ("iris", "wine", "seeds"):
            table = data.uci(name)
            yield f"{name}, depth 3", partial(search, problem(table.features, table.labels, depth=3))
    elif family == "regression_speed":
        losses = {
            name: loss() if isinstance(loss, type) else loss
            for name, loss in _octmip("question.losses").NUMBER_LOSSES.items()
            if name in ("squared", "absolute")
        }
        for target, depth, loss in (
            *((t, 2, loss) for t in ("mu1", "mu2") for loss in ("squared", "absolute")),
            ("mu1", 3, "squared"),
            ("mu2", 3, "squared"),
        ):
            table = data.published(target, 0)
            asked = problem(table.features, table.labels.astype(float), depth=depth, loss=losses[loss])
            yield f"published {target}, depth {depth}, {loss}", partial(solve, asked)
        features, targets = importlib.import_module("benchmarks.regression.samples").made_up(100_000)
        yield "made up, 100,000", partial(solve, problem(features, targets, depth=2, loss=losses["squared"]))
    else:
        for name, table_of in importlib.import_module("benchmarks.cases.two_feature.trees").CASES[:7]:
            table = table_of()
            asked = problem(table.features, table.labels, depth=2, split="hyperplane", split_size=2)
            yield name, partial(two_feature.two_feature_branch_and_bound, asked)


def _octmip(name: str) -> Any:
    """Return a module of octmip's trees."""
    return importlib.import_module(f"octmip.trees.{name}")


if __name__ == "__main__":
    if sys.argv[1:] and sys.argv[1] in FAMILIES:
        json.dump({name: timed(call) for name, call in calls(sys.argv[1])}, sys.stdout)
    else:
        main()
