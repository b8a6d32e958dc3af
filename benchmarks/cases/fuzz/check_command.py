"""Mangled proof logs and problem files, read by the command `octmip-check`, a program without Python.

Small random problems are solved with a log; then the log, the problem file or both are mangled: bytes, tokens, digits,
huge numbers, lines left out, repeated or exchanged, nodes within nodes, nested JSON. In half of the files the digests
of the header are then made to fit, as anyone could, so that what stands behind them is read too. The command may refuse
(exit code 1 or 2, in one line), or accept a bound that is true of the problem that it was given; enumeration says what
is true. Everything else is counted as "other" and listed with its seed: another exit code, a panic, more than `SLOWEST`
seconds, `LARGEST` bytes of address space, more than one line. A bound that is not true is counted as "wrong".
"""

import json
import os
import re
import resource
import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from benchmarks.corruptions import HEADER, LINE_CHANGES, Generator
from benchmarks.readers.mangling import TOKENS, mangled_bytes, mangled_json, pick
from benchmarks.tables import Line, markdown
from octmip.errors import OctmipError
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_file import write_problem_file
from tests.oracles.rational import least_cost
from tests.oracles.strategies import random_problem, with_missing
from tests.oracles.two_feature_problems import random_two_feature_problem

STREAM = 80  # of seeds: corruption i is drawn from default_rng([STREAM, i])
N_CORRUPTIONS, CHUNK = 10_000, 100
SLOWEST, LARGEST = 10.0, 2**30
NATIVE = Path(__file__).parents[3] / "octmip" / "trees" / "native"
VERIFIED = re.compile(r"verified: no tree costs less than (\S+) \(\d+ lines, [\d.]+ s\)\n")
REFUSED = re.compile(r".*, line \d+: .*; the proof is refused\n")
DIGEST = re.compile(r'expected "((?:data|question) [0-9a-f]{64})"')
Answer = tuple[int | None, str, str]
"""Exit code (None: not in time), standard output, standard error."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk of corruptions: counts by what was mangled and outcome, and those of other seeds."""
    command = built()
    for first in range(0, N_CORRUPTIONS, CHUNK * max(threads)):
        seeds = range(first, min(first + CHUNK * max(threads), N_CORRUPTIONS))
        done = Parallel(n_jobs=max(threads))(delayed(corrupted)(seed, command) for seed in seeds)
        counts = Counter(f"{what}: {outcome.partition(':')[0]}" for what, outcome in done)
        faults = [[s, o] for s, (_, o) in zip(seeds, done, strict=True) if o.startswith(("other", "wrong"))]
        yield {"size": f"corruptions {seeds[0]} to {seeds[-1]}", "seed": STREAM, "counts": counts, "faults": faults}


def summary(lines: Sequence[Line]) -> str:
    """Return the table of outcomes."""
    counts = sum((Counter(line["counts"]) for line in lines), Counter[str]())
    faults = [fault for line in lines for fault in line["faults"]]
    table = markdown(["what: outcome", "count"], sorted(counts.items()))
    return f"{counts.total()} corruptions, {len(faults)} wrong or other {faults}.\n\n{table}"


@cache
def built() -> Path:
    """Build the command, in the profile of the tests, and return its path."""
    build = ["cargo", "build", "--quiet", "--profile", "checks", "-p", "octmip-check"]
    subprocess.run(build, cwd=NATIVE, check=True, timeout=600)
    return Path(os.environ.get("CARGO_TARGET_DIR", NATIVE / "target")) / "checks" / "octmip-check"


def corrupted(seed: int, command: Path) -> tuple[str, str]:
    """Mangle one pair of files; return what was mangled, and "refused", "true", "wrong" or "other: ..."."""
    rng = np.random.default_rng([STREAM, seed])
    problem = _drawn(rng)
    with tempfile.TemporaryDirectory() as folder:
        log, file = Path(folder) / "proof.log", Path(folder) / "problem.json"
        solve = branch_and_bound if problem.shape.split == "axis" else two_feature_branch_and_bound
        solve(problem, options=ExactOptions(proof=log))
        write_problem_file(file, problem)
        what = str(rng.choice(["log", "log", "problem", "both"]))
        if what != "log":
            file.write_bytes(
                pick(rng, (mangled_bytes, mangled_json, mangled_json, _with_other_number))(rng, file.read_bytes())
            )
        if what != "problem":
            log.write_bytes(_mangled_log(rng, log.read_bytes()))
        answer = run(command, log, file)
        for _ in range(2 if rng.random() < 0.5 else 0):
            answer = _with_fitting_digest(command, log, file, answer)
        return what, _judged(answer, problem, file, is_changed=what != "log")


def run(command: Path, log: Path, file: Path) -> Answer:
    """Run the command on two threads within `SLOWEST` seconds and `LARGEST` bytes of address space."""
    limit = (LARGEST, LARGEST)
    try:
        done = subprocess.run(
            [command, log, file, "--threads", "2"],
            capture_output=True,
            timeout=SLOWEST,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit),
        )
    except subprocess.TimeoutExpired:
        return None, "", ""
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def _drawn(rng: Generator) -> Problem:
    kind = int(rng.integers(4))
    if kind == 0:
        return random_two_feature_problem(rng, depth=2 - int(rng.random() < 0.2), max_samples=8)
    if kind == 1:
        return with_missing(rng, random_problem(rng, max_samples=9))
    return random_problem(rng, max_samples=9)


