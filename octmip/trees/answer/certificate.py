"""Certificates: a solution's claims, recomputed from problem and tree alone. Imports no solver."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, ProblemError
from octmip.input.messages import InWords, several
from octmip.trees.answer.scope import scope_of
from octmip.trees.answer.solution import Solution, Stop, is_tolerable
from octmip.trees.nodes.order import disorder
from octmip.trees.nodes.tree import (
    HyperplaneSplit,
    Leaf,
    Node,
    ValueLeaf,
    complexity,
    depth,
    features_used,
    leaf_index,
    leaves,
    n_splits,
    splits,
)
from octmip.trees.question.part_check import broken_rule, missing_part, n_changes
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_values import words_of


@dataclass(frozen=True, slots=True)
class Certificate(InWords):
    """The figures of a tree, recounted sample by sample from the tree alone.

    Attributes
    ----------
    objective
        recomputed objective.
    normalised_objective
        cost divided by the baseline's, plus alpha * complexity with alpha = leaf_penalty / baseline; NaN where the
        baseline is 0. Source: Bertsimas & Dunn (2017), eq. 21.
    measures
        what people judge predictions by (`Loss.measures`): of classes "errors", the misclassified samples,
        unweighted; of numbers "mae" and "rmse", weighted, whichever the loss was.
    n_splits, depth
        of the tree.
    sensors, sensor_cost
        that it reads.
    bound, gap
        the solution's bound, consistent with the objective; whether it is a true bound is its solver's
        claim, or its proof log's (`octmip certify --proof`).
    scope
        the trees that the bound is about, in words: those of the problem with all its limits, or fewer.

    Examples
    --------
    >>> problem = Problem([[0], [1], [2]], ["a", "b", "a"], depth=1)
    >>> print(certify(problem, solve(problem)))
    recounted: objective 1, errors 1
    depth 0, splits 0; sensors: none
    bound 1, gap 0 %, of trees of depth 1 or less
    """

    objective: float
    normalised_objective: float
    measures: Mapping[str, float]
    n_splits: int
    depth: int
    sensors: tuple[str, ...]
    sensor_cost: float
    bound: float
    gap: float
    scope: str

    def __str__(self) -> str:
        """Return the figures in three lines: what was recounted, the tree, and what the bound is about."""
        measured = ", ".join(f"{name} {value:.6g}" for name, value in self.measures.items())
        tree = f"depth {self.depth}, splits {self.n_splits}; sensors: {several(self.sensors) or 'none'}"
        bound = f"bound {self.bound:.6g}, gap {100 * self.gap:.3g} %, of {self.scope}"
        return f"recounted: objective {self.objective:.6g}, {measured}\n{tree}\n{bound}"

    @property
    def errors(self) -> int:
        """Misclassified samples, unweighted, of a tree of classes."""
        return int(self.measures["errors"])

    def to_json(self) -> dict[str, Any]:
        """Return the figures by their names, what JSON has no number for as None."""
        fields = dataclasses.asdict(self)
        figures = {**fields.pop("measures"), **fields}
        return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in figures.items()}


def certify(problem: Problem, solution: Solution) -> Certificate:
    """Recompute what a solution claims and return it as a Certificate.

    Raises
    ------
    CertificateError
        the tree breaks a limit of the problem, or objective, bound or stop are not what they say.

    Examples
    --------
    >>> problem = Problem([[0], [1], [2]], ["a", "b", "a"], depth=2)
    >>> certify(problem, solve(problem)).errors
    0
    """
    tree = solution.tree
    if tree is None:
        raise CertificateError(f"{solution.solver} found no tree (stop: {solution.stop}); there is nothing to certify")
    checked_leaf_index(problem, tree)
    predicted = problem.predictions(tree)
    objective = problem.objective_of(tree, predicted)
    if math.isinf(objective):
        raise CertificateError(
            f"the tree of {solution.solver} costs more on the {problem.samples.n_samples} samples than float64 holds; "
            "expected predictions near the targets; tree and data do not belong together or one was changed"
        )
    _check_claims(problem, solution, objective)
    baseline = problem.baseline
    return Certificate(
        objective=objective,
        normalised_objective=objective / baseline if baseline > 0 else math.nan,
        measures=problem.measures(predicted),
        n_splits=n_splits(tree),
        depth=depth(tree),
        sensors=problem.shape.sensors_used(tree),
        sensor_cost=problem.shape.sensor_cost_of(tree),
        bound=solution.bound,
        gap=solution.gap,
        scope=scope_of(problem, solution),
    )


def checked_incumbent(problem: Problem, incumbent: Node | Solution | None) -> Node | None:
    """Return the incumbent's tree; None where there is no incumbent.

    Raises
    ------
    ProblemError
        it is no tree of the problem.
    """
    tree = incumbent.tree if isinstance(incumbent, Solution) else incumbent
    if tree is not None:
        try:
            checked_leaf_index(problem, tree)
        except CertificateError as error:
            raise ProblemError(f"the incumbent is no tree of this problem: {error}; leave it out") from error
    return tree


def checked_leaf_index(problem: Problem, tree: Node) -> NDArray[np.int64]:
    """Return the leaf that each sample reaches, numbered from the left, shape (n_samples,).

    Raises
    ------
    CertificateError
        the tree breaks a limit of the problem.
    """
    _check_tree(problem, tree)
    leaf = leaf_index(tree, problem.samples.features)
    _check_leaf_sizes(problem, tree, np.bincount(leaf, minlength=len(leaves(tree))))
    if problem.shape.leaf_weight is not None:
        _check_leaf_weights(problem, tree, leaf)
    return leaf


def leaf_counts(problem: Problem, tree: Node) -> NDArray[np.int64]:
    """Return the samples of each class in each leaf, leaves from the left, shape (n_leaves, n_classes).

    Of numbers the shape is (n_leaves, 1): all samples of each leaf.
    """
    samples = problem.samples
    counts = np.zeros((len(leaves(tree)), samples.n_classes or 1), dtype=np.int64)
    codes = samples.codes if samples.n_classes else np.zeros(samples.n_samples, dtype=np.int64)
    np.add.at(counts, (leaf_index(tree, samples.features), codes), 1)
    return counts


def shares_in_leaves(counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the share of each class in each leaf, from `leaf_counts`; 0 of a leaf without samples."""
    return np.asarray(counts / np.maximum(counts.sum(axis=1, keepdims=True), 1))


