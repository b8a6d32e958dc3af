"""Proof logs: a file that shows, to a checker that knows no solver, that no tree of a problem costs less than claimed.

The header binds the log to one problem and names whole numbers that its costs are not below, so that a bound of theirs
is one of the problem: weights and costs times powers of two, rounded down, or (format 2) numbers that are compared with
the true ones one by one. The body is checked by the native `check`, short files that share no code with the solvers.
Format and proofs: docs/theory/proof.md; for splits over two features, docs/theory/oblique.md.
"""

import hashlib
import math
import sys
import time
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip import _native
from octmip.encoding import IntegerCosts
from octmip.errors import CertificateError, ProblemError
from octmip.files import read_bytes
from octmip.problem import Problem

# First line of a log, by the kind of split; of format 2, in which the whole numbers are written out, likewise.
FORMATS = {"axis": "octmip-proof 1", "hyperplane": "octmip-proof 1 two-feature"}
WRITTEN_OUT = {"axis": "octmip-proof 2", "hyperplane": "octmip-proof 2 two-feature"}
NUMBERS = ("grid", "costs", "rows", "weights", "penalty", "claim")  # lines of format 2
MOST_DEPTH, MOST_FEATURES = 2, 2  # of trees of two-feature splits that have logs
# Sums of costs on the grid stay below it, so that they fit into 64 bits with room for every sum of three.
CAPACITY = 2.0**61
MOST_EXPONENT = 2200  # of a unit: the least product of two float64 is 2^-2148


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


def log_header(problem: Problem, costs: IntegerCosts, claim: int) -> str:
    """Return the first lines of a log that proves `claim`: numbers that were rounded are written out."""
    if not costs.is_rounded:
        return proof_header(
            problem,
            math.ldexp(1.0, -costs.weight_exponent),
            math.ldexp(1.0, costs.weight_exponent - costs.exponent),
            claim,
        )
    numbers = (
        [costs.exponent],
        costs.costs[:, : problem.n_classes].ravel().tolist(),
        costs.rows.tolist(),
        costs.weights.tolist(),
        [costs.penalty],
        [claim],
    )
    lines = [" ".join(map(str, [name, *line])) for name, line in zip(NUMBERS, numbers, strict=True)]
    return "\n".join([WRITTEN_OUT[problem.split], *_identity(problem), *lines, ""])


def _identity(problem: Problem) -> list[str]:
    return [f"data {problem.digest()}", f"question {question_digest(problem)}"]


def proof_header(problem: Problem, weight_unit: float, cost_unit: float, claim: int) -> str:
    """Return the first lines of a log that proves `claim`, in whole multiples of ``weight_unit * cost_unit``.

    The units are powers of two: weights count in `weight_unit`, costs in `cost_unit`, rounded down.
    """
    exponents = [-round(math.log2(unit)) for unit in (weight_unit, cost_unit)]
    grid = f"grid {exponents[0]} {exponents[1]}"
    return "\n".join([FORMATS[problem.split], *_identity(problem), grid, f"claim {claim}", ""])


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
    is_written_out = log.startswith(WRITTEN_OUT[problem.split] + "\n")
    read = _read_numbers if is_written_out else _read_grid
    native, claim, n_lines, proven = read(problem, log, path)
    if problem.split == "axis":
        refusal = _native.check(native, log, n_lines, claim)
    else:
        refusal = _native.check_lines(native, log, n_lines, claim, n_jobs)
    if refusal is not None:
        raise _refused(path, *refusal)
    if proven < bound:
        raise _refused(path, n_lines, f"the log proves {proven} but {bound} is claimed for the tree")
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


# The whole-numbered problem, the claim, the lines of the header, and what the claim is worth in the problem's units.
_Header = tuple[_native.Problem, int, int, float]


def _check_identity(problem: Problem, lines: list[str], first: str, path: str | Path) -> None:
    meaning = ["a proof log", "the samples, labels and weights of the problem", "its depth, costs, limits and sensors"]
    for number, (line, wanted) in enumerate(zip(lines, [first, *_identity(problem)], strict=False)):
        if line != wanted:
            raise _refused(path, number + 1, f"got {line[:80]!r}, expected {wanted!r} of {meaning[number]}")


def _read_grid(problem: Problem, log: str, path: str | Path) -> _Header:
    """Read format 1: weights, costs and penalty times powers of two, rounded down."""
    lines = log.split("\n", 5)
    _check_identity(problem, lines, FORMATS[problem.split], path)
    named = zip([*lines[3:5], "", ""], ("grid", "claim"), (MOST_EXPONENT, CAPACITY), strict=False)
    grid, claim = (_whole_numbers(*line) for line in named)
    if (len(grid), len(claim)) != (2, 1):
        got = [line[:80] for line in lines[3:5]]
        raise _refused(path, 4, f"got {got}, expected 'grid' with two exponents, then 'claim' with a whole number")
    native = _on_grid(problem, grid[0], grid[1], path)
    return native, claim[0], 5, _rounded_down(claim[0] * _power(-grid[0] - grid[1]))


