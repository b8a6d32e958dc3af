"""Every kind of problem and every solver, at random over the whole range of float64, against enumeration in fractions.

`python -m benchmarks.run fuzz_everything --limit 3600 --threads 2`: so many seconds in so many processes, one line per
chunk of seeds; the table of docs/reliability.md at the end. `--only near` asks the kinds that a regular expression
finds. `--seeds 3000` asks one question about each of the first 3,000 problems of a kind, of `exact` where it can
answer, and the limit is that of a call. What counts as wrong, for any problem and any limit:

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
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection

from benchmarks.kinds.asked import KINDS, STREAM, answer, questions
from benchmarks.tables import Line, markdown

CHUNK = 100
PATIENCE = 60.0  # seconds without a word from a chunk's process before its problem is called a hang

SLOW_ENUMERATION = 1800.0
"""The same where the first seeds are asked whatever their share: listing the trees of one may take minutes."""


def results(limit: float, threads: Sequence[int], only: str = "", seeds: int = 0) -> Iterator[Line]:
    """Yield a line per chunk of seeds until the time is up, or the seeds are."""
    start, kinds = time.perf_counter(), [name for name in KINDS if re.search(only, name)]
    stop, free = (seeds, limit) if seeds else (sys.maxsize, None)
    with ThreadPoolExecutor(max(threads)) as pool:
        first = 0
        while first < stop and (seeds or time.perf_counter() - start < limit):
            firsts = range(first, min(first + CHUNK * max(threads), stop), CHUNK)
            yield from pool.map(lambda seed: watched(range(seed, min(seed + CHUNK, stop)), kinds, free), firsts)
            first = firsts.stop


def watched(seeds: range, kinds: Sequence[str] = tuple(KINDS), free: float | None = None) -> Line:
    """Return the line of a chunk, answered in a process of its own that is ended where it no longer moves."""
    context = multiprocessing.get_context("spawn")
    answers: list[Line] = []
    rest, patience = seeds, PATIENCE if free is None else SLOW_ENUMERATION
    while rest:
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_answer_all, args=(rest, kinds, free, theirs))
        process.start()
        theirs.close()
        asked = ""
        try:
            while ours.poll(patience):
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
        answers.append({"question": asked, "wrong": f"hang: no end after {patience} s, or the process died"})
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


def _answer_all(seeds: range, kinds: Sequence[str], free: float | None, pipe: Connection) -> None:
    for seed in seeds:
        for question, problem, truth in questions(seed, kinds, free):
            pipe.send(("asked", str(question)))
            pipe.send(("answer", answer(question, problem, truth)))
        pipe.send(("done", seed + 1))


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