def _check_tree(problem: Problem, tree: Node) -> None:
    shape = problem.shape
    if depth(tree) > shape.depth and not shape.any_depth:
        raise CertificateError(f"the tree has depth {depth(tree)} but the problem allows {shape.depth}")
    if shape.max_splits is not None and complexity(tree) > shape.max_splits:
        counted = "splits" if shape.split == "axis" else "features in its splits"
        raise CertificateError(f"the tree has {complexity(tree)} {counted} but max_splits is {shape.max_splits}")
    forbidden = first_forbidden_split(problem, tree)
    if forbidden:
        raise CertificateError(forbidden)
    if shape.monotone is not None and (found := disorder(tree, shape.directions)) is not None:
        one, other, feature = found
        way = "falls" if shape.directions[feature] > 0 else "rises"
        raise CertificateError(
            f"the prediction {way} along {problem.samples.feature_names[feature]} between leaves {one} and {other} "
            f"(from the left), but monotone is {words_of(problem.samples.feature_names, shape.directions)}"
        )
    if shape.has_parts and (broken := _broken_part(problem, tree)) is not None:
        raise CertificateError(broken)
    if shape.sensor_cost_of(tree) > shape.sensor_limit:
        sensors, cost = several(shape.sensors_used(tree)), shape.sensor_cost_of(tree)
        raise CertificateError(
            f"the tree reads the sensors {sensors} of total cost {cost:g}, over the budget of {shape.sensor_budget:g}"
        )


def first_forbidden_split(problem: Problem, tree: Node) -> str | None:
    """Return a sentence about the first split or leaf that a problem does not allow, None if there is none."""
    samples = problem.samples
    used = features_used(tree)
    if used and used[-1] >= samples.n_features:
        return f"the tree reads feature {used[-1]} but the problem has {samples.n_features} features"
    with_missing = set(samples.features_with_missing) if samples.takes_missing else set()
    for split in splits(tree):
        names = [samples.feature_names[j] for j in split.features]
        if not problem.shape.is_allowed(split.features):
            return f"a split over {names} is not allowed (split_size {problem.shape.max_split_size}, allowed_splits)"
        if problem.shape.split == "axis" and isinstance(split, HyperplaneSplit):
            return f"a split over {names} is a hyperplane, which is not allowed: split is 'axis'"
        if isinstance(split, HyperplaneSplit) and not _is_integral(problem, split):
            return f"a split over {names} has coefficients {split.coefficients}, not integers within limits"
        if split.missing is None and with_missing.intersection(split.features):
            return f"a split over {names} has no side for missing readings, of which this problem has some"
    return next(filter(None, (_fault_of(problem, leaf) for leaf in leaves(tree))), None)


def _fault_of(problem: Problem, leaf: Leaf) -> str | None:
    if problem.loss.predicts == "class":
        if isinstance(leaf, ValueLeaf):
            return f"a leaf predicts the number {leaf.value}; expected a class in every leaf"
        is_known = leaf.label < problem.samples.n_classes
        return (
            None
            if is_known
            else f"a leaf predicts class {leaf.label} but the problem has {problem.samples.n_classes} classes"
        )
    if not isinstance(leaf, ValueLeaf):
        return f"a leaf predicts class {leaf.label}; expected a number in every leaf"
    if leaf.features and problem.shape.leaf_model == "constant":
        return f"a leaf is linear over features {leaf.features} but leaf_model is 'constant'"
    return None


def _is_integral(problem: Problem, split: HyperplaneSplit) -> bool:
    """Whether a hyperplane's coefficients are whole numbers where that is asked for."""
    most = problem.shape.integer_normals
    return most is None or all(c == math.floor(c) and abs(c) <= most for c in split.coefficients)


