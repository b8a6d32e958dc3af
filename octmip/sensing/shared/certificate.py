"""Certificate of a joint solution: every tree and the shared budget recounted. Imports no solver."""

import math
from dataclasses import dataclass

from octmip.errors import CertificateError
from octmip.sensing.shared.solution import JointSolution, sensor_prices, weighted_sum
from octmip.trees.certificate import Certificate, certify
from octmip.trees.solution import Stop


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
    if not 0 <= joint.tolerance < saving:
        raise CertificateError(
            f"the joint solution claims the tolerance {joint.tolerance}; expected 0 or more and less than {saving}, "
            "what one sample or split of one label alone can save"
        )
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
    if joint.stop is Stop.OPTIMAL and not joint.is_optimal:
        raise CertificateError(f"the joint solution says optimal but its bound {joint.bound} is below {objective}")
