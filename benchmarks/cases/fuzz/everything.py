"""Every solver on random problems over the whole range of float64, held against enumeration in fractions.

`python -m benchmarks.run fuzz_everything --limit 3600 --threads 2`: so many seconds in so many processes, one line per
chunk of seeds; the table of docs/reliability.md at the end. What counts as wrong, for any problem and any limit:

    optimal     the answer says optimal, and a tree that costs less (by more than the stated tolerance) exists
    bound       the bound lies above the least cost
    answer      the tree breaks a limit of the problem, or its objective in fractions is another
    proof       a log that was written is refused by the checker, or accepted for a claim above the least cost
    exception   anything but the project's own errors; or one of these where the problem has a tree (any has: a leaf)
    warning     any
    late        the call took over a second more than its limit allows
    hang        the call did not end at all

Problem i is `wide_problem(default_rng([STREAM, i]))`; what failed once stands in tests/test_octmip/test_fuzz_corpus.py.
"""

import json
import math
import multiprocessing
import resource
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Literal

import numpy as np

from benchmarks.oracles.rational import cost_of, least_cost
from benchmarks.oracles.wide_problems import wide_problem
from benchmarks.tables import Line
from octmip.certificate import certify
from octmip.errors import CertificateError, OctmipError
from octmip.problem import Problem
from octmip.proof import check_proof
from octmip.registry import REGISTRY
from octmip.solution import Limits, Solution, Stop
from octmip.solver import Method, solve

STREAM = 71
CHUNK = 100
PATIENCE = 60.0  # seconds without a word from a chunk's process before its problem is called a hang
LATE = 1.0  # seconds over a limit
ROUNDING = Fraction(1, 2**44)  # relative: an objective is a sum of rounded products, rounded again
METHODS: dict[Literal["axis", "hyperplane"], tuple[Method, ...]] = {
    "axis": ("exact", "search", "cart", "oct", "flow", "benders"),
    "hyperplane": ("exact", "search", "oct_h"),
}
STREAM_OF_SPLIT = {
    "axis": 5,
    "hyperplane": 3,
}  # a further method at the end of a tuple leaves the questions of old seeds
MIXED_INTEGER = ("oct", "flow", "oct_h", "benders")
SHARE = {"exact": 1.0, "search": 0.6, "cart": 0.3, "oct": 0.12, "flow": 0.12, "oct_h": 0.15, "benders": 0.3}
"""Share of the problems that each solver is asked: those on HiGHS take a hundred times as long as the others."""


