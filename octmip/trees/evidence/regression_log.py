"""Proof logs of axis-aligned regression trees: written by a search in whole numbers, bound to one problem.

Header and body are checked by `octmip_check::regression`, which knows no solver and puts targets and weights on the
grid of the header by itself. Format, inequalities and what rounding costs: docs/theory/regression.md.
"""

import math
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import numpy as np

from octmip.errors import SolverError
from octmip.input.files import write_bytes
from octmip.trees import _native
from octmip.trees.encoding.costs import power_of_two, whole_exponent
from octmip.trees.evidence.far_targets import FARTHEST, reach
from octmip.trees.question.problem import Problem

FORMAT = "octmip-proof 3 regression"
"""First words of a log; the spelling of the loss stands behind them."""
SUM_BITS, COST_BITS, WEIGHT_BITS = 52, 59, 26
"""Sums of weighted targets, costs and sums of weights that are not whole stay below 2 to the power of so many."""


def checker_question(problem: Problem) -> _native.RegressionQuestion:
    """Return the problem as the checker reads it: values, targets and weights as they were given."""
    shape = problem.shape
    return _native.RegressionQuestion(
        features=np.ascontiguousarray(problem.samples.features),
        targets=np.ascontiguousarray(problem.samples.targets),
        weights=np.ascontiguousarray(problem.samples.weights),
        slopes=problem.number_loss.slopes,
        depth=shape.depth,
        leaf_size=shape.leaf_size,
        leaf_penalty=shape.leaf_penalty,
        sensor_of_feature=shape.sensor_index.tolist(),
        sensor_cost=shape.sensor_costs.tolist(),
        sensor_limit=shape.sensor_limit,
    )


def write_proof(path: str | Path, problem: Problem, wanted: Fraction) -> float:
    """Write a log that proves that trees cost `wanted`, or what the best one costs; return the bound it proves.

    Raises
    ------
    SolverError
        writing was interrupted.
    DataError
        the file cannot be written.
    """
    question, scale = checker_question(problem), log_scale(problem, float(wanted))
    slopes = problem.number_loss.slopes
    power, over = (2, 1) if slopes is None else (1, slopes.over)
    unit = power_of_two(scale.weight + power * scale.target - scale.cost) * over
    found = question.prove(scale, min(2**60, math.floor(wanted * unit)))
    if found is None:
        raise SolverError(f"the proof of {float(wanted)} was interrupted; {path} is not written")
    loss, data, asked = question.identity()
    grid = " ".join(map(str, scale))
    header = f"{FORMAT} {loss}\ndata {data}\nquestion {asked}\ngrid {grid}\nclaim {found.claim}\n"
    write_bytes(path, (header + found.body + "end\n").encode("ascii"))
    return found.bound


class LogScale(NamedTuple):
    """Exponents of the grid of a log: a weight counts in units of ``2**-weight``, and so on."""

    weight: int
    target: int
    cost: int
    reach: int


def log_scale(problem: Problem, wanted: float) -> LogScale:
    """Return the exponents of weights, targets, costs and reach: as fine a grid as the checker has room for."""
    exponent = whole_exponent(problem.samples.weights)
    total = _bits(problem.samples.weights, exponent)
    if total > WEIGHT_BITS:
        exponent -= total - WEIGHT_BITS
        total = WEIGHT_BITS
    farthest = reach(problem, wanted)
    gaps = np.minimum(np.diff(np.unique(problem.samples.targets)), math.ldexp(1.0, min(farthest, 1000)))
    if not len(gaps):
        return LogScale(exponent, 0, 0, FARTHEST)
    # Gaps and their sum are rounded.
    finest = SUM_BITS - total - math.frexp(math.fsum(gaps) * (1 + 1e-12))[1]
    if (slopes := problem.number_loss.slopes) is not None:
        return LogScale(exponent, finest - (slopes.steepest - 1).bit_length(), 0, farthest)
    return LogScale(exponent, finest, max(0, total + 2 * (SUM_BITS - total) - COST_BITS), farthest)


def _bits(weights: np.ndarray[tuple[int, ...], np.dtype[np.float64]], exponent: int) -> int:
    """Return b with the sum of the weights, times 2**exponent, below 2**b."""
    return math.frexp(math.fsum(weights))[1] + exponent + 1
