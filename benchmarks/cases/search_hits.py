"""Searches that find the proven optimum of axis-aligned trees, and their time; default settings, ten seeds.

The optimum comes from the exact core within `--limit` seconds (`UNBEATEN` holds those that need minutes); where it is
not proven in time the case is left out, and named, as is every set of more than `SEARCH_SAMPLES` samples. Seconds "to
the optimum" are counted up to the first progress report that shows it, a few hundredths late.
"""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from benchmarks.cpu import Stopwatch
from benchmarks.data import Table, numeric_sets, published, synthetic_uav, uci
from benchmarks.tables import Line, markdown
from octmip.trees.answer.solution import Limits, Progress
from octmip.trees.methods.search import local_search
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve

DEPTHS = (2, 3, 4)
N_SEEDS = int(os.environ.get("SEARCH_SEEDS", "10"))
MOST_SAMPLES = int(os.environ.get("SEARCH_SAMPLES", "2000"))
# Proven by the exact core in minutes (docs/benchmarks.md, `exact_uci`), by name and depth, with the CPU seconds within
# which the optimum is wanted; and how long one search may take [s].
UNBEATEN = {("synthetic UAV B", 4): (341.0, 10.0), ("published mu2, seed 0", 4): (953.0, 3.0)}
SEARCH_LIMIT = 30.0
QUICK = 1.0  # CPU seconds wanted everywhere else


@dataclass(frozen=True, slots=True)
class _Question:
    name: str
    table: Table
    depth: int

    @property
    def problem(self) -> Problem:
        return Problem(self.table.features, self.table.labels, depth=self.depth)


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each case, seed and number of threads, and one for each case without a known optimum."""
    for question in _questions():
        head = _head(question)
        if len(question.table.labels) > MOST_SAMPLES:
            yield head | {"outcome": f"over {MOST_SAMPLES} samples"}
            continue
        optimum = _optimum(question, limit)
        if optimum is None:
            yield head | {"outcome": f"not proven in {limit:g} s"}
            continue
        wanted = UNBEATEN.get((question.name, question.depth), (optimum, QUICK))[1]
        for count in threads:
            for seed in range(N_SEEDS):
                known = head | {"optimum": optimum, "wanted_cpu_seconds": wanted}
                yield known | _searched(question.problem, optimum, seed, count)


def _questions() -> Iterator[_Question]:
    tables = {name: uci(name) for name in numeric_sets()[0]}
    tables |= {f"synthetic UAV {target}": synthetic_uav(target) for target in "AB"}
    tables |= {
        f"published {target}, seed {seed}": published(target, seed) for target in ("mu1", "mu2") for seed in (0, 1)
    }
    for depth in DEPTHS:
        for name, table in tables.items():
            yield _Question(name, table, depth)


def _head(question: _Question) -> Line:
    n, p = question.table.features.shape
    return {"size": f"{question.name}, depth {question.depth}", "n": n, "p": p, "depth": question.depth}


def _optimum(question: _Question, limit: float) -> float | None:
    known = UNBEATEN.get((question.name, question.depth))
    if known is not None:
        return known[0]
    solution = solve(question.problem, method="exact", limits=Limits(seconds=limit))
    return solution.objective if solution.is_optimal else None


def _searched(problem: Problem, optimum: float, seed: int, n_jobs: int) -> Line:
    hit: tuple[float, float] | None = None
    watch = Stopwatch()

    def look(state: Progress) -> None:
        nonlocal hit
        if hit is None and state.objective <= optimum:
            hit = watch.read()

    limits = Limits(seconds=SEARCH_LIMIT)
    solution = local_search(problem, limits=limits, seed=seed, n_jobs=n_jobs, progress=look)
    end = watch.read()
    if solution.objective > optimum:
        hit = None
    elif hit is None:
        hit = end
    return {
        "seed": seed,
        "threads": n_jobs,
        "objective": solution.objective,
        "stop": str(solution.stop),
        "hit_cpu_seconds": hit and round(hit[0], 4),
        "hit_wall_seconds": hit and round(hit[1], 4),
        "cpu_seconds": round(end[0], 4),
        "wall_seconds": round(end[1], 4),
    }


def summary(lines: Sequence[Line]) -> str:
    """Return the shares by depth, then what was left out and why."""
    runs = [line for line in lines if "optimum" in line]
    depths = [_shares(str(depth), [line for line in runs if line["depth"] == depth]) for depth in DEPTHS]
    head = ("depth", "cases", "searches", "at the optimum", "within 1 %", "known in the time wanted", "ended in it")
    reasons = dict.fromkeys(line["outcome"] for line in lines if "outcome" in line)
    left_out = {reason: [line["size"] for line in lines if line.get("outcome") == reason] for reason in reasons}
    told = [f"Left out, {reason}: {'; '.join(names)}." for reason, names in left_out.items()]
    wanted = "; ".join(f"{name}, depth {depth}: {wanted[1]:g}" for (name, depth), wanted in UNBEATEN.items())
    table = markdown(head, [*depths, _shares("all", runs)])
    return "\n".join([table, "", *told, f"Time wanted: {QUICK:g} CPU s; {wanted}"])


def _shares(name: str, runs: Sequence[Line]) -> list[object]:
    """Return a row of counts, with percentages of the searches."""
    counts = [
        sum(line["objective"] <= line["optimum"] for line in runs),
        sum(line["objective"] <= 1.01 * line["optimum"] for line in runs),
        sum(map(_is_in_time, runs)),
        sum(line["cpu_seconds"] <= line["wanted_cpu_seconds"] for line in runs),
    ]
    cells = [f"{count} = {100 * count / max(1, len(runs)):.1f} %" for count in counts]
    return [name, len({line["size"] for line in runs}), len(runs), *cells]


def _is_in_time(line: Line) -> bool:
    return line["hit_cpu_seconds"] is not None and line["hit_cpu_seconds"] <= line["wanted_cpu_seconds"]