def _on_grid(problem: Problem, weight_exponent: int, cost_exponent: int, path: str | Path) -> _native.Problem:
    with np.errstate(over="ignore", invalid="ignore"):  # beyond the capacity, NaN included, is refused below
        weights = np.floor(np.ldexp(problem.weights, weight_exponent))
        costs = np.floor(np.ldexp(problem.costs, cost_exponent))
        penalty = float(np.floor(np.ldexp(problem.leaf_penalty, weight_exponent + cost_exponent)))
        most = float(weights.sum()) * max(float(costs.max()), 1.0)
    penalty = min(penalty, most + 1.0)  # rounded down, too: above every other cost it forbids splits all the same
    if not (most < CAPACITY and costs.max() < CAPACITY):
        raise _refused(path, 4, f"on this grid a tree may cost {most}, more than {CAPACITY}")
    return _native_problem(problem, problem.codes, weights.astype(np.int64), costs.astype(np.int64), int(penalty))


def _read_numbers(problem: Problem, log: str, path: str | Path) -> _Header:
    """Read format 2: whole numbers, each compared with the true one, and what the cheapest answers cost besides."""
    n_lines = 3 + len(NUMBERS)
    lines = log.split("\n", n_lines)
    _check_identity(problem, lines, WRITTEN_OUT[problem.split], path)
    numbers = {}
    for number, name in enumerate(NUMBERS, 4):
        line = lines[number - 1] if len(lines) >= number else ""
        numbers[name] = _whole_numbers(line, name, MOST_EXPONENT if name == "grid" else CAPACITY)
        if not numbers[name] or (name in ("grid", "penalty", "claim") and len(numbers[name]) > 1):
            raise _refused(path, number, f"got {line[:80]!r}, expected {name!r} and whole numbers within range")
    (exponent,), (penalty,), (claim,) = (numbers[name] for name in ("grid", "penalty", "claim"))
    k = problem.n_classes
    table = [numbers["costs"][start : start + k] for start in range(0, len(numbers["costs"]), k)]
    _check_below(problem, table, numbers["rows"], numbers["weights"], exponent, path)
    if penalty > Fraction(problem.leaf_penalty) * _power(exponent) or penalty >= CAPACITY:
        raise _refused(path, 8, f"the penalty {penalty} is above the problem's, {problem.leaf_penalty}")
    # Columns beyond the classes are no answers: as expensive as the worst.
    square = [row + [max(row)] * (len(table) - k) for row in table]
    row, weight, cost = (np.array(values, dtype=np.int64) for values in (numbers["rows"], numbers["weights"], square))
    proven = _unavoidable(problem) + claim * _power(-exponent)
    return _native_problem(problem, row, weight, cost, penalty), claim, n_lines, _rounded_down(proven)


def _check_below(
    problem: Problem, table: list[list[int]], rows: list[int], weights: list[int], exponent: int, path: str | Path
) -> None:
    """Refuse a weight times a cost that is above what the answer costs more than the cheapest one does."""
    n, k = problem.n_samples, problem.n_classes
    if len(table) < k or len(table[-1]) != k or not len(rows) == len(weights) == n or max(rows) >= len(table):
        raise _refused(
            path, 5, f"expected {k} or more rows of {k} costs, and for each of {n} samples a row and a weight"
        )
    exact = [[Fraction(cost) for cost in row] for row in problem.costs.tolist()]
    dearer = [[(cost - min(row)) * _power(exponent) for cost in row] for row in exact]
    total, seen = 0, set()
    for sample, (row, weight, c, true) in enumerate(
        zip(rows, weights, problem.codes.tolist(), problem.weights.tolist(), strict=True)
    ):
        total += weight * max(table[row])
        if (entry := (row, weight, c, true)) in seen:
            continue
        seen.add(entry)
        above, below = true.as_integer_ratio()
        for label, cost in enumerate(table[row]):
            most = dearer[c][label]
            if weight * cost * below * most.denominator > above * most.numerator:
                raise _refused(path, 7, f"sample {sample}, class {label}: {weight} x {cost} is above the true cost")
    if total >= CAPACITY:
        raise _refused(path, 7, f"with these weights a tree may cost {total}, more than {CAPACITY}")


def _unavoidable(problem: Problem) -> Fraction:
    """Return what the cheapest answer to every sample costs, in exact arithmetic."""
    total = Fraction(0)
    for c, cheapest in enumerate(problem.costs.min(axis=1).tolist()):
        ratios = [weight.as_integer_ratio() for weight in problem.weights[problem.codes == c].tolist() if cheapest]
        below = max((denominator for _, denominator in ratios), default=1)
        total += Fraction(sum(above * (below // own) for above, own in ratios), below) * Fraction(cheapest)
    return total


def _whole_numbers(line: str, name: str, below: float = CAPACITY) -> list[int]:
    """Return the numbers of a line after its name; none where it is not of that name, or a number is not in range."""
    first, *words = line.split(" ")
    signless = [word.removeprefix("-") if name == "grid" else word for word in words]
    fits = all(word.isdecimal() and len(word) < 20 and int(word) < below for word in signless)
    return [int(word) for word in words] if fits and first == name else []


def _power(exponent: int) -> Fraction:
    return Fraction(2) ** exponent


def _rounded_down(exact: Fraction) -> float:
    """Return the largest float64 not above a number."""
    nearest = float(min(exact, Fraction(sys.float_info.max)))
    return nearest if Fraction(nearest) <= exact else math.nextafter(nearest, -math.inf)


def _native_problem(
    problem: Problem, rows: NDArray[np.int64], weights: NDArray[np.int64], costs: NDArray[np.int64], penalty: int
) -> _native.Problem:
    ranks = [np.unique(column, return_inverse=True)[1] for column in problem.features.T]
    return _native.Problem(
        np.array(ranks, dtype=np.uint32),
        [int(column.max()) + 1 for column in ranks],
        rows.astype(np.uint32),
        weights,
        costs,
        penalty,
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
