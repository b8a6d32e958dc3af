"""Every kind of problem and every solver, at random over the whole range of float64, against enumeration in fractions.

`python -m benchmarks.run fuzz_everything --limit 3600 --threads 2`: so many seconds in so many processes, one line per
chunk of seeds; the table of docs/reliability.md at the end. `--only near` asks the kinds that a regular expression
finds. What counts as wrong, for any problem and any limit:

    optimal     the answer says optimal, and a tree that costs less (by more than the stated tolerance) exists
    bound       the bound lies above the least cost
    answer      the tree breaks a limit of the problem, or its objective in fractions is another
    unproven    no limit but the time of a kind that is always proven, and the answer is not
    proof       a log that was written is refused by the checker, or accepted for a claim above the least cost
    exception   anything but the project's own errors; or one of these: every problem has a tree
    warning     any
    late        the call took over a second more than its limit allows
    hang        the call did not end at all

The kinds are those of `benchmarks.kinds`; the problem of seed i and a kind is drawn from default_rng([STREAM, i, the
kind's stream]). What failed once stands in tests/test_octmip/test_fuzz_corpus.py. Which constants of the core the sizes
lie beyond: docs/reliability.md, "Sizes".
"""

import json
import multiprocessing
import re
import resource
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kinds.classes import (
    AXIS_KIND,
    FEW_LEAVES_KIND,
    FEW_SPLITS_KIND,
    HYPERPLANE_KIND,
    LINES_KIND,
    MISSING_KIND,
    MIXED_INTEGER,
    SIZED_KIND,
    SPARSE_KIND,
    TWO_FEATURE_KIND,
)
from benchmarks.kinds.kind import Kind, Question
from benchmarks.kinds.numbers import NUMBER_KINDS
from benchmarks.kinds.ordered import MONOTONE_FEW_KIND, MONOTONE_KIND
from benchmarks.kinds.others import NearSets, WorstCases
from benchmarks.kinds.parted import PART_KINDS
from benchmarks.kinds.sample_costs import SAMPLE_COSTS_KIND
from benchmarks.kinds.texts import Texts
from benchmarks.kinds.ties import TIES_KIND
from benchmarks.tables import Line, markdown
from octmip.errors import OctmipError
from octmip.trees.registry import REGISTRY
from octmip.trees.solution import Limits, Stop

STREAM = 71
CHUNK = 100
PATIENCE = 60.0  # seconds without a word from a chunk's process before its problem is called a hang
LATE = 1.0  # seconds over a limit
PROVEN = (Stop.OPTIMAL, Stop.FINISHED)  # a set is counted where it is finished
KINDS: dict[str, Kind] = {
    "axis": AXIS_KIND,
    "hyperplane": HYPERPLANE_KIND,
    "missing": MISSING_KIND,
    "sized": SIZED_KIND,
    "lines": LINES_KIND,
    "two_feature": TWO_FEATURE_KIND,
    "few_splits": FEW_SPLITS_KIND,
    "few_leaves": FEW_LEAVES_KIND,
    "sparse": SPARSE_KIND,
    "monotone": MONOTONE_KIND,
    "monotone_few": MONOTONE_FEW_KIND,
    **PART_KINDS,
    **NUMBER_KINDS,
    "texts": Texts(),
    "sample_costs": SAMPLE_COSTS_KIND,
    "ties": TIES_KIND,
    "worst_case": WorstCases(),
    "near": NearSets(),
}


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield a line per chunk of seeds until the time is up."""
    start, kinds = time.perf_counter(), [name for name in KINDS if re.search(only, name)]
    with ThreadPoolExecutor(max(threads)) as pool:
        first = 0
        while time.perf_counter() - start < limit:
            firsts = range(first, first + CHUNK * max(threads), CHUNK)
            yield from pool.map(lambda seed: watched(range(seed, seed + CHUNK), kinds), firsts)
            first = firsts.stop


def watched(seeds: range, kinds: Sequence[str] = tuple(KINDS)) -> Line:
    """Return the line of a chunk, answered in a process of its own that is ended where it no longer moves."""
    context = multiprocessing.get_context("spawn")
    answers: list[Line] = []
    rest = seeds
    while rest:
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_answer_all, args=(rest, kinds, theirs))
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
        "n_problems": len({tuple(a["question"].split()[1:3]) for a in answers}),
        "counts": {" ".join(key): count for key, count in sorted(counts.items())},
        "wrong": {a["question"]: a["wrong"] for a in answers if a.get("wrong")},
        "latest": max((a["late"] for a in answers if "late" in a), default=0.0),
        "megabytes": max((a["megabytes"] for a in answers if "megabytes" in a), default=0.0),
    }


def _answer_all(seeds: range, kinds: Sequence[str], pipe: Connection) -> None:
    for seed in seeds:
        for question, problem, truth in questions(seed, kinds):
            pipe.send(("asked", str(question)))
            pipe.send(("answer", answer(question, problem, truth)))
        pipe.send(("done", seed + 1))


def questions(seed: int, kinds: Sequence[str] = tuple(KINDS)) -> Iterator[tuple[Question, Any, Any]]:
    """Yield the calls of a seed, each with its problem and what enumeration says of it."""
    for name in kinds:
        kind = KINDS[name]
        rng = np.random.default_rng([STREAM, seed, kind.stream])
        if kind.share < 1 and rng.random() >= kind.share:
            continue
        problem = kind.draw(rng)
        truth = kind.truth(problem)
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


def summary(lines: Sequence[Line]) -> str:
    """Return the table of outcomes per solver, and every wrong answer."""
    counts = sum((Counter(line["counts"]) for line in lines), Counter[str]())
    wrong = {question: reason for line in lines for question, reason in line["wrong"].items()}
    kinds = Counter(reason.partition(":")[0] for reason in wrong.values())
    outcomes = sorted({key.split()[2] for key in counts})
    methods = sorted({" ".join(key.split()[:2]) for key in counts})
    rows = {method: [counts[f"{method} {outcome}"] for outcome in outcomes] for method in methods}
    table = markdown(["solver", *outcomes, "in all"], ([method, *row, sum(row)] for method, row in rows.items()))
    n_problems = sum(line["n_problems"] for line in lines)
    head = [
        f"{n_problems} problems, {sum(counts.values())} calls, {len(wrong)} wrong {dict(kinds)}.",
        f"Latest {max(line['latest'] for line in lines):.2f} s over its limit; "
        f"at most {max(line['megabytes'] for line in lines):.0f} MB.",
    ]
    return "\n".join([*head, "", table, "", *(f"{q}: {json.dumps(r)}" for q, r in sorted(wrong.items())[:60])])
