"""Sensors chosen without the best tree, by rules and designs of experiment: the comparison for a placement by tree.

by_reading      the highest readings: the ad-hoc choice, where the signal is strong
by_chance       at random
by_information  D-optimal: least volume of the error ellipsoid of the parameters, by convex relaxation
by_tree         forward selection: the sensor with which a quick tree errs least, one after the other

Each returns names of sensors that cost the budget at most.
Sources: Joshi & Boyd (2009), Sensor selection via convex optimization, IEEE Transactions on Signal Processing 57, for
the relaxation; Chepuri & Leus (2015), Sparsity-promoting sensor selection for non-linear measurement models, the same
journal, 63, for readings that are not linear in the parameters.
"""

import importlib
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError, SolverError, needed_by
from octmip.sensing.placement import problem_on
from octmip.trees.methods.options import Options, SearchOptions
from octmip.trees.problem import Problem
from octmip.trees.registry import Method
from octmip.trees.solution import Limits
from octmip.trees.solver import solve

QUICK = SearchOptions(restarts=1, perturbations=0)
QUICK_NODES = 10  # visits to a node: the trial trees of a forward selection are many


def by_reading(problem: Problem, budget: float) -> tuple[str, ...]:
    """Return the sensors of highest mean absolute reading (of a sensor's features the highest)."""
    strength = np.zeros(len(problem.sensors))
    np.maximum.at(strength, problem.sensor_index, np.abs(problem.features).mean(axis=0, dtype=np.float64))
    return _affordable(problem, np.argsort(-strength, kind="stable"), budget)


def by_chance(problem: Problem, budget: float, rng: np.random.Generator) -> tuple[str, ...]:
    """Return sensors in a random order while they can be paid for."""
    return _affordable(problem, rng.permutation(len(problem.sensors)), budget)


@dataclass(frozen=True, slots=True)
class InformationDesign:
    """A D-optimal choice.

    Attributes
    ----------
    sensors
        names.
    log_det
        mean over states of log det of the information of those sensors (parameters scaled, see below).
    relaxed_log_det
        of the relaxation, the gap of its dual added: no choice within the budget has more.
    shares
        (n_sensors,) of the relaxation, 0 to 1; the sensors are those of largest share.
    """

    sensors: tuple[str, ...]
    log_det: float
    relaxed_log_det: float
    shares: tuple[float, ...]


def by_information(problem: Problem, budget: float, sensitivity: ArrayLike) -> InformationDesign:
    """Return the D-optimal sensors.

        maximise   mean over states s of  log det sum_j w_j F_sj      over 0 <= w <= 1, cost @ w <= budget
        F_sj = sum over the features of sensor j of g g^T,  g = d reading / d parameters in state s

    Rounding: sensors by falling w, ties in the order of the problem, each that can still be paid for.

    Parameters
    ----------
    problem
        whose sensors and costs they are; samples and labels play no part.
    budget
        of sensor costs.
    sensitivity
        (n_states, n_features, n_parameters) derivatives of the readings, or (n_features, n_parameters) for one state;
        noise is taken as equal in all features. Parameters are scaled to a root mean square of 1, which changes no
        optimum.

    Raises
    ------
    ProblemError
        shapes do not fit, or the sensors cannot tell the parameters apart within the budget.
    SolverError
        the relaxation was not solved.
    MissingExtraError
        cvxpy is not installed.
    """
    gradients = _scaled(problem, sensitivity)
    information = np.zeros((len(gradients), len(problem.sensors), *gradients.shape[2:], gradients.shape[2]))
    for j, sensor in enumerate(problem.sensor_index):
        information[:, sensor] += gradients[:, j, :, None] * gradients[:, j, None, :]
    if budget <= 0 or (np.linalg.matrix_rank(information.sum(axis=1), hermitian=True) < gradients.shape[2]).any():
        raise ProblemError(
            f"no sensors within the budget of {budget} tell all {gradients.shape[2]} parameters apart in every state; "
            "give a budget above 0, or leave a parameter out"
        )
    shares, relaxed = _relaxation(information, problem.sensor_costs, budget)
    sensors = _affordable(problem, np.argsort(-shares, kind="stable"), budget)
    chosen = [problem.sensors.index(name) for name in sensors]
    of_chosen = information[:, chosen].sum(axis=1)
    if (np.linalg.matrix_rank(of_chosen, hermitian=True) < gradients.shape[2]).any():
        raise ProblemError(
            f"the sensors {', '.join(sensors) or 'none'} that a budget of {budget} pays for do not tell all "
            f"{gradients.shape[2]} parameters apart in every state; give a larger budget, or leave a parameter out"
        )
    log_det = np.linalg.slogdet(of_chosen)[1]
    return InformationDesign(sensors, float(log_det.mean()), relaxed, tuple(shares.tolist()))


def _scaled(problem: Problem, sensitivity: ArrayLike) -> NDArray[np.float64]:
    given = np.array(sensitivity, dtype=np.float64)
    gradients = given[None] if given.ndim == 2 else given
    if gradients.ndim != 3 or gradients.shape[1] != problem.n_features or not np.isfinite(gradients).all():
        raise ProblemError(
            f"sensitivity has shape {given.shape}; expected finite (n_states, {problem.n_features}, n_parameters)"
        )
    scale = np.sqrt((gradients**2).mean(axis=(0, 1)))
    if (scale == 0).any():
        raise ProblemError(f"no reading depends on parameter {int(scale.argmin())}; leave it out of sensitivity")
    return np.asarray(gradients / scale)