def _broken_part(problem: Problem, tree: Node) -> str | None:
    """Return a sentence about the first part that is asked for and a tree lacks; None where it has all."""
    shape = problem.shape
    broken = missing_part(tree, (shape.fixed_splits or ()), problem.samples.feature_names)
    if broken is None:
        broken = broken_rule(tree, (shape.path_rules or ()), problem.samples.feature_names)
    if broken is None and shape.max_changes is not None:
        changes = n_changes(tree, shape.old_tree)
        if changes > shape.max_changes:
            broken = f"the tree differs from old_tree at {changes} places but max_changes is {shape.max_changes}"
    return broken


def _check_leaf_sizes(problem: Problem, tree: Node, sizes: NDArray[np.int64]) -> None:
    smallest = int(sizes.argmin())
    if not isinstance(tree, Leaf) and sizes[smallest] < problem.shape.leaf_size:
        raise CertificateError(
            f"leaf {smallest} (from the left) holds {sizes[smallest]} samples but leaf_size is "
            f"{problem.shape.leaf_size}"
        )


def _check_leaf_weights(problem: Problem, tree: Node, leaf: NDArray[np.int64]) -> None:
    weights = [math.fsum(problem.samples.weights[leaf == k]) for k in range(len(leaves(tree)))]
    lightest = int(np.argmin(weights))
    if not isinstance(tree, Leaf) and weights[lightest] < problem.shape.least_leaf_weight:
        raise CertificateError(
            f"leaf {lightest} (from the left) holds samples of weight {weights[lightest]:g} but leaf_weight is "
            f"{problem.shape.leaf_weight:g}"
        )


def _leaf_objective(problem: Problem, bound: float) -> float:
    """Return the objective of the best leaf, summed with care only where a bound comes near it: it takes far longer."""
    if problem.has_integer_costs or problem.loss.predicts == "number" or bound < 0.999 * problem.baseline:
        return problem.baseline
    every = np.ones(problem.samples.n_samples, dtype=np.int64)
    return min(problem.objective_of(Leaf(k), k * every) for k in range(problem.samples.n_classes))


def _check_claims(problem: Problem, solution: Solution, objective: float) -> None:
    # Objectives of numbers and of whole costs are exact but for one rounding, so they must agree exactly; others (fsum,
    # and the prices) to a few units in the last place, as no term is negative.
    is_exact = problem.has_integer_costs or problem.loss.predicts == "number"
    slack = 0.0 if is_exact else 1e-12 * abs(objective)
    if abs(solution.objective - objective) > slack:
        raise CertificateError(
            f"{solution.solver} claims objective {solution.objective} but the tree's own, recounted over "
            f"{problem.samples.n_samples} samples, is {objective}; tree and data do not belong together or one was "
            "changed"
        )
    most = solution.tolerance if problem.loss.predicts == "class" else 0.0
    if solution.bound > objective + slack + most:
        raise CertificateError(
            f"{solution.solver} claims that no tree is below {solution.bound} but its own tree has {objective}"
        )
    # Where a tree without a split is feasible no true bound lies above it, unless rows were added to a model.
    is_feasible = problem.shape.is_leaf_allowed and not solution.details.get("added") and solution.bound > -math.inf
    leaf = _leaf_objective(problem, solution.bound) if is_feasible else math.inf
    if solution.bound > leaf + (0.0 if is_exact else 1e-12 * leaf) + most:
        raise CertificateError(f"{solution.solver} claims the bound {solution.bound} but one leaf alone costs {leaf}")
    if not (math.isinf(solution.bound) or problem.is_provable):
        raise CertificateError(f"{solution.solver} claims a bound of trees that no solver here has a proof for")
    least = problem.least_saving_from(objective) if solution.tolerance else math.inf
    check_optimality(solution.solver, solution, objective, least, problem.words_of_saving)


class Claimed(Protocol):
    """What every solution claims of its bound."""

    @property
    def bound(self) -> float:
        """What no tree costs less than."""

    @property
    def stop(self) -> Stop:
        """Why the search ended."""

    @property
    def tolerance(self) -> float:
        """How far the bound may lie below the objective of a tree that is called optimal."""


def check_optimality(who: str, claimed: Claimed, objective: float, least_saving: float, words_of_saving: str) -> None:
    """Check that a bound meets the objective where a solution says optimal, by no wider a tolerance than a saving.

    Raises
    ------
    CertificateError
        it does not, or the tolerance could hide a better tree.
    """
    if claimed.stop is Stop.OPTIMAL and claimed.bound < objective - claimed.tolerance:
        raise CertificateError(
            f"{who} says optimal but its bound {claimed.bound} does not meet its objective {objective}"
        )
    if not is_tolerable(claimed.tolerance, least_saving):
        raise CertificateError(
            f"{who} claims the tolerance {claimed.tolerance}, too wide to call anything proven; expected 0 or less "
            f"than {least_saving}, {words_of_saving}"
        )
