"""Trees for several labels under one budget of sensors, and their certificate, which knows no solver.

minimise   sum over labels l of  weight_l * objective_l(T_l)
such that  the sensors that any of the trees reads cost the budget at most, each paid for once
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from octmip.errors import CertificateError, ProblemError
from octmip.trees.answer.certificate import Certificate, certify, check_optimality
from octmip.trees.answer.solution import Solution, Stop, relative_gap
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class JointSolution:
    """Trees for several labels under one budget of sensors, and the bound below which no such trees lie.

    Attributes
    ----------
    problems
        one per label, `sensor_budget` the shared one.
    weights
        (n_labels,) of the labels' objectives in the sum.
    solutions
        one per label. `bound` of each is one over its trees alone within the whole budget, so that it says
        what the label gives up for the others.
    bound
        proven lower bound of the weighted sum; -inf without a proof.
    stop
        why the search stopped.
    seconds
        wall time [s].
    n_nodes
        sets of sensors that were branched on; 0 without a proof.
    tolerance
        how far `bound` may stand from `objective` and still meet it: 0 for whole weights and costs.

    Examples
    --------
    >>> problems = [Problem([[0, 5], [1, 5], [2, 7]], y, depth=1) for y in (["a", "b", "b"], ["c", "d", "c"])]
    >>> shared_budget(problems, budget=1).objective
    1.0
    """

    problems: tuple[Problem, ...]
    weights: tuple[float, ...]
    solutions: tuple[Solution, ...]
    bound: float
    stop: Stop
    seconds: float
    n_nodes: int
    tolerance: float = 0.0

    @property
    def trees(self) -> tuple[Node, ...]:
        """The trees, one per label."""
        return tuple(solution.tree for solution in self.solutions if solution.tree is not None)

    @property
    def objective(self) -> float:
        """Weighted sum of the labels' objectives."""
        return weighted_sum(self.weights, (solution.objective for solution in self.solutions))

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors that some tree reads, each once, in the order in which the problems name them."""
        used = sensors_of(self.problems, self.trees)
        return tuple(name for name in sensor_prices(self.problems) if name in used)

    @property
    def sensor_cost(self) -> float:
        """Cost of those sensors, each paid for once."""
        prices = sensor_prices(self.problems)
        return math.fsum(prices[name] for name in self.sensors)

    @property
    def is_optimal(self) -> bool:
        """Whether the bound proves that no trees within the budget are better (by more than `tolerance`)."""
        return self.bound >= self.objective - self.tolerance

    @property
    def gap(self) -> float:
        """Relative gap between objective and bound; 0 when they meet within `tolerance`."""
        return 0.0 if self.is_optimal else relative_gap(self.objective, self.bound)


def certify_joint(joint: JointSolution) -> tuple[Certificate, ...]:
    """Recount trees, budget and weighted sum of a joint solution, and return the certificate of each label.

    Raises
    ------
    CertificateError
        a label's solution fails its own certificate, the trees together break the budget, or bound or stop are not
        what was recounted.

    Examples
    --------
    >>> problems = [Problem([[0, 5], [1, 5], [2, 7]], y, depth=1) for y in (["a", "b", "b"], ["c", "d", "c"])]
    >>> [one.errors for one in certify_joint(shared_budget(problems, budget=2))]
    [0, 1]
    """
    certificates = tuple(map(certify, joint.problems, joint.solutions))
    limits = {problem.shape.sensor_limit for problem in joint.problems}
    if len(limits) > 1 or joint.sensor_cost > max(limits):
        raise CertificateError(
            f"the trees together read {joint.sensors} of cost {joint.sensor_cost}, but the budgets of the problems are "
            f"{[problem.shape.sensor_budget for problem in joint.problems]}; expected one budget that is kept"
        )
    saving, objective = least_saving(joint.problems, joint.weights), joint.objective
    check_optimality("the joint solution", joint, objective, saving, "what one sample or split of one label can save")
    least = weighted_sum(joint.weights, (problem.baseline for problem in joint.problems))
    if joint.bound > min(objective, least) + joint.tolerance + 1e-12 * abs(objective):
        raise CertificateError(
            f"the joint solution claims that no trees are below {joint.bound} but its own trees have {objective} and "
            f"leaves without a sensor {least}"
        )
    return certificates


def weighted_sum(weights: Sequence[float], values: Iterable[float]) -> float:
    """Return the sum of weight * value, rounded once; -inf or +inf where a value is."""
    terms = [weight * value for weight, value in zip(weights, values, strict=True)]
    return math.fsum(terms) if all(map(math.isfinite, terms)) else sum(terms)


def sensors_of(problems: Sequence[Problem], trees: Iterable[Node]) -> frozenset[str]:
    """Return the sensors that some of the trees reads."""
    read = (problem.shape.sensors_used(tree) for problem, tree in zip(problems, trees, strict=True))
    return frozenset[str]().union(*read)


def least_saving(problems: Sequence[Problem], weights: Sequence[float]) -> float:
    """Return the least saving of the weighted sum by one sample or split of one label."""
    pairs = zip(weights, problems, strict=True)
    return min(max(weight * problem.least_saving, math.ulp(0.0)) for weight, problem in pairs if weight > 0)


def sensor_prices(problems: Sequence[Problem]) -> dict[str, float]:
    """Return the cost of every sensor, in the order in which they first appear; a sensor has one cost."""
    prices: dict[str, float] = {}
    for k, problem in enumerate(problems):
        for name, cost in zip(problem.shape.sensors, problem.shape.sensor_costs.tolist(), strict=True):
            if prices.setdefault(name, cost) != cost:
                raise ProblemError(
                    f"sensor {name!r} costs {cost} in problem {k} but {prices[name]} in one before; expected "
                    "one cost for a sensor that is shared; correct it"
                )
    return prices
