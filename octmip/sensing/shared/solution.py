"""JointSolution and its certificate: one tree for each of several labels, from one set of sensors within one budget.

minimise   sum over labels l of  weight_l * objective_l(T_l)
such that  the sensors that any of the trees reads cost the budget at most, each paid for once

The certificate recounts every tree and the budget, and imports no solver.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from octmip.errors import CertificateError, ProblemError, SolverError
from octmip.trees.certificate import Certificate, certify, check_optimality
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution, Stop, relative_gap
from octmip.trees.tree import Node


@dataclass(frozen=True, slots=True)
class BaselineSplit:
    """The best division of the budget into one budget for each label, each label's tree found by itself.

    Attributes
    ----------
    budgets
        (n_labels,) the share of each label; they add up to the whole budget or less.
    objective
        weighted sum of the labels' objectives. Sensors that two labels share are paid for twice.
    """

    budgets: tuple[float, ...]
    objective: float


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
        why the solver stopped.
    seconds
        wall time [s].
    n_nodes
        sets of sensors that were branched on; 0 for a search.
    baseline_split
        the best baseline split that was tried: the sum is never above it.
    tolerance
        how far `bound` may stand from `objective` and still meet it: 0 for whole weights and costs.
    """

    problems: tuple[Problem, ...]
    weights: tuple[float, ...]
    solutions: tuple[Solution, ...]
    bound: float
    stop: Stop
    seconds: float
    n_nodes: int
    baseline_split: BaselineSplit
    tolerance: float = field(default=0.0)

    def __post_init__(self) -> None:
        if not len(self.problems) == len(self.weights) == len(self.solutions):
            raise SolverError(
                f"a joint solution has {len(self.problems)} problems, {len(self.weights)} weights and "
                f"{len(self.solutions)} solutions; expected one of each for every label"
            )

    @property
    def trees(self) -> tuple[Node, ...]:
        """The trees, one per label."""
        return tuple(solution.tree for solution in self.solutions if solution.tree is not None)

    @property
    def objective(self) -> float:
        """Weighted sum of the labels' objectives."""
        return weighted_sum(self.weights, (solution.objective for solution in self.solutions))

    @property
    def budget(self) -> float:
        """The budget that the labels share."""
        assert self.problems[0].sensor_budget is not None  # set by whoever shares it
        return self.problems[0].sensor_budget

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors that some tree reads, each once, in the order in which the problems name them."""
        read = (p.sensors_used(tree) for p, tree in zip(self.problems, self.trees, strict=True))
        used = {name for names in read for name in names}
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


def weighted_sum(weights: Sequence[float], values: Iterable[float]) -> float:
    """Return the sum of weight * value, rounded once; -inf or +inf where a value is."""
    terms = [weight * value for weight, value in zip(weights, values, strict=True)]
    return math.fsum(terms) if all(map(math.isfinite, terms)) else sum(terms)


def sensor_prices(problems: Sequence[Problem]) -> dict[str, float]:
    """Return the cost of every sensor of some problem, in the order in which they first appear.

    Raises
    ------
    ProblemError
        two problems name one sensor at two costs.
    """
    prices: dict[str, float] = {}
    for k, problem in enumerate(problems):
        for name, cost in zip(problem.sensors, problem.sensor_costs.tolist(), strict=True):
            if prices.setdefault(name, cost) != cost:
                raise ProblemError(
                    f"sensor {name!r} costs {cost} in problem {k} but {prices[name]} in one before; expected "
                    "one cost for a sensor that is shared; correct it"
                )
    return prices


@dataclass(frozen=True, slots=True)
class JointCertificate:
    """Objectives and sensors recounted from problems and trees alone.

    Attributes
    ----------
    certificates
        one per label.
    objective
        weighted sum of their recounted objectives.
    sensors, sensor_cost
        that all trees together read, each paid for once.
    bound, gap
        the joint solution's bound, consistent with the objective.
    """

    certificates: tuple[Certificate, ...]
    objective: float
    sensors: tuple[str, ...]
    sensor_cost: float
    bound: float
    gap: float


def certify_joint(joint: JointSolution) -> JointCertificate:
    """Recompute what a joint solution claims and return it as a JointCertificate.

    Raises
    ------
    CertificateError
        a label's solution fails its own certificate, the trees together break the budget, or
        objective, bound, stop or baseline split are not what was recounted.
    """
    pairs = zip(joint.problems, joint.solutions, strict=True)
    certificates = tuple(certify(problem, solution) for problem, solution in pairs)
    prices = sensor_prices(joint.problems)
    used = {name for certificate in certificates for name in certificate.sensors}
    sensors = tuple(name for name in prices if name in used)
    cost = math.fsum(prices[name] for name in sensors)
    if cost > joint.problems[0].sensor_limit or any(p.sensor_budget != joint.budget for p in joint.problems):
        raise CertificateError(
            f"the trees together read {sensors} of cost {cost}, but the budgets of the problems are "
            f"{[problem.sensor_budget for problem in joint.problems]}; expected one budget that is kept"
        )
    objective = weighted_sum(joint.weights, (certificate.objective for certificate in certificates))
    _check_claims(joint, objective)
    return JointCertificate(certificates, objective, sensors, cost, joint.bound, joint.gap)


def _check_claims(joint: JointSolution, objective: float) -> None:
    pairs = zip(joint.weights, joint.problems, strict=True)
    saving = min(max(weight * problem.least_saving, math.ulp(0.0)) for weight, problem in pairs if weight > 0)
    check_optimality("the joint solution", joint, objective, saving, "what one sample or split of one label can save")
    slack = joint.tolerance + 1e-12 * abs(objective)
    least = weighted_sum(joint.weights, (problem.baseline for problem in joint.problems))
    if joint.bound > min(objective, least) + slack:
        raise CertificateError(
            f"the joint solution claims that no trees are below {joint.bound} but its own trees have {objective} and "
            f"leaves without a sensor {least}"
        )
    if objective > joint.baseline_split.objective + slack:
        raise CertificateError(
            f"the trees together have {objective}, more than the {joint.baseline_split.objective} of the baseline "
            f"split into the budgets {joint.baseline_split.budgets}"
        )
