"""Proof logs: a file that shows, to a checker that knows no solver, that no tree of a problem costs less than claimed.

The header binds the log to one problem and puts weights and costs on a grid of whole numbers, rounded down, so that a
bound on the grid is one of the problem. The body is checked by the native `check`, short files that share no code with
the solvers. Format and proofs: docs/theory/proof.md; for splits over two features, docs/theory/oblique.md.
"""

import hashlib
import math
import re
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip import _native
from octmip.errors import CertificateError, ProblemError
from octmip.files import read_bytes
from octmip.problem import Problem

# First line of a log, by the kind of split.
FORMATS = {"axis": "octmip-proof 1", "hyperplane": "octmip-proof 1 two-feature"}
MOST_EXPONENT = 1000  # of the grid's powers of two
MOST_DEPTH, MOST_FEATURES = 2, 2  # of trees of two-feature splits that have logs
# Sums of costs on the grid stay below it, so that they fit into 64 bits with room for every sum of three.
CAPACITY = 2.0**61


@dataclass(frozen=True, slots=True)
class ProofReport:
    """What a checked log proves.

    Attributes:
        bound: no tree of the problem costs less.
        n_lines, n_bytes: size of the log.
        seconds: that checking took, wall time [s].
    """

    bound: float
    n_lines: int
    n_bytes: int
    seconds: float


def proof_header(problem: Problem, weight_unit: float, cost_unit: float, claim: int) -> str:
    """Return the first lines of a log that proves `claim`, in whole multiples of ``weight_unit * cost_unit``.

    The units are powers of two: weights count in `weight_unit`, costs in `cost_unit`, rounded down.
    """
    exponents = [-round(math.log2(unit)) for unit in (weight_unit, cost_unit)]
    return "\n".join(
        [
            FORMATS[problem.split],
            f"data {problem.digest()}",
            f"question {question_digest(problem)}",
            f"grid {exponents[0]} {exponents[1]}",
            f"claim {claim}",
            "",
        ]
    )


def question_digest(problem: Problem) -> str:
    """Return the sha256 of what is asked of the data: depth, costs, limits, sensors."""
    asked: tuple[object, ...] = (
        problem.depth,
        problem.split,
        problem.leaf_size,
        problem.leaf_penalty.hex(),
        [cost.hex() for cost in problem.costs.ravel().tolist()],
        problem.sensor_index.tolist(),
        [cost.hex() for cost in problem.sensor_costs.tolist()],
        problem.sensor_limit.hex(),
        _allowed(problem),
    )
    if problem.split == "hyperplane":
        asked += (problem.max_split_size, problem.allowed_splits)
    return hashlib.sha256(repr(asked).encode()).hexdigest()


def check_proof(problem: Problem, path: str | Path, *, bound: float = -math.inf, n_jobs: int = 1) -> ProofReport:
    """Check that a log proves a bound of every tree of a problem; refuse one that proves less than `bound`.

    `n_jobs` threads check logs of two-feature trees; the checker of axis-aligned ones, made to be read, uses one.

    Raises:
        ProblemError: trees of this kind have no proof logs.
        DataError: the log cannot be read.
        CertificateError: the log is of another problem, or does not prove what it claims; with the line and the reason.
    """
    start = time.perf_counter()
    check_provable(problem)
    log = read_bytes(path).decode("ascii", errors="replace")
    weight_exponent, cost_exponent, claim = _header(problem, log.split("\n", 5), path)
    proven = _proven(claim, weight_exponent + cost_exponent, path)
    native = _on_grid(problem, weight_exponent, cost_exponent, path)
    if problem.split == "axis":
        refusal = _native.check(native, log, 5, claim)
    else:
        refusal = _native.check_lines(native, log, 5, claim, n_jobs)
    if refusal is not None:
        raise _refused(path, *refusal)
    if proven < bound:
        raise _refused(path, 5, f"the log proves {proven} but {bound} is claimed for the tree")
    return ProofReport(proven, log.count("\n"), len(log), time.perf_counter() - start)