@dataclass(frozen=True, slots=True)
class Question:
    """One call: which problem, which solver, which limits, with a proof log or without."""

    seed: int
    split: str
    method: Method
    limits: Limits
    proof: bool

    def __str__(self) -> str:
        limits = f"seconds={self.limits.seconds:g}, nodes={self.limits.nodes:g}, gap={self.limits.gap:g}"
        return f"seed {self.seed} {self.split} {self.method} ({limits}{', proof' if self.proof else ''})"


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line per chunk of seeds until the time is up."""
    start = time.perf_counter()
    with ThreadPoolExecutor(max(threads)) as pool:
        first = 0
        while time.perf_counter() - start < limit:
            firsts = range(first, first + CHUNK * max(threads), CHUNK)
            yield from pool.map(lambda seed: watched(range(seed, seed + CHUNK)), firsts)
            first = firsts.stop


def watched(seeds: range) -> Line:
    """Return the line of a chunk, answered in a process of its own that is ended where it no longer moves."""
    context = multiprocessing.get_context("spawn")
    answers: list[Line] = []
    rest = seeds
    while rest:
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_answer_all, args=(rest, theirs))
        process.start()
        theirs.close()
        asked = ""
        try:
            while ours.poll(PATIENCE):
                kind, content = ours.recv()
                if kind == "asked":
                    asked = content
                elif kind == "answer":
                    answers.append(content)
                else:
                    rest = range(content, seeds.stop)
            hung = True
        except EOFError:  # done, or died
            process.join()
            hung = process.exitcode != 0
        if not hung:
            break
        process.kill()
        process.join()
        answers.append({"question": asked, "wrong": f"hang: no end after {PATIENCE} s, or the process died"})
        rest = range(_seed_of(asked, rest) + 1, seeds.stop)
    return _line(seeds, answers)


def _seed_of(asked: str, rest: range) -> int:
    return int(asked.split()[1]) if asked else rest.start


def _line(seeds: range, answers: Sequence[Line]) -> Line:
    counts = Counter((a["method"], a["outcome"]) for a in answers if "outcome" in a)
    return {
        "size": f"seeds {seeds.start} to {seeds.stop - 1}",
        "seed": STREAM,
        "n_problems": len(seeds),
        "counts": {" ".join(key): count for key, count in sorted(counts.items())},
        "wrong": {a["question"]: a["wrong"] for a in answers if a.get("wrong")},
        "latest": max((a["late"] for a in answers if "late" in a), default=0.0),
        "megabytes": max((a["megabytes"] for a in answers if "megabytes" in a), default=0.0),
    }


def _answer_all(seeds: range, pipe: Connection) -> None:
    for registration in {one for solvers in REGISTRY.values() for one in solvers.values()}:
        registration.load()  # imports are no solver's time
    for seed in seeds:
        for question, problem, least in questions(seed):
            pipe.send(("asked", str(question)))
            pipe.send(("answer", answer(question, problem, least)))
        pipe.send(("done", seed + 1))


def questions(seed: int) -> Iterator[tuple[Question, Problem, Fraction]]:
    """Yield the calls of a seed, each with its problem and the least cost of any tree of it."""
    for split, methods in METHODS.items():
        rng = np.random.default_rng([STREAM, seed, STREAM_OF_SPLIT[split]])
        problem = wide_problem(rng, split=split)
        least = least_cost(problem)
        for method in methods:
            if rng.random() < SHARE[method]:
                proof = method == "exact" and problem.integer_normals is None and rng.random() < 0.2
                yield Question(seed, split, method, _limits(rng, method), proof), problem, least


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


def answer(question: Question, problem: Problem, least: Fraction) -> Line:
    """Ask once and return the outcome, with a sentence where something is wrong."""
    began = time.perf_counter()
    said: Line = {"question": str(question), "method": f"{question.split} {question.method}"}
    with warnings.catch_warnings(record=True) as heard, tempfile.TemporaryDirectory() as folder:
        warnings.simplefilter("always")
        log = Path(folder) / "log.txt"
        try:
            solution = solve(
                problem,
                question.method,
                limits=question.limits,
                seed=question.seed,
                options={"proof": log} if question.proof else None,
            )
            late = time.perf_counter() - began - question.limits.seconds
            said["outcome"] = str(solution.stop)
            wrong = complaint(problem, solution, least) or _proof_complaint(problem, log, solution, least)
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


def complaint(problem: Problem, solution: Solution, least: Fraction) -> str:
    """Return what is wrong with a solution in exact arithmetic, '' when nothing is."""
    try:
        certify(problem, solution)
    except CertificateError as error:
        return f"answer: {error}"
    assert solution.tree is not None
    cost = cost_of(problem, solution.tree)
    if abs(Fraction(solution.objective) - cost) > ROUNDING * cost:
        return f"answer: objective {solution.objective} but {float(cost)} in fractions"
    if cost < least:
        return f"answer: a tree of {float(cost)} below the least cost {float(least)}: the oracle is wrong"
    is_restricted = not str(solution.details.get("scope", "all")).startswith("all")
    says_optimal = solution.is_optimal or solution.stop is Stop.OPTIMAL
    if says_optimal and not is_restricted and cost - least > Fraction(solution.tolerance) + ROUNDING * least:
        return f"optimal: says so at {float(cost)}, tolerance {solution.tolerance}; the least cost is {float(least)}"
    if math.isfinite(solution.bound) and not is_restricted and Fraction(solution.bound) > least * (1 + ROUNDING):
        return f"bound: {solution.bound} above the least cost {float(least)} (objective {float(cost)})"
    return ""


def _proof_complaint(problem: Problem, log: Path, solution: Solution, least: Fraction) -> str:
    if not log.exists():
        return ""
    try:
        report = check_proof(problem, log, bound=solution.bound)
    except CertificateError as error:
        return f"proof: {error}"
    return f"proof: accepted for {report.bound}" if Fraction(report.bound) > least * (1 + ROUNDING) else ""


def summary(lines: Sequence[Line]) -> str:
    """Return the table of outcomes per solver, and every wrong answer."""
    counts = sum((Counter(line["counts"]) for line in lines), Counter[str]())
    wrong = {question: reason for line in lines for question, reason in line["wrong"].items()}
    kinds = Counter(reason.partition(":")[0] for reason in wrong.values())
    outcomes = sorted({key.split()[2] for key in counts})
    methods = sorted({" ".join(key.split()[:2]) for key in counts})
    table = ["| solver | " + " | ".join(outcomes) + " | in all |", "|" + "---|" * (len(outcomes) + 2)]
    for method in methods:
        row = [counts[f"{method} {outcome}"] for outcome in outcomes]
        table.append(f"| {method} | " + " | ".join(map(str, row)) + f" | {sum(row)} |")
    n_problems = sum(line["n_problems"] for line in lines)
    head = [
        f"{2 * n_problems} problems ({n_problems} of each kind of split), {sum(counts.values())} calls, "
        f"{len(wrong)} wrong {dict(kinds)}.",
        f"Latest {max(line['latest'] for line in lines):.2f} s over its limit; "
        f"at most {max(line['megabytes'] for line in lines):.0f} MB.",
    ]
    return "\n".join([*head, "", *table, "", *(f"{q}: {json.dumps(r)}" for q, r in sorted(wrong.items())[:60])])
