"""Proofs checked by veripb, a program of others: on the formula of the problem as it is made anew here."""

import re
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from octmip.errors import CertificateError, SolverError
from octmip.formats.files import check_readable, read_bytes
from octmip.problem import Problem
from octmip.pseudo_boolean.files import formula_path
from octmip.pseudo_boolean.formula import Formula
from octmip.pseudo_boolean.question import question_of
from octmip.tree import Node

PROGRAM, VERSION = "veripb", "3.0.2"
VERDICT = re.compile(r"^s VERIFIED BOUNDS (\d+) <= obj <= (\d+)$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class VeripbReport:
    """What veripb accepted.

    Attributes
    ----------
    bound
        no tree of the problem costs less.
    objective
        what the tree in the proof costs.
    checker
        program and version.
    n_bytes, formula_bytes
        size of proof and formula.
    seconds
        that checking took, wall time [s].
    """

    bound: float
    objective: float
    checker: str
    n_bytes: int
    formula_bytes: int
    seconds: float


def check_with_veripb(problem: Problem, path: str | Path, tree: Node, bound: float) -> VeripbReport:
    """Let veripb check a proof, on the formula that is made anew from the problem.

    Raises
    ------
    ProblemError
        the problem has no formula.
    DataError
        a file cannot be read.
    SolverError
        veripb is not installed.
    CertificateError
        the formula is another problem's, veripb refuses the proof or accepts it with reservations, or it proves less
        than `bound`, or another tree's cost.
    """
    question, costs, _ = question_of(problem)
    n_bytes = check_readable(path)
    found = read_bytes(formula_path(path))
    formula = Formula(question).opb().encode("ascii")
    if found != formula:
        raise CertificateError(f"{formula_path(path)} is not the formula of this problem; the proof is refused")
    program = shutil.which(PROGRAM)
    if program is None:
        raise SolverError(
            f"{PROGRAM} is not installed; expected it on the path, version {VERSION}; install it by cargo install "
            f"{PROGRAM} --version {VERSION}"
        )
    start = time.perf_counter()
    version, low, high = _checked(program, formula, Path(path))
    seconds = time.perf_counter() - start
    proven, cost = costs.value(low), costs.value(high)
    if proven < bound:
        raise CertificateError(f"{path} proves the bound {proven} but {bound} is claimed for the tree")
    if high != costs.whole_objective(problem, tree):
        raise CertificateError(f"{path} holds a tree of cost {cost}, another than the one that is certified")
    return VeripbReport(proven, cost, version, n_bytes, len(formula), seconds)


def _checked(program: str, formula: bytes, proof: Path) -> tuple[str, int, int]:
    """Return the checker's version and the bounds that it verified."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "formula.opb"
        place.write_bytes(formula)
        done = subprocess.run(
            [program, "--opb", "--force-checked-deletion", str(place), str(proof.resolve())],
            capture_output=True,
            text=True,
            errors="replace",
        )
    verdict = VERDICT.findall(done.stdout)
    # A proof may assume what it cannot derive: veripb then says so in a warning beside its verdict.
    if done.returncode or len(verdict) != 1 or "assumption" in done.stdout.lower():
        raise CertificateError(f"{PROGRAM} refuses {proof}: {_reason(done)}")
    version = re.search(r"version (\S+)", done.stdout)
    return (
        f"{PROGRAM} {'of unknown version' if version is None else version[1]}",
        int(verdict[0][0]),
        int(verdict[0][1]),
    )


def _reason(done: "subprocess.CompletedProcess[str]") -> str:
    """Return what the checker said, in one line."""
    said = [line.strip() for line in (done.stderr + done.stdout).splitlines() if line.strip()]
    told = [line for line in said if not re.match(r"(Running|Stack backtrace|Caused by|\d+:|at )", line)]
    return "; ".join(told[:2])[:300] or f"exit code {done.returncode}"
