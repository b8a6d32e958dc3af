"""Scenarios of failed sensors: their probabilities, and what a tree costs in each.

In scenario s some sensors have a fault and their readings are others: x^s. With probabilities p_s and the rest of the
probability on "nothing has failed", the expected objective of a tree is

    sum_s p_s R(T, x^s),     R the problem's objective,

which is the objective of *one* problem whose samples are the scenarios' samples stacked, each with weight p_s w_i.
A tree that does not read a failed sensor does not see the scenario.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, ProblemError
from octmip.problem import Problem
from octmip.sensing.failure.imputation import Imputation
from octmip.solution import Solution
from octmip.tree import Node, predict

Floats = NDArray[np.float64]
Kind = Literal["stuck", "drift", "noise", "imputed"]
KINDS: tuple[Kind, ...] = ("stuck", "drift", "noise", "imputed")

MOST_DENOMINATOR = 10**6
"""Probabilities that are fractions with such a common denominator become whole weights, so that proofs are exact."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A change of the readings of a sensor that has failed.

    Attributes
    ----------
    kind
        "stuck": every reading is `size` (0: dead); "drift": `size` is added; "noise": a normal number of standard
        deviation `size` is added; "imputed": the sensor is known to have failed and its reading is imputed from
        the others (octmip.sensing.failure.imputation).
    size
        in the unit of the features.
    """

    kind: Kind
    size: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ProblemError(f"kind of fault is {self.kind!r}; expected one of {', '.join(KINDS)}")
        if not math.isfinite(self.size) or (self.kind == "noise" and self.size < 0):
            raise ProblemError(
                f"size of a fault of kind {self.kind!r} is {self.size}; expected a finite number, at least 0 for noise"
            )


DEAD = Fault("stuck", 0.0)


@dataclass(frozen=True, slots=True)
class Scenario:
    """Sensors that have failed together, all in one way.

    Attributes
    ----------
    sensors
        their names.
    fault
        what happens to their readings.
    probability
        of this scenario.
    """

    sensors: tuple[str, ...]
    fault: Fault
    probability: float


def failures(
    problem: Problem, fault: Fault = DEAD, *, n_failed: int = 1, probability: float = 0.5
) -> tuple[Scenario, ...]:
    """Return one scenario for each set of `n_failed` sensors, all alike, of `probability` together.

    Raises
    ------
    ProblemError
        there are not so many sensors, or the probability is outside 0 to 1.
    """
    if not 1 <= n_failed <= len(problem.sensors):
        raise ProblemError(f"n_failed is {n_failed}; expected 1 to {len(problem.sensors)}, the number of sensors")
    if not 0 < probability <= 1:
        raise ProblemError(f"probability is {probability}; expected more than 0 and at most 1")
    sets = list(itertools.combinations(problem.sensors, n_failed))
    return tuple(Scenario(chosen, fault, probability / len(sets)) for chosen in sets)


@dataclass(frozen=True, slots=True, eq=False)
class FailureProblem:
    """A problem together with scenarios of failed sensors.

    Attributes
    ----------
    problem
        the problem when nothing has failed; `leaf_size` 1, as stacked samples count once per scenario.
    scenarios
        what may fail; their probabilities sum to 1 at most, the rest is "nothing has failed".
    seed
        of the noise of faults of kind "noise".
    """

    problem: Problem
    scenarios: Sequence[Scenario]
    seed: int = 0

    def __post_init__(self) -> None:
        if self.problem.leaf_size > 1:
            raise ProblemError(
                f"leaf_size is {self.problem.leaf_size}; expected 1, as scenarios count a sample several times; give a "
                "leaf_penalty instead"
            )
        if not self.scenarios:
            raise ProblemError("no scenario is given; expected at least one, as `failures(problem)` makes them")
        for scenario in self.scenarios:
            unknown = [name for name in scenario.sensors if name not in self.problem.sensors]
            if unknown or not scenario.sensors:
                raise ProblemError(
                    f"a scenario names {unknown or 'no sensor'}; expected some of {list(self.problem.sensors)}"
                )
            if not 0 <= scenario.probability <= 1:
                raise ProblemError(f"probability of {scenario} is outside its range; expected 0 to 1; correct it")
        total = math.fsum(scenario.probability for scenario in self.scenarios)
        if total > 1 + 1e-9:
            raise ProblemError(f"the probabilities of the scenarios sum to {total}; expected at most 1; lower them")
        object.__setattr__(self, "scenarios", tuple(self.scenarios))

    @property
    def probabilities(self) -> Floats:
        """(n_scenarios + 1,) of nothing failed, then of each scenario."""
        failed = [scenario.probability for scenario in self.scenarios]
        return np.array([max(0.0, 1.0 - math.fsum(failed)), *failed])

    def columns(self, scenario: Scenario) -> NDArray[np.int64]:
        """Return the features that the scenario's sensors give."""
        index = [self.problem.sensors.index(name) for name in scenario.sensors]
        return np.flatnonzero(np.isin(self.problem.sensor_index, index))

    def readings(self, number: int, features: Floats | None = None) -> Floats:
        """Return the features (n, n_features) in scenario `number`, 0: nothing has failed.

        Parameters
        ----------
        number
            of the scenario, from 1 on.
        features
            readings without a failure; None: the problem's own samples.
        """
        whole = self.problem.features if features is None else features
        if number == 0:
            return whole
        scenario = self.scenarios[number - 1]
        columns, out = self.columns(scenario), whole.astype(np.float64)
        if scenario.fault.kind == "stuck":
            out[:, columns] = scenario.fault.size
        elif scenario.fault.kind == "drift":
            out[:, columns] += scenario.fault.size
        elif scenario.fault.kind == "noise":
            rng = np.random.default_rng([self.seed, number])
            out[:, columns] += rng.normal(0.0, scenario.fault.size, (len(out), len(columns)))
        else:
            out[:, columns] = np.nan
            out = Imputation.fit(self.problem.features).impute(out)
        return out

    def stacked(self, shares: Floats) -> tuple[Problem, float]:
        """Return the scenarios of positive share as one problem, and the divisor of its objective.

        Parameters
        ----------
        shares
            (n_scenarios + 1,) summing to 1.
        """
        chosen = np.flatnonzero(shares > 0)
        scale = _scale(shares[chosen])
        weights = [np.round(shares[k] * scale) if scale > 1 else shares[k] for k in chosen]
        problem = self.problem
        return replace(
            problem,
            features=np.vstack([self.readings(int(k)) for k in chosen]),
            labels=np.tile(problem.labels, len(chosen)),
            weights=np.concatenate([weight * problem.weights for weight in weights]),
            leaf_penalty=problem.leaf_penalty * scale,
        ), scale

    def least_saving(self, *, over_worst: bool) -> float:
        """Return the least saving by one sample or split, of the worst objective or of the mean over the scenarios."""
        shares = self.probabilities[self.probabilities > 0]
        return self.problem.least_saving * (1.0 if over_worst else float(shares.min()))

    def objectives(self, tree: Node) -> Floats:
        """Return the problem's objective in each scenario, (n_scenarios + 1,)."""
        whole = self.problem.objective(tree)
        used = self.problem.sensors_used(tree)
        return np.array([whole, *(self._objective(k, tree, whole, used) for k in range(1, len(self.scenarios) + 1))])

    def _objective(self, number: int, tree: Node, whole: float, used: Sequence[str]) -> float:
        if not set(used) & set(self.scenarios[number - 1].sensors):
            return whole
        return self.problem.objective_of(tree, predict(tree, self.readings(number)))


