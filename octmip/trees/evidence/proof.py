"""Proof logs: a file that proves, to a checker without a solver, that no tree of a problem costs less than claimed.

The header binds the log to one problem and names whole numbers that its costs are not below, so that a bound of theirs
is one of the problem: weights and costs times powers of two, rounded down, or numbers that are compared with the true
ones one by one. Header and body are checked by the crate octmip-check; cargo enforces that it depends on no
solver, nor on any other crate. The solvers depend on it: the two-feature solver writes its logs with the checker's own
regions, coordinates and dichotomies. Here the checker gets the problem as it was given. Format and proofs:
docs/theory/proof.md; for splits over two features, docs/theory/two-feature.md. Where readings are missing the log
counts in columns (docs/theory/missing.md), which the checker makes by itself from the readings.
"""

import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from octmip.errors import CertificateError, ProblemError
from octmip.input.files import read_bytes
from octmip.trees import _native
from octmip.trees.encoding import IntegerCosts
from octmip.trees.evidence import regression_log
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_file import data_digest, question_digest
from octmip.trees.question.problem_values import refuse_missing

FORMATS = {"axis": "octmip-proof 3", "hyperplane": "octmip-proof 3 two-feature"}
"""First line of a log, by `Shape.split`; where readings are missing " missing" stands behind it."""
MOST_DEPTH, MOST_FEATURES = 2, 2  # of trees of two-feature splits that have logs

NO_THREAD = "no thread to check on"
"""How the checker refuses a log where it gets no memory for a thread."""


@dataclass(frozen=True, slots=True)
class ProofReport:
    """The result of a checked log.

    Attributes
    ----------
    bound
        no tree of the problem costs less.
    n_lines, n_bytes
        size of the log.
    seconds
        that checking took, wall time [s].
    """

    bound: float
    n_lines: int
    n_bytes: int
    seconds: float


def log_header(problem: Problem, costs: IntegerCosts, claim: int) -> str:
    """Return the first lines of a log that proves `claim`: numbers that were rounded are written out."""
    if not costs.is_rounded:
        return proof_header(problem, (costs.weight_exponent, costs.exponent - costs.weight_exponent), claim)
    numbers = {
        "unit": [costs.exponent],
        "costs": costs.costs[:, : problem.samples.n_classes].ravel().tolist(),
        "rows": costs.rows.tolist(),
        "weights": costs.weights.tolist(),
        "penalty": [costs.penalty],
    }
    lines = [" ".join(map(str, [name, *line])) for name, line in numbers.items()]
    return "\n".join([*_identity(problem), *lines, f"claim {claim}", ""])


def proof_header(problem: Problem, exponents: tuple[int, int], claim: int) -> str:
    """Return the first lines of a log that proves `claim`, weights and costs times 2**exponent each, rounded down."""
    return "\n".join([*_identity(problem), f"grid {exponents[0]} {exponents[1]}", f"claim {claim}", ""])


def _identity(problem: Problem) -> list[str]:
    missing = " missing" if problem.samples.n_missing else ""
    return [
        f"{FORMATS[problem.shape.split]}{missing}",
        f"data {data_digest(problem)}",
        f"question {question_digest(problem)}",
    ]


def check_proof(problem: Problem, path: str | Path, *, bound: float = -math.inf, n_jobs: int = 1) -> ProofReport:
    """Check that a log proves a bound of every tree of a problem; refuse one that proves less than `bound`.

    `n_jobs` threads check the parts of a log; that of a regression tree takes one.

    Raises
    ------
    ProblemError
        such trees have no proof logs.
    DataError
        the log cannot be read.
    CertificateError
        the log is of another problem, or does not prove what it claims; with the line and the reason.
    """
    start = time.perf_counter()
    check_provable(problem)
    content = read_bytes(path)
    text = content.decode("ascii", errors="replace")
    if problem.loss.predicts == "number":
        found = regression_log.checker_question(problem).check(text)
    else:
        found = checker_question(problem).check(text, n_jobs)
    if isinstance(found, _native.Refused):
        if found.reason.startswith(NO_THREAD):
            raise MemoryError(found.reason)
        raise _refused(path, found.line, found.reason)
    if found.bound < bound:
        raise _refused(path, found.claim_line, f"the log proves {found.bound} but {bound} is claimed for the tree")
    return ProofReport(found.bound, found.n_lines, len(content), time.perf_counter() - start)


def check_provable(problem: Problem) -> None:
    """Raise a `ProblemError` if the trees of a problem have no proof logs."""
    shape = problem.shape
    if not problem.is_provable:
        raise ProblemError(
            f"split is {shape.split!r} and leaf_model {shape.leaf_model!r}, which have no proof log; "
            "expected axis-aligned regression trees with one number in each leaf; leave the log out"
        )
    if shape.is_shaped or shape.any_depth or shape.leaf_weight is not None:
        raise ProblemError(
            "a proof log has no lines for the bounds of given parts, an order, a number of splits, a weight of leaves "
            "or trees without a depth; leave the log out, or ask for a depth alone"
        )
    if shape.split == "hyperplane":
        refuse_missing(problem.samples.n_missing, "hyperplanes add readings", "use split='axis', or fill them in")
    if shape.split == "hyperplane" and (shape.depth > MOST_DEPTH or shape.max_split_size > MOST_FEATURES):
        raise ProblemError(
            f"depth {shape.depth} with {shape.max_split_size} features per split has no proof log; "
            f"expected depth {MOST_DEPTH} and {MOST_FEATURES} features at most, or split='axis'"
        )


def _refused(path: str | Path, line: int, reason: str) -> CertificateError:
    return CertificateError(f"{path}, line {line}: {reason}; the proof is refused")


def checker_question(problem: Problem) -> _native.Question:
    """Return the problem as the checker reads it: values, weights and costs as they were given."""
    shape = problem.shape
    groups = shape.allowed_splits
    return _native.Question(
        features=np.ascontiguousarray(problem.samples.features, dtype=np.float64),
        labels=problem.samples.codes.astype(np.uint32),
        weights=np.ascontiguousarray(problem.samples.weights),
        costs=np.ascontiguousarray(problem.costs),
        depth=shape.depth,
        is_hyperplane=shape.split == "hyperplane",
        split_size=shape.max_split_size,
        leaf_size=shape.leaf_size,
        leaf_penalty=shape.leaf_penalty,
        sensor_of_feature=shape.sensor_index.tolist(),
        sensor_cost=shape.sensor_costs.tolist(),
        sensor_limit=shape.sensor_limit,
        allowed_splits=None if groups is None else [[int(feature) for feature in group] for group in groups],
    )