def check_provable(problem: Problem) -> None:
    """Raise a `ProblemError` if trees of a problem's kind have no proof logs."""
    if problem.split == "hyperplane" and (problem.depth > MOST_DEPTH or problem.max_split_size > MOST_FEATURES):
        raise ProblemError(
            f"depth {problem.depth} with {problem.max_split_size} features a split has no proof log; expected depth "
            f"{MOST_DEPTH} and {MOST_FEATURES} features at most, or split='axis'"
        )


def _refused(path: str | Path, line: int, reason: str) -> CertificateError:
    return CertificateError(f"{path}, line {line}: {reason}; the proof is refused")


def _header(problem: Problem, lines: list[str], path: str | Path) -> tuple[int, int, int]:
    """Return the exponents of the grid and the claim."""
    expected = [FORMATS[problem.split], f"data {problem.digest()}", f"question {question_digest(problem)}"]
    meaning = ["a proof log", "the samples, labels and weights of the problem", "its depth, costs, limits and sensors"]
    for number, (line, wanted) in enumerate(zip(lines, expected, strict=False)):
        if line != wanted:
            raise _refused(path, number + 1, f"got {line[:80]!r}, expected {wanted!r} of {meaning[number]}")
    found = re.fullmatch(r"grid (-?\d{1,4}) (-?\d{1,4})\nclaim (\d{1,19})", "\n".join(lines[3:5]))
    if found is None or max(abs(int(exponent)) for exponent in found.group(1, 2)) > MOST_EXPONENT:
        got = [line[:80] for line in lines[3:5]]
        raise _refused(path, 4, f"got {got}, expected 'grid' with two exponents, then 'claim' with a whole number")
    return int(found[1]), int(found[2]), int(found[3])


def _proven(claim: int, exponent: int, path: str | Path) -> float:
    """Return the bound that a claim on the grid is, in the problem's own units."""
    if claim >= CAPACITY:
        raise _refused(path, 5, f"claim is {claim}, more than {CAPACITY}, which no tree may cost")
    try:
        return math.ldexp(claim, -exponent)
    except OverflowError as error:
        raise _refused(path, 4, f"on this grid the claim {claim} is beyond every number") from error


def _on_grid(problem: Problem, weight_exponent: int, cost_exponent: int, path: str | Path) -> _native.Problem:
    """Return the problem with weights, costs and penalty as whole numbers, rounded down."""
    with np.errstate(over="ignore", invalid="ignore"):  # beyond the capacity, NaN included, is refused below
        weights = np.floor(np.ldexp(problem.weights, weight_exponent))
        costs = np.floor(np.ldexp(problem.costs, cost_exponent))
        penalty = float(np.floor(np.ldexp(problem.leaf_penalty, weight_exponent + cost_exponent)))
        most = float(weights.sum() * max(costs.max(), 1.0))
    penalty = min(penalty, most + 1.0)  # rounded down, too: above every other cost it forbids splits all the same
    if not most < CAPACITY:
        raise _refused(path, 4, f"on this grid a tree may cost {most}, more than {CAPACITY}")
    ranks = [np.unique(column, return_inverse=True)[1] for column in problem.features.T]
    return _native.Problem(
        np.array(ranks, dtype=np.uint32),
        [int(column.max()) + 1 for column in ranks],
        problem.codes.astype(np.uint32),
        weights.astype(np.int64),
        costs.astype(np.int64),
        int(penalty),
        problem.depth,
        problem.leaf_size,
        problem.sensor_index.tolist(),
        problem.sensor_costs.tolist(),
        problem.sensor_limit,
        _allowed(problem),
        _planes(problem),
    )


def _planes(problem: Problem) -> tuple[NDArray[np.float64], int, list[list[int]] | None, None] | None:
    """Return values and groups of features; a bound over real coefficients holds for whole-numbered ones, too."""
    if problem.max_split_size == 1:
        return None
    groups = problem.allowed_splits
    members = None if groups is None else [[int(feature) for feature in group] for group in groups]
    return np.ascontiguousarray(problem.features), problem.max_split_size, members, None


def _allowed(problem: Problem) -> list[bool]:
    return [problem.is_allowed((feature,)) for feature in range(problem.n_features)]