def _scale(shares: Floats) -> float:
    """Return a number that makes all the shares whole, 1 where none up to `MOST_DENOMINATOR` does."""
    fractions = [Fraction(float(share)).limit_denominator(MOST_DENOMINATOR) for share in shares]
    common = math.lcm(*(fraction.denominator for fraction in fractions))
    is_close = all(abs(float(f) - share) < 1e-12 for f, share in zip(fractions, shares, strict=True))
    return float(common) if is_close and common <= MOST_DENOMINATOR else 1.0


@dataclass(frozen=True, slots=True)
class FailureCertificate:
    """Costs recounted from tree and scenarios alone, in units of the problem's objective.

    Attributes
    ----------
    nominal
        with nothing failed.
    expected
        mean over the scenarios' probabilities.
    worst
        of the worst scenario; worst_sensors: those that have failed in it, () if nothing has.
    """

    nominal: float
    expected: float
    worst: float
    worst_sensors: tuple[str, ...]


def certify_failures(asked: FailureProblem, solution: Solution) -> FailureCertificate:
    """Recompute what a solution costs when sensors fail; `details["over"]` says whether it claims mean or worst.

    Raises
    ------
    CertificateError
        there is no tree, or objective or bound differ from what was recounted.
    """
    if solution.tree is None:
        raise CertificateError(f"{solution.solver} found no tree (stop: {solution.stop}); there is nothing to certify")
    objectives = asked.objectives(solution.tree)
    worst = int(objectives.argmax())
    sensors = asked.scenarios[worst - 1].sensors if worst else ()
    found = FailureCertificate(
        float(objectives[0]), float(asked.probabilities @ objectives), float(objectives[worst]), sensors
    )
    own = found.worst if solution.details.get("over") == "worst" else found.expected
    slack = 1e-9 * abs(own)
    least = asked.least_saving(over_worst=solution.details.get("over") == "worst")
    if not 0 <= solution.tolerance < least:
        raise CertificateError(
            f"{solution.solver} claims the tolerance {solution.tolerance}; expected 0 or more and less than {least}, "
            "what one sample or split alone can save"
        )
    if abs(solution.objective - own) > slack or solution.bound > own + slack + solution.tolerance:
        raise CertificateError(
            f"{solution.solver} claims objective {solution.objective} and bound {solution.bound}; recounted {own}"
        )
    return found