def _relaxation(
    information: NDArray[np.float64], costs: NDArray[np.float64], budget: float
) -> tuple[NDArray[np.float64], float]:
    """Return shares (n_sensors,) and mean log det of the relaxation of information (n_states, n_sensors, p, p)."""
    with needed_by("a D-optimal design"):
        cp: Any = importlib.import_module("cvxpy")  # it takes a second, and only this design needs it
    n_states, n_sensors, p, _ = information.shape
    shares = cp.Variable(n_sensors)
    flat = information.reshape(n_states, n_sensors, p * p)
    value = sum(cp.log_det(cp.reshape(matrix.T @ shares, (p, p), order="C")) for matrix in flat) / n_states
    relaxation = cp.Problem(cp.Maximize(value), [shares >= 0, shares <= 1, costs @ shares <= budget])
    try:
        relaxation.solve(solver=cp.CLARABEL)
    except cp.error.SolverError as error:
        raise SolverError(f"the relaxation of the D-optimal design failed: {error}") from error
    if shares.value is None or not math.isfinite(relaxation.value):
        raise SolverError(f"the relaxation of the D-optimal design ended {relaxation.status!r}; expected an optimum")
    found = np.clip(shares.value, 0.0, 1.0)
    return found, _upper_bound(information, costs, budget, found)


def _upper_bound(
    information: NDArray[np.float64], costs: NDArray[np.float64], budget: float, shares: NDArray[np.float64]
) -> float:
    """Return what the mean log det of no shares within the budget exceeds, shown by shares that need not be optimal.

    The log det is concave, so its tangent at any shares lies above it:
        f(v) <= f(w) + g @ (v - w),     g_j = mean over states of trace(M_s(w)^-1 F_sj),     M_s(w) = sum_j w_j F_sj
    and g @ v is largest, within 0 <= v <= 1 and the budget, for the sensors that give most for their cost.
    """
    matrices = np.einsum("j,sjkl->skl", shares, information)
    value = float(np.linalg.slogdet(matrices)[1].mean())
    gradient = np.einsum("skl,sjlk->sj", np.linalg.inv(matrices), information).mean(axis=0)
    left, most = budget * (1 + 1e-9) + 1e-9, 0.0  # choices may exceed the budget by so much: `_payable`
    with np.errstate(divide="ignore", invalid="ignore"):
        by_worth = np.argsort(-gradient / costs, kind="stable")
    for j in by_worth.tolist():
        share = 1.0 if costs[j] <= left else left / float(costs[j])
        most, left = most + share * float(gradient[j]), max(0.0, left - share * float(costs[j]))
    # The tangent meets the log det at w, where g @ w is the number of parameters.
    bound = value + most - float(gradient @ shares)
    return bound + 1e-12 * (abs(value) + float(information.shape[2]) + most)


def by_tree(
    problem: Problem,
    budget: float,
    *,
    rows: int | None = None,
    method: Method = "search",
    limits: Limits = Limits(nodes=QUICK_NODES),  # noqa: B008 (frozen)
    seed: int = 0,
    options: Options = QUICK,
) -> tuple[str, ...]:
    """Return sensors by forward selection: each time the one with which, beside those chosen, a quick tree errs least.

    Of equals the cheapest, then the first. It ends when no further sensor can be paid for.

    Parameters
    ----------
    problem
        its tree is tried.
    budget
        of sensor costs.
    rows
        so many samples judge the trials, every class by its share; None: all.
    method, limits, seed, options
        of the trial trees.
    """
    judged = _thinned(problem, rows, seed)
    chosen: list[str] = []
    while candidates := _payable(problem, chosen, budget):
        trials = []
        for name in candidates:
            part = problem_on(judged, [*chosen, name])
            found = solve(replace(part, sensor_budget=None), method, limits, None, seed, 1, None, options)
            s = problem.sensors.index(name)
            trials.append((found.objective, float(problem.sensor_costs[s]), s))
        chosen.append(problem.sensors[min(trials)[2]])
    return _in_order(problem, chosen)


def _thinned(problem: Problem, rows: int | None, seed: int) -> Problem:
    """Return the problem with `rows` samples, dealt out evenly over the classes."""
    if rows is None or rows >= problem.n_samples:
        return problem
    if rows < 2:
        raise ProblemError(f"rows is {rows}; expected 2 or more; give None for all samples")
    shuffled = np.random.default_rng(seed).permutation(problem.n_samples)
    by_class = shuffled[np.argsort(problem.codes[shuffled], kind="stable")]
    kept = np.sort(by_class[np.linspace(0, problem.n_samples - 1, rows).round().astype(np.int64)])
    return replace(
        problem,
        features=problem.features[kept],
        targets=problem.targets[kept],
        weights=problem.weights[kept],
        leaf_size=1,
        leaf_weight=None,
    )


def _payable(problem: Problem, chosen: Iterable[str], budget: float) -> list[str]:
    """Return the sensors that can be paid for beside those chosen."""
    costs = dict(zip(problem.sensors, problem.sensor_costs.tolist(), strict=True))
    bought = list(chosen)
    limit = budget + 1e-9 * max(1.0, budget)
    return [
        s for s in problem.sensors if s not in bought and math.fsum([costs[s], *(costs[b] for b in bought)]) <= limit
    ]


def _affordable(problem: Problem, ranking: NDArray[np.int64], budget: float) -> tuple[str, ...]:
    """Return the sensors of a ranking, the best first, each that can still be paid for."""
    chosen: list[str] = []
    for s in ranking:
        if problem.sensors[int(s)] in _payable(problem, chosen, budget):
            chosen.append(problem.sensors[int(s)])
    return _in_order(problem, chosen)


def _in_order(problem: Problem, chosen: Iterable[str]) -> tuple[str, ...]:
    kept = set(chosen)
    return tuple(name for name in problem.sensors if name in kept)
