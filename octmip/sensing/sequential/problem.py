"""Sequential sensing: sensors are read one after the other, and only those that the path reaches are paid for.

A sample that ends at a leaf has read the set A of the sensors on its path, each once however often the path asks it.
It has paid

    a(A) = sum of cost_s over s in A  +  sum of setup_g over the groups g that A touches,

and the expected reading cost of a tree is the mean of a over the samples, by their shares. The objective is

    problem's objective  +  sum_i delay[label_i] * |A_i|  +  price * n * sum_i share_i * a(A_i).

`price` is what one unit of reading cost on one sample costs in units of the problem's costs: price 0.01 and sensors of
cost 1 say that a hundred readings are worth one error; `delay` is what each further reading costs while a
sample of that class waits to be recognised.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, ProblemError
from octmip.trees.certificate import check_optimality, checked_leaf_index
from octmip.trees.problem import Problem
from octmip.trees.registry import refuse_numbers
from octmip.trees.solution import Solution
from octmip.trees.tree import Leaf, Node, leaves

Floats = NDArray[np.float64]

MOST_SENSORS = 127
"""Sensors that a path can hold in the native core, with a group for those in none."""


@dataclass(frozen=True, slots=True)
class Group:
    """Sensors that are set up together: a panel, a cable, a visit.

    Attributes
    ----------
    sensors
        their names.
    setup_cost
        paid once by a path that reads any of them, beside the sensors' own costs.
    """

    sensors: tuple[str, ...]
    setup_cost: float


@dataclass(frozen=True, slots=True, eq=False)
class SequentialProblem:
    """A problem whose sensors are read in sequence.

    Attributes
    ----------
    problem
        which tree is wanted; its `sensor_cost` is the cost of one reading; without a `sensor_budget`.
    price
        of one unit of reading cost on one sample, in units of the problem's costs. With price 0 and no budget the
        cheapest in expectation of the optimal trees is wanted.
    budget
        at most so much expected reading cost; None: no limit. Not together with a price.
    groups
        sensors with a common set-up cost, by name; a sensor is in one group at most.
    within
        for a class the most readings after which a leaf may predict it. A rule about the tree, not about the
        samples at hand: no leaf that predicts the class lies behind more readings, so whatever sample is recognised
        as of this class, now or later, is so in time. That it is recognised at all is the business of costs.
    delay_cost
        for a class what each reading costs for a sample of it, in units of the problem's costs; it draws the
        leaves of urgent classes towards the root.
    shares
        (n_samples,) probability of each sample in service, by any factor; None: all alike. Risk weights are no
        shares.
    """

    problem: Problem
    price: float = field(kw_only=True, default=0.0)
    budget: float | None = field(kw_only=True, default=None)
    groups: Mapping[str, Group] = field(kw_only=True, default_factory=dict)
    within: Mapping[Any, int] = field(kw_only=True, default_factory=dict)
    delay_cost: Mapping[Any, float] = field(kw_only=True, default_factory=dict)
    shares: Floats | None = field(kw_only=True, default=None)

    def __post_init__(self) -> None:
        refuse_numbers(self.problem, "sequential")
        if self.problem.sensor_budget is not None:
            raise ProblemError(
                f"the problem has a sensor_budget of {self.problem.sensor_budget}, which limits the sensors of the "
                "whole tree; a sequential problem counts those of each path; choose the sensors first, without a budget"
            )
        if len(self.problem.sensors) > MOST_SENSORS:
            raise ProblemError(
                f"the problem has {len(self.problem.sensors)} sensors; expected at most {MOST_SENSORS}; choose some"
            )
        _check_number(self.price, "price")
        if self.budget is not None:
            _check_number(self.budget, "budget")
            if self.price:
                raise ProblemError(f"price is {self.price} and budget {self.budget}; give one of the two")
        self._check_groups()
        self._check_classes()
        self._set_shares()

    def _check_groups(self) -> None:
        seen: set[str] = set()
        for name, group in self.groups.items():
            _check_number(group.setup_cost, f"setup_cost of group {name!r}")
            wrong = [s for s in group.sensors if s not in self.problem.sensors or s in seen]
            if wrong:
                raise ProblemError(
                    f"group {name!r} names the sensor {wrong[0]!r}, which is in another group or not among "
                    f"{list(self.problem.sensors)}; name each sensor once"
                )
            seen |= set(group.sensors)

    def _check_classes(self) -> None:
        for what, given in (("within", self.within), ("delay_cost", self.delay_cost)):
            unknown = [name for name in given if name not in self.problem.class_names]
            if unknown:
                raise ProblemError(
                    f"{what} names the class {unknown[0]!r}; expected some of {list(self.problem.class_names)}; "
                    "correct the name"
                )
            for name, value in given.items():
                _check_number(value, f"{what} of class {name!r}")
        for name, most in self.within.items():
            if most != math.floor(most):
                raise ProblemError(f"within of class {name!r} is {most}; expected a whole number of readings; round it")

    def _set_shares(self) -> None:
        n = self.problem.n_samples
        shares = np.ones(n) if self.shares is None else np.array(self.shares, dtype=np.float64)
        if shares.shape != (n,) or not np.isfinite(shares).all() or (shares < 0).any() or not shares.any():
            raise ProblemError(
                f"shares has shape {shares.shape}; expected one number of 0 or more for each of {n} samples, not all 0"
            )
        shares = shares / shares.sum() if self.shares is not None else np.full(n, 1.0 / n)
        shares.flags.writeable = False
        object.__setattr__(self, "shares", shares)

    @property
    def counts(self) -> Floats:
        """(n_samples,) n times the share of each sample: 1 for each when they are alike."""
        assert self.shares is not None
        n = self.problem.n_samples
        return np.ones(n) if np.ptp(self.shares) == 0 else self.shares * n

    @property
    def delay_costs(self) -> Floats:
        """(n_samples,) what one reading costs for each sample, by its class."""
        by_class = [float(self.delay_cost.get(name, 0.0)) for name in self.problem.class_names]
        of_sample: Floats = np.array(by_class)[self.problem.codes]
        return of_sample

    @property
    def most_readings(self) -> list[int]:
        """(n_classes,) most readings after which each class may be predicted; all sensors without a rule."""
        return [int(self.within.get(name, len(self.problem.sensors))) for name in self.problem.class_names]

    @property
    def group_of_sensor(self) -> dict[str, str]:
        """Name of the group of each sensor that is in one."""
        return {sensor: name for name, group in self.groups.items() for sensor in group.sensors}

    def path_cost(self, sensors: frozenset[str]) -> float:
        """Return the cost of a path that has read these sensors."""
        of_sensor = dict(zip(self.problem.sensors, self.problem.sensor_costs.tolist(), strict=True))
        opened = {self.group_of_sensor[sensor] for sensor in sensors if sensor in self.group_of_sensor}
        return math.fsum([of_sensor[s] for s in sensors] + [self.groups[name].setup_cost for name in opened])

    def read_at_leaves(self, tree: Node) -> list[frozenset[str]]:
        """Return the sensors that have been read at each leaf, leaves from the left."""
        return list(self._read(tree, frozenset()))

    def _read(self, node: Node, read: frozenset[str]) -> Iterator[frozenset[str]]:
        if isinstance(node, Leaf):
            yield read
            return
        read = read | self.sensors_of(node.features)
        yield from self._read(node.left, read)
        yield from self._read(node.right, read)

    def sensors_of(self, features: tuple[int, ...]) -> frozenset[str]:
        """Return the sensors that a split over these features reads."""
        return frozenset(self.problem.sensors[self.problem.sensor_index[feature]] for feature in features)


def _check_number(value: float, name: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0 <= value < math.inf:
        raise ProblemError(f"{name} is {value!r}; expected a finite number of 0 or more; correct it")


@dataclass(frozen=True, slots=True)
class SequentialCertificate:
    """Costs and readings, recounted from the tree and the sequential problem alone.

    Attributes
    ----------
    objective
        of the sequential problem.
    problem_objective
        of its problem, without the cost of readings.
    errors
        misclassified samples.
    expected_cost, worst_cost
        reading cost in the mean over the samples' shares, and of the most expensive path.
    expected_readings, worst_readings
        sensors read.
    bound, gap
        the solution's.
    """

    objective: float
    problem_objective: float
    errors: int
    expected_cost: float
    worst_cost: float
    expected_readings: float
    worst_readings: int
    bound: float
    gap: float


def recount(
    sequential: SequentialProblem, tree: Node, bound: float = -math.inf, gap: float = math.inf
) -> SequentialCertificate:
    """Return the certificate of a tree, its costs recounted leaf by leaf.

    Raises
    ------
    CertificateError
        the tree breaks a limit of the problem, the rule of a class, or the budget.
    """
    problem = sequential.problem
    leaf = checked_leaf_index(problem, tree)
    labels = np.array([node.label for node in leaves(tree)], dtype=np.int64)
    read = sequential.read_at_leaves(tree)
    _check_rules(sequential, labels, read)
    cost = np.array([sequential.path_cost(sensors) for sensors in read])
    n_read = np.array([len(sensors) for sensors in read])
    assert sequential.shares is not None
    expected_cost = math.fsum(sequential.shares * cost[leaf])
    if sequential.budget is not None and expected_cost > sequential.budget * (1 + 1e-9) + 1e-9:
        raise CertificateError(
            f"the tree costs {expected_cost} in expectation; the budget is {sequential.budget}; expected no more"
        )
    own = problem.objective_of(tree, labels[leaf])
    charges = sequential.delay_costs * n_read[leaf] + sequential.price * sequential.counts * cost[leaf]
    return SequentialCertificate(
        objective=own + math.fsum(charges),
        problem_objective=own,
        errors=int((labels[leaf] != problem.codes).sum()),
        expected_cost=expected_cost,
        worst_cost=float(cost.max()),
        expected_readings=math.fsum(sequential.shares * n_read[leaf]),
        worst_readings=int(n_read.max()),
        bound=bound,
        gap=gap,
    )


def _check_rules(sequential: SequentialProblem, labels: NDArray[np.int64], read: list[frozenset[str]]) -> None:
    most = sequential.most_readings
    for label, sensors in zip(labels.tolist(), read, strict=True):
        if len(sensors) > most[label]:
            raise CertificateError(
                f"a leaf predicts class {sequential.problem.class_names[label]!r} after {len(sensors)} readings "
                f"({', '.join(sorted(sensors))}); expected at most {most[label]}"
            )


def certify_sequential(sequential: SequentialProblem, solution: Solution) -> SequentialCertificate:
    """Recompute what a solution of a sequential problem claims, from the tree and that problem alone.

    Raises
    ------
    CertificateError
        the tree breaks a limit, a rule or the budget, or a claim is not what was recounted.
    """
    if solution.tree is None:
        raise CertificateError(f"{solution.solver} found no tree (stop: {solution.stop}); there is nothing to certify")
    found = recount(sequential, solution.tree, solution.bound, solution.gap)
    slack = 1e-9 * abs(found.objective)
    least = sequential.problem.least_saving
    if abs(solution.objective - found.objective) > slack:
        raise CertificateError(f"{solution.solver} claims objective {solution.objective}; recounted {found.objective}")
    if solution.bound > found.objective + slack + solution.tolerance:
        raise CertificateError(f"{solution.solver} claims that no tree is below {solution.bound}; its own has less")
    check_optimality(solution.solver, solution, found.objective, least, "what one sample or split alone can save")
    return found
