"""All kinds of problem, the questions of a seed, and what is wrong with an answer.

The problem of seed i and a kind is drawn from default_rng([STREAM, i, the kind's stream]).
"""

import resource
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kinds.classes import (
    AXIS_KIND,
    FEW_LEAVES_KIND,
    FEW_SPLITS_KIND,
    HYPERPLANE_KIND,
    LARGE_LEAVES_KIND,
    LINES_KIND,
    MISSING_KIND,
    MIXED_INTEGER,
    PLANES_KIND,
    SIZED_KIND,
    SPARSE_KIND,
    TWO_FEATURE_KIND,
)
from benchmarks.kinds.kind import Kind, Question
from benchmarks.kinds.numbers import NUMBER_KINDS
from benchmarks.kinds.others import NearSets
from benchmarks.kinds.sample_costs import SAMPLE_COSTS_KIND
from benchmarks.kinds.shaped import MONOTONE_KINDS, PART_KINDS
from benchmarks.kinds.texts import Texts
from benchmarks.kinds.ties import TIES_KIND
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import REGISTRY
from octmip.trees.solver import solve

STREAM = 71
LATE = 1.0  # seconds over a limit
PROVEN = (Stop.OPTIMAL, Stop.FINISHED)  # a set is counted where it is finished
KINDS: dict[str, Kind] = {
    "axis": AXIS_KIND,
    "hyperplane": HYPERPLANE_KIND,
    "missing": MISSING_KIND,
    "sized": SIZED_KIND,
    "lines": LINES_KIND,
    "two_feature": TWO_FEATURE_KIND,
    "planes": PLANES_KIND,
    "few_splits": FEW_SPLITS_KIND,
    "few_leaves": FEW_LEAVES_KIND,
    "large_leaves": LARGE_LEAVES_KIND,
    "sparse": SPARSE_KIND,
    **MONOTONE_KINDS,
    **PART_KINDS,
    **NUMBER_KINDS,
    "texts": Texts(),
    "sample_costs": SAMPLE_COSTS_KIND,
    "ties": TIES_KIND,
    "near": NearSets(),
}


def questions(
    seed: int, kinds: Sequence[str] = tuple(KINDS), free: float | None = None
) -> Iterator[tuple[Question, Any, Any]]:
    """Yield the calls of a seed, each with its problem and what enumeration says of it.

    `free`: one call of each kind, whatever its share, without any limit but these seconds.
    """
    for name in kinds:
        kind = KINDS[name]
        rng = np.random.default_rng([STREAM, seed, kind.stream])
        if kind.share < 1 and rng.random() >= kind.share and free is None:
            continue
        problem = kind.draw(rng)
        truth = kind.truth(problem)
        if free is not None:
            method = "exact" if "exact" in kind.methods else next(iter(kind.methods))
            yield Question(seed, name, method, Limits(seconds=free), proof=False), problem, truth
            continue
        for method, share in kind.methods.items():
            if rng.random() < share:
                proof = kind.has_log(problem, method) and rng.random() < 0.2
                yield Question(seed, name, method, _limits(rng, method), proof), problem, truth


def _limits(rng: np.random.Generator, method: str) -> Limits:
    kind = rng.integers(4)
    if method in MIXED_INTEGER:
        return Limits(seconds=float(rng.choice([0.0, 0.05, 0.5, 2.0])))
    if kind == 0:
        return Limits(seconds=10.0 ** rng.uniform(-4, 0))
    if kind == 1:
        return Limits(seconds=5.0, nodes=float(rng.integers(0, 60)))
    if kind == 2:
        return Limits(seconds=5.0, gap=float(rng.choice([0.0, 0.01, 0.5])))
    return Limits(seconds=5.0)


def answer(question: Question, problem: Any, truth: Any) -> Line:
    """Ask once and return the outcome, with a sentence where something is wrong."""
    for registration in {one for solvers in REGISTRY.values() for one in solvers.values()}:
        registration.load()  # imports are no solver's time
    if question.method in MIXED_INTEGER:
        _started()
    began = time.perf_counter()
    said: Line = {"question": str(question), "method": f"{question.kind} {question.method}"}
    kind = KINDS[question.kind]
    with warnings.catch_warnings(record=True) as heard, tempfile.TemporaryDirectory() as folder:
        warnings.simplefilter("always")
        log = Path(folder) / "log.txt"
        try:
            solution = kind.ask(question, problem, log if question.proof else None)
            late = time.perf_counter() - began - question.limits.seconds
            said["outcome"] = str(solution.stop)
            wrong = kind.complaint(problem, solution, truth, log)
            if not wrong and kind.is_proven and question.is_free and solution.stop not in PROVEN:
                wrong = f"unproven: stopped as {solution.stop}"
        except OctmipError as error:
            late, said["outcome"] = 0.0, "refused"
            wrong = f"exception: {type(error).__name__}: {error}"
        except Exception as error:
            late, said["outcome"] = 0.0, "exception"
            place = traceback.extract_tb(error.__traceback__)[-1]
            wrong = f"exception: {type(error).__name__} at {Path(place.filename).name}:{place.lineno}: {error}"
    if not wrong and heard:
        wrong = f"warning: {heard[0].category.__name__}: {heard[0].message}"
    # The proof log is a second search, which no limit ends.
    if not wrong and late > LATE and not question.proof:
        wrong = f"late: {late:.2f} s over the limit"
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return said | {"wrong": wrong, "late": 0.0 if question.proof else round(late, 3), "megabytes": round(megabytes)}


@cache
def _started() -> None:
    """Start the process of HiGHS, which lives as long as this one."""
    solve(Problem(np.array([[0.0], [1.0]]), np.array([0, 1]), depth=1), "oct")
