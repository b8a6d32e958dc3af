"""The verified checker beside octmip-check: the same verdict on every log, good and corrupted.

Small random problems, a third of them with costs over many orders of magnitude and a third with readings missing, are
solved with a log. One log in four stays as it is, one has a line changed, one a raised claim, one is read with other
data. Both checkers get the same problem and the same log, and must give the same verdict and bound; a refusal may name
another line, as octmip-check counts the parts of a node when it has read them.
"""

import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.corruptions import LINE_CHANGES, Generator, changed_data, raise_claim
from benchmarks.tables import Line, markdown
from octmip.errors import OctmipError
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_file import write_problem_file
from tests.oracles.strategies import random_problem, with_missing
from tests.oracles.wide_problems import wide_problem

__all__ = ["PROGRAM", "Verdict", "agree", "compared", "results", "summary", "verdict"]

PROGRAM = Path(__file__).parents[3] / "octmip" / "trees" / "verified" / "build" / "octmip-verified"
STREAM = 44
N_LOGS, CHUNK = 2000, 50


@dataclass(frozen=True)
class Verdict:
    """What a checker says of a log.

    Attributes
    ----------
    is_accepted
        whether the log proves its claim.
    words
        the bound that it proves, or the line and the reason.
    """

    is_accepted: bool
    words: str


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk of logs: what both checkers said, and the seeds of those that they disagree on."""
    for first in range(0, N_LOGS, CHUNK):
        pairs = [compared(seed) for seed in range(first, first + CHUNK)]
        wrong = [first + i for i, pair in enumerate(pairs) if not agree(pair)]
        counts = Counter(f"{kind}: {'accepted' if one.is_accepted else 'refused'}" for kind, one, _ in pairs)
        counts["the same words"] = sum(one == other for _, one, other in pairs)
        yield {"size": f"logs {first} to {first + CHUNK - 1}", "seed": STREAM, "counts": counts, "wrong": wrong}


def summary(lines: Sequence[Line]) -> str:
    """Return the table of logs by verdict."""
    counts = sum((Counter(line["counts"]) for line in lines), Counter[str]())
    wrong = [seed for line in lines for seed in line["wrong"]]
    return f"{len(wrong)} disagreements {wrong}.\n\n{markdown(['log: verdict', 'count'], sorted(counts.items()))}"


Pair = tuple[str, Verdict, Verdict]


def agree(pair: Pair) -> bool:
    """Whether both verdicts are the same, and the bound of an accepted log too."""
    _, one, other = pair
    return one.is_accepted == other.is_accepted and (one == other or not one.is_accepted)


def compared(seed: int) -> Pair:
    """Return what became of a log, and both verdicts, octmip-check's first."""
    rng = np.random.default_rng([STREAM, seed])
    problem = _drawn(rng)
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "proof.log"
        branch_and_bound(problem, options=ExactOptions(proof=log))
        kind = str(rng.choice(["whole", "a line changed", "claim raised", "other data"]))
        if kind == "other data":
            problem = changed_data(rng, problem)
        elif kind != "whole":
            lines = log.read_text().split("\n")
            change = raise_claim if kind == "claim raised" else LINE_CHANGES[int(rng.integers(len(LINE_CHANGES)))]
            change(rng, lines)
            log.write_text("\n".join(lines))
        return kind, _of_octmip_check(problem, log), verdict(problem, log)


def verdict(problem: Problem, log: Path) -> Verdict:
    """Return what the verified checker says of a log.

    Raises
    ------
    ValueError
        it can use the files no more than octmip-check could.
    """
    file = log.with_suffix(".json")
    write_problem_file(file, problem)
    done = subprocess.run([PROGRAM, log, file], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise ValueError(f"octmip-verified ends with {done.returncode}: {done.stderr}")
    return Verdict(done.returncode == 0, _words(done.stdout))


def _words(line: str) -> str:
    """Return the bound of a line of the program, or what follows the name of the log."""
    if line.startswith("verified: "):
        return repr(float(line.split("no tree costs less than ")[1].split(" ")[0]))
    return line.strip().partition("proof.log, ")[2]


def _of_octmip_check(problem: Problem, log: Path) -> Verdict:
    try:
        return Verdict(True, repr(check_proof(problem, log).bound))
    except OctmipError as error:
        return Verdict(False, str(error).partition("proof.log, ")[2])


def _drawn(rng: Generator) -> Problem:
    # Logs of larger leaves hold records of leaves of any size too, which the theorem does not cover.
    if rng.random() < 1 / 3:
        return wide_problem(rng, max_samples=16).replace(leaf_size=1)
    problem = random_problem(rng, max_samples=24).replace(leaf_size=1)
    return with_missing(rng, problem) if rng.random() < 0.5 else problem