def _mangled_log(rng: Generator, content: bytes) -> bytes:
    if rng.random() < 0.2:
        return mangled_bytes(rng, content)
    lines = content.decode().split("\n")
    small = [pick(rng, LINE_CHANGES) for _ in range(int(rng.integers(3)))]
    for change in small if small and rng.random() < 0.5 else [*small, pick(rng, (_token, _nested, _shuffled))]:
        if len(lines) > HEADER + 3:
            change(rng, lines)
    return "\n".join(lines).encode(errors="replace")


def _token(rng: Generator, lines: list[str]) -> None:
    """Replace a token by one that is long, huge or none, or add it."""
    row = int(rng.integers(len(lines)))
    tokens = lines[row].split(" ")
    place = int(rng.integers(len(tokens)))
    tokens[place : place + int(rng.integers(2))] = [pick(rng, TOKENS)]
    lines[row] = " ".join(tokens)


def _nested(rng: Generator, lines: list[str]) -> None:
    """Put records within records, or the same decision or cut many times, in the place of a line."""
    row, times = int(rng.integers(HEADER, len(lines))), int(rng.integers(1, 20_000))
    inner = pick(
        rng, (["N 3 1 0", "K 0 1", "L"], ["N 2 1 0", "B"], ["B"], ["S 0"], ["T 0.0"], ["R 0.1 0.1"], ["F 0 1 1"])
    )
    lines[row : row + 1] = inner * times


def _shuffled(rng: Generator, lines: list[str]) -> None:
    """Bring the lines of the body into another order."""
    lines[HEADER:-2] = [lines[HEADER:-2][k] for k in rng.permutation(len(lines[HEADER:-2]))]


def _with_other_number(rng: Generator, content: bytes) -> bytes:
    """Return a problem file, one of its numbers a little larger or smaller."""
    numbers = list(re.finditer(rb"(?<=[\s\[,:])\d+(?:\.\d+)?(?=[\],}])", content))
    place = pick(rng, numbers)
    value = float(place.group()) + float(rng.choice([-1, -0.5, 0.5, 1]))
    text = str(int(value)) if value.is_integer() else repr(value)
    return content[: place.start()] + text.encode() + content[place.end() :]


def _with_fitting_digest(command: Path, log: Path, file: Path, answer: Answer) -> Answer:
    """Write the digest that a refusal asks for into the log and run the command again."""
    asked = DIGEST.search(answer[1])
    lines = log.read_bytes().split(b"\n")
    if asked is None or len(lines) < 3:
        return answer
    lines[1 if asked[1].startswith("data") else 2] = asked[1].encode()
    log.write_bytes(b"\n".join(lines))
    return run(command, log, file)


def _judged(answer: Answer, problem: Problem, file: Path, *, is_changed: bool) -> str:
    """Return what an answer is worth."""
    code, out, err = answer
    if code == 1 and REFUSED.fullmatch(out) and not err:
        return "refused"
    if code == 2 and not out and err.startswith("octmip-check: ") and err.count("\n") == 1:
        return "refused"
    accepted = VERIFIED.fullmatch(out)
    if code != 0 or accepted is None or err:
        return f"other: exit code {code}, {out[:100]!r}, {err[:200]!r}"
    try:
        least = _least_of(file) if is_changed else float(least_cost(problem))
    except (OctmipError, ValueError) as error:
        return f"other: accepted, but {error!r}"
    return "true" if float(accepted[1]) <= least * (1 + 1e-15) else f"wrong: {accepted[1]} is above {least}"


def _least_of(file: Path) -> float:
    """Return the least objective of the problem of a problem file, by a reading of our own."""
    held = json.loads(file.read_bytes())
    groups = held["allowed_splits"]
    if len(set(held["labels"])) == 1 or (groups is not None and not any(groups)):
        paid = np.array(held["weights"]) @ np.array(held["costs"], dtype=float)[held["labels"]]
        return float(paid.min())  # one leaf; a problem would be refused
    return float(least_cost(_problem_in(held)))


def _problem_in(held: dict[str, Any]) -> Problem:
    """Return the problem that the entries of a problem file stand for."""
    features = np.array([[np.nan if cell is None else cell for cell in row] for row in held["features"]], dtype=float)
    return Problem(
        features,
        np.array(held["labels"]),
        class_names=tuple(range(len(held["costs"]))),
        takes_missing=bool(np.isnan(features).any()),
        depth=held["depth"],
        split=held["split"],
        split_size=held["split_size"] if held["split"] == "hyperplane" else None,
        leaf_size=min(held["leaf_size"], len(features)),  # beyond that no split is left either
        leaf_penalty=held["leaf_penalty"],
        weights=held["weights"],
        loss=ClassCosts(held["costs"]),
        sensor_of_feature=[str(sensor) for sensor in held["sensor_of_feature"]],
        sensor_cost={str(sensor): held["sensor_cost"][sensor] for sensor in held["sensor_of_feature"]},
        sensor_budget=held["sensor_limit"],
        allowed_splits=held["allowed_splits"] and [group for group in held["allowed_splits"] if group],
    )
