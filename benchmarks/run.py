"""Measure a family of cases: `python -m benchmarks.run NAME [--limit 60] [--threads 1,2] [--csv FILE]`.

Prints one JSON line per result. Every solver answers in a process of its own, killed soon after its limit; CPU and wall
seconds are those of the solving call alone (all threads and processes of it), the median of several where it is short.
"""

import argparse
import base64
import csv
import inspect
import json
import math
import os
import pickle
import re
import resource
import statistics
import subprocess
import sys
import warnings
from collections.abc import Iterator

from benchmarks.case import Case
from benchmarks.context import context
from benchmarks.cpu import Stopwatch
from benchmarks.registry import FAMILIES, family
from benchmarks.rivals import RIVALS
from benchmarks.tables import Line
from octmip.interfaces.cli.stages import term_as_interrupt

GRACE = 60.0  # seconds to start, build the data and stop politely before a solver is killed
SHORT = 0.5  # a solving call is repeated until so many seconds have passed, at most 5 times


def main() -> None:
    """Run one family and print its lines, then its table on standard error."""
    options = _options()
    if options.child:
        print(json.dumps(_measure(pickle.loads(base64.b64decode(options.child)), options)))
        return
    module = family(options.name)
    threads = [int(count) for count in options.threads.split(",")]
    if hasattr(module, "results"):
        given = {
            name: value for name in ("only", "solvers", "seeds", "seed", "draws") if (value := getattr(options, name))
        }
        if unknown := set(given) - set(inspect.signature(module.results).parameters):
            raise SystemExit(f"{options.name} measures all its cases itself: --{min(unknown)} means nothing to it")
        lines = module.results(options.limit, threads, **given)
    elif options.seeds:
        raise SystemExit(f"{options.name} has no random problems: --seeds means nothing to it")
    else:
        lines = _race(module.cases(), options, threads)
    shown = _shown(options.name, lines)
    if options.csv:
        _write_csv(shown, options.csv)
    if hasattr(module, "summary"):
        print(module.summary(shown), file=sys.stderr)


def _shown(name: str, lines: Iterator[Line]) -> list[Line]:
    """Return the lines of a family, each printed when it is there; Ctrl-C and SIGTERM end it with those that are."""
    shown: list[Line] = []
    with term_as_interrupt():
        try:
            for line in lines:
                shown.append({"case": name, **line, **context()})
                print(json.dumps(shown[-1]), flush=True)
        except KeyboardInterrupt:
            print(f"interrupted after {len(shown)} lines", file=sys.stderr)
    return shown


def _write_csv(lines: list[Line], path: str) -> None:
    """Write lines as a table with a column for every key that any of them has."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(dict.fromkeys(key for line in lines for key in line)))
        table.writeheader()
        table.writerows(lines)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", help=", ".join(FAMILIES))
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for each solver and case")
    parser.add_argument("--threads", default="1", help="thread counts of the solvers that use several, such as 1,2")
    parser.add_argument("--only", default="", help="only cases named so (a regular expression on 'size, seed')")
    parser.add_argument("--solvers", default="", help="only these solvers, such as octmip,pycontree")
    parser.add_argument("--seeds", type=int, default=0, help="only these first random problems of each kind")
    parser.add_argument("--seed", type=int, default=0, help="of what is drawn; without it the clock gives one")
    parser.add_argument("--draws", type=int, default=0, help="how many are drawn")
    parser.add_argument("--csv", help="write the lines into this file as a table, at the end")
    parser.add_argument("--solver", help=argparse.SUPPRESS)
    parser.add_argument("--child", help=argparse.SUPPRESS)  # the case, pickled: listing a family can take longer
    return parser.parse_args()


def _race(cases: Iterator[Case], options: argparse.Namespace, threads: list[int]) -> Iterator[Line]:
    wanted = options.solvers.split(",") if options.solvers else list(RIVALS)
    for case in cases:
        for solver in case.solvers if re.search(options.only, f"{case.size}, seed {case.seed}") else ():
            for count in threads if RIVALS[solver].is_threaded else [1]:
                if solver in wanted:
                    yield _in_own_process(case, solver, count, options)


def _in_own_process(case: Case, solver: str, threads: int, options: argparse.Namespace) -> Line:
    pickled = base64.b64encode(pickle.dumps(case)).decode()
    command = [sys.executable, "-m", "benchmarks.run", options.name, "--child", pickled, "--solver", solver]
    command += ["--limit", str(options.limit), "--threads", str(threads)]
    line = {"size": case.size, "seed": case.seed, "solver": solver, "threads": threads, "limit": options.limit}
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=options.limit + GRACE, env=os.environ | one_thread
        )
    except subprocess.TimeoutExpired:  # the machine was busy or the solver did not stop: no figure
        return line | {"outcome": "killed past the limit", "version": RIVALS[solver].version}
    if done.returncode:
        reason = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        return line | {"outcome": f"failed: {reason[:200]}", "version": RIVALS[solver].version}
    answer: Line = json.loads(done.stdout.splitlines()[-1])
    return line | answer


def _measure(case: Case, options: argparse.Namespace) -> Line:
    """Solve one case in this process and return its figures."""
    warnings.simplefilter("ignore")  # rivals warn of their time limits
    rival = RIVALS[options.solver]
    fit = rival.prepare(case.build())
    cpu: list[float] = []
    wall: list[float] = []
    while sum(wall) < SHORT and len(wall) < 5:
        watch = Stopwatch()
        answer = fit(options.limit, int(options.threads))
        for kept, seconds in zip((cpu, wall), watch.read(), strict=True):
            kept.append(seconds)
    # Rivals do not say whether they finished: within the limit they claim the optimum, past it nothing.
    in_time = wall[-1] < 0.98 * options.limit
    bound = answer.bound if in_time or options.solver.startswith("octmip") else -math.inf
    return {
        "outcome": "proven" if bound >= answer.objective - 1e-9 * max(1.0, answer.objective) else "not proven",
        "objective": answer.objective,
        "bound": bound if math.isfinite(bound) else None,
        "gap": (answer.objective - bound) / max(answer.objective, 1e-300) if math.isfinite(bound) else None,
        "cpu_seconds": round(statistics.median(cpu), 6),
        "wall_seconds": round(statistics.median(wall), 6),
        "repeats": len(wall),
        "peak_megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
        "version": rival.version,
        "settings": answer.settings,
    }


if __name__ == "__main__":
    main()
