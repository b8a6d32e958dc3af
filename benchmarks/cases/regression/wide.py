"""Regression trees of many samples and of far ones against the optimum, with their proof logs, good and corrupted.

`python -m benchmarks.run fuzz_regression_wide`: 2,000 problems of 8 to 400 samples and 1 to 4 columns, past the core's
16 bins, 48 and 64 buckets and 256 parts of a feature, targets lognormal, Cauchy, tied, whole or in clusters; each with
a log that is checked and then corrupted. 3,000 small ones with targets up to 1e12 and weights of any size, against
enumeration in fractions. Then 2,000 and 1,000 of the same with quantile losses of many levels.
"""

import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.corruptions import LINE_CHANGES, raise_claim
from benchmarks.oracles.regression_runs import Runs
from benchmarks.oracles.regression_trees import least_objective
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.certificate import certify
from octmip.trees.losses import AbsoluteError, NumberLoss, QuantileError, SquaredError
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.proof import check_proof
from octmip.trees.regression.exact import exact_regression
from octmip.trees.solution import Solution

CHUNK, N_FORGED = 50, 6
SIZES = {"wide": 2000, "far": 3000, "wide quantiles": 2000, "far quantiles": 1000}
STREAMS = {"wide": 127, "far": 128, "wide quantiles": 129, "far quantiles": 130}
LEVELS = (0.1, 0.9, 0.5, 0.25, 0.95, 0.025, 1 / 3, 0.999)
OFF = 1e-13
"""Errors are rounded once each where runs are compared."""
Outcome = tuple[str | None, Counter[str]]


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk: what disagreed, and what was counted."""
    chunks = [(kind, first) for kind, n in SIZES.items() for first in range(0, n, CHUNK)]
    with ProcessPoolExecutor(max(threads)) as pool:
        yield from pool.map(_chunk, *zip(*chunks, strict=True))


def _chunk(kind: str, first: int) -> Line:
    start, seeds = time.process_time(), range(first, first + CHUNK)
    outcomes = {seed: judged(kind, seed) for seed in seeds}
    return {
        "size": f"{kind}, seeds {first} to {seeds.stop - 1}",
        "seed": STREAMS[kind],
        "mismatches": {seed: reason for seed, (reason, _) in outcomes.items() if reason},
        "counts": sum((counts for _, counts in outcomes.values()), Counter[str]()),
        "cpu_seconds": time.process_time() - start,
    }


def summary(lines: Sequence[Line]) -> str:
    """Return the counts of both streams."""
    counts = sum((Counter(line["counts"]) for line in lines), Counter[str]())
    wrong = {f"{line['size']}: {seed}": why for line in lines for seed, why in line["mismatches"].items()}
    rows = [f"| {what} | {counts[what]} |" for what in sorted(counts)]
    return "\n".join([f"{len(wrong)} mismatches {wrong}.", "", "| what | count |", "|---|---|", *rows])


def judged(kind: str, seed: int) -> Outcome:
    """Return what is wrong with the answers to a problem (None: nothing), and what there was."""
    rng = np.random.default_rng([STREAMS[kind], seed])
    losses = quantiles(rng) if kind.endswith("quantiles") else (SquaredError(), AbsoluteError())
    is_wide = kind.startswith("wide")
    problem = wide_problem(rng, losses) if is_wide else far_problem(rng, losses)
    least = Runs(problem).least() if is_wide else least_objective(problem)
    counts = Counter({f"{kind}: problems": 1})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.log"
        try:
            solution = exact_regression(problem, n_jobs=1 + seed % 2)
            certify(problem, solution)
            counts[f"{kind}: {solution.stop}"] += 1
            if reason := _complaint(problem, solution, least):
                return reason, counts
            logged = exact_regression(problem, options=ExactOptions(proof=path))
            certify(problem, logged)
            proven = check_proof(problem, path, bound=logged.bound).bound
            counts[f"{kind}: with a log, {logged.stop}"] += 1
        except OctmipError as error:
            return f"{type(error).__name__}: {error}", counts
        if logged.tree != solution.tree or Fraction(proven) > least:
            return f"the log proves {proven} and the optimum is {float(least)}, or another tree is found", counts
        for _ in range(N_FORGED):
            outcome = _forged(rng, problem, path, least)
            counts[f"{kind}: corrupted logs, {outcome}"] += 1
            if outcome == "wrong":
                return "a corrupted log is accepted for a bound above the optimum", counts
    return None, counts


def _complaint(problem: Problem, solution: Solution, least: Fraction) -> str | None:
    assert solution.tree is not None
    if Fraction(solution.bound) > least:
        return f"bound {solution.bound} above {float(least)}"
    exact = problem.exact_objective(solution.tree)
    if exact < least * (1 - Fraction(OFF)):
        return f"objective {solution.objective} below {float(least)}"
    if solution.tolerance > 1e-8 * float(exact):
        return f"{solution.objective} is called optimal within {solution.tolerance}, too wide a tolerance"
    if solution.is_optimal and exact - least > Fraction(solution.tolerance) + exact * Fraction(OFF):
        return f"{solution.objective} said to be optimal within {solution.tolerance}, the optimum is {float(least)}"
    return None


def _forged(rng: np.random.Generator, problem: Problem, path: Path, least: Fraction) -> str:
    """Corrupt a log and return "refused", "true" (accepted, and still true) or "wrong"."""
    lines = path.read_text().split("\n")
    changes: list[Callable[[np.random.Generator, list[str]], None]] = [*LINE_CHANGES, raise_claim, raise_bound]
    changes[int(rng.integers(len(changes)))](rng, lines)
    other = path.with_name("corrupted.log")
    other.write_text("\n".join(lines))
    try:
        bound = check_proof(problem, other).bound
    except OctmipError:
        return "refused"
    return "true" if Fraction(bound) <= least else "wrong"


def raise_bound(rng: np.random.Generator, lines: list[str]) -> None:
    """Raise the bound of one record, and the claim with it where they are the same."""
    records = [row for row, line in enumerate(lines) if line.startswith("N ")]
    row = int(rng.choice(records))
    words = lines[row].split(" ")
    raised = str(max(int(words[3]) + 1, int(int(words[3]) * (1 + float(rng.choice([1e-6, 0.01, 1.0]))))))
    lines[:] = [line.replace(words[3], raised) if line.startswith("claim ") else line for line in lines]
    lines[row] = " ".join([*words[:3], raised])


def quantiles(rng: np.random.Generator) -> tuple[NumberLoss, ...]:
    """Return a quantile loss of a common level, and one of any level in thousandths."""
    return QuantileError(LEVELS[int(rng.integers(len(LEVELS)))]), QuantileError(int(rng.integers(1, 1000)) / 1000)


def wide_problem(rng: np.random.Generator, losses: Sequence[NumberLoss]) -> Problem:
    """Return a problem of many samples: one column of any depth, or more columns as deep as they can be counted."""
    n_columns = int(rng.choice([1, 1, 2, 3, 4]))
    depth = int(rng.integers(1, 4))
    most = 400 if n_columns == 1 or depth == 1 else (60 if depth == 2 else 14)
    n = int(np.exp(rng.uniform(np.log(8), np.log(most))))
    features = [rng.normal(size=(n, n_columns)), rng.integers(0, max(2, n // 3), (n, n_columns)).astype(float)]
    return Problem(features[rng.integers(2)], wide_targets(rng, n), depth=depth, **_options(rng, n, losses))  # type: ignore[arg-type]


def wide_targets(rng: np.random.Generator, n: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return targets with a spread top, tied, whole or in clusters; mostly multiples of 1/64."""
    targets = [
        np.exp(1.5 * rng.normal(size=n)),
        np.clip(rng.standard_cauchy(n), -1e4, 1e4),
        np.round(np.exp(rng.normal(size=n)), 1),
        rng.integers(0, int(rng.integers(2, 300)), n).astype(float),
        100.0 * rng.integers(0, 5, n) + rng.normal(size=n),
        rng.normal(size=n),
    ][rng.choice(6, p=[0.3, 0.2, 0.15, 0.15, 0.1, 0.1])]
    return targets if n < 60 and rng.random() < 0.5 else np.round(targets * 64) / 64


