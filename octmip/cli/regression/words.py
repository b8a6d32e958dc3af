"""Regression trees in words and as JSON objects."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.certificate import Certificate
from octmip.cli.regression.question import Errors
from octmip.formats.columns import Columns
from octmip.formats.names import shown, visible
from octmip.formats.tree_file import finite_or_none
from octmip.formats.tree_nodes import encode_tree
from octmip.problem import Problem
from octmip.report.text import condition, number, percent
from octmip.solution import Solution
from octmip.tree import Leaf, Node, prediction, tree_lines


def numbers_text(solution: Solution, certificate: Certificate, loss: str, n_samples: int) -> str:
    """Return what a solution claims and its certificate found, in three lines."""
    proof = "proven optimal" if solution.is_optimal else f"gap {percent(solution.gap)}"
    if solution.tolerance > 0:
        proof += f" within {solution.tolerance:.1g}"
    if math.isinf(solution.bound):
        proof = "no proof"
    splits = f"{certificate.n_splits} split" + ("" if certificate.n_splits == 1 else "s")
    sensors = f"sensors {', '.join(map(shown, certificate.sensors))}" if certificate.sensors else "no sensor"
    return (
        f"objective {number(solution.objective)}, bound {number(solution.bound)}: {proof} ({loss} error)\n"
        f"{n_samples} samples: mean absolute error {number(certificate.measures['mae'])}, root of the mean squared "
        f"error {number(certificate.measures['rmse'])}; depth {certificate.depth}, {splits}, {sensors}\n"
        f"{visible(solution.solver)} {visible(solution.version)}, {solution.seconds:.3g} s, stop: {solution.stop}"
    )


def numbers_tree_text(
    tree: Node, names: tuple[str, ...], leaf_counts: NDArray[np.int64], columns: Columns | None
) -> str:
    """Return a regression tree as indented lines, with the training samples of each leaf."""
    sizes = iter(leaf_counts[:, 0].tolist())

    def decision(leaf: Leaf) -> str:
        size = next(sizes)
        return f"{prediction(leaf, lambda j: shown(names[j]))}    ({size} sample{'s' * (size != 1)})"

    return "\n".join(tree_lines(tree, lambda split: condition(split, names, columns), decision))


def numbers_verdict(problem: Problem, solution: Solution, certificate: Certificate) -> str:
    """Return what is known of a tree in one sentence, for the last line on the screen."""
    off = f"mean absolute error {number(certificate.measures['mae'])}"
    if math.isinf(solution.bound):
        return f"Not proven optimal: {off}; the method {visible(solution.solver)} proves nothing about other trees."
    is_limited = problem.leaf_size > 1 or problem.sensor_budget is not None
    trees = f"tree of depth {problem.depth} or less with one number in each leaf"
    trees += " within the same limits" if is_limited else ""
    if solution.is_optimal:
        return f"Proven optimal: {off}; no {trees} has an objective below {number(solution.bound)}."
    least = number(solution.bound)
    return (
        f"Not proven optimal (stop: {solution.stop}, gap {percent(solution.gap)}): {off}; every {trees} has an "
        f"objective of {least} or more."
    )


def describe_numbers(problem: Problem, solution: Solution, certificate: Certificate) -> dict[str, Any]:
    """Return the JSON object of a solution: bound and gap are None without a proof."""
    assert solution.tree is not None
    return {
        "objective": solution.objective,
        "loss": problem.loss.name,
        **certificate.measures,
        "n_samples": problem.n_samples,
        "bound": finite_or_none(solution.bound),
        "gap": finite_or_none(solution.gap),
        "is_optimal": solution.is_optimal,
        "stop": str(solution.stop),
        "seconds": solution.seconds,
        "n_nodes": solution.n_nodes,
        "method": solution.solver,
        "version": solution.version,
        "seed": solution.seed,
        "depth": certificate.depth,
        "n_splits": certificate.n_splits,
        "sensors": list(certificate.sensors),
        "sensor_cost": certificate.sensor_cost,
        "baseline": problem.baseline,
        "normalised_objective": finite_or_none(certificate.normalised_objective),
        "tolerance": solution.tolerance,
        "tree": encode_tree(solution.tree, problem.feature_names, ()),
    }


def errors_json(errors: Errors) -> dict[str, Any]:
    """Return errors on samples as a JSON object."""
    return {"n_samples": errors.n_samples, "mae": errors.mae, "rmse": errors.rmse}


def errors_text(errors: Errors) -> str:
    """Return errors on samples in words."""
    return (
        f"{errors.n_samples} samples: mean absolute error {number(errors.mae)}, root of the mean squared error "
        f"{number(errors.rmse)}"
    )