def _options(rng: np.random.Generator, n: int, losses: Sequence[NumberLoss]) -> dict[str, object]:
    options: dict[str, object] = {"loss": losses[int(rng.integers(2))]}
    if rng.random() < 0.3:
        options["weights"] = np.maximum(rng.integers(0, 5, n), np.arange(n) == 0).astype(float)
    if rng.random() < 0.2:
        options["leaf_size"] = int(rng.integers(2, max(3, n // 6)))
    if rng.random() < 0.2:
        options["leaf_penalty"] = float(rng.choice([0.25, 1.0, 10.0]))
    return options


def far_problem(rng: np.random.Generator, losses: Sequence[NumberLoss]) -> Problem:
    """Return a small problem with some targets far off, or weights of any size, or both."""
    n, n_columns = int(rng.integers(3, 10)), int(rng.integers(1, 3))
    features = rng.integers(0, n, (n, n_columns)).astype(float)
    targets = [np.round(rng.normal(size=n), 1), rng.normal(size=n), rng.integers(0, 9, n).astype(float)][
        rng.integers(3)
    ]
    for row in rng.integers(0, n, int(rng.integers(0, 4))).tolist():
        targets[row] += rng.choice([-1.0, 1.0]) * np.round(10.0 ** rng.uniform(3, 12), int(rng.integers(0, 3)))
    loss = losses[int(rng.integers(2))]
    weights = [np.ones(n), np.round(rng.uniform(0.1, 1, n), 1), 10.0 ** rng.uniform(-9, 9, n)][rng.integers(3)]
    return Problem(features, targets, weights=weights, depth=int(rng.integers(1, 4)), loss=loss)
