"""A reading plan: which sensor to read next, when to stop, what to decide, and what that costs."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from octmip.formats.names import shown
from octmip.interfaces.report.text import condition, narrow_scope, number, percent
from octmip.sensing.sequential.problem import SequentialCertificate, SequentialProblem, certify_sequential
from octmip.trees.solution import Solution
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Split, leaf_index, leaves


@dataclass(frozen=True, slots=True)
class Wording:
    """Units and names in which values and decisions are written.

    Attributes
    ----------
    unit
        of a reading, as "microstrain".
    label
        what is decided, as "mu2".
    label_unit
        as "%".
    """

    unit: str = ""
    label: str = ""
    label_unit: str = ""


def plan_text(sequential: SequentialProblem, solution: Solution, wording: Wording = Wording()) -> str:
    """Return the plan as indented lines, yes before no, with the cost and the proof below.

    Raises
    ------
    CertificateError
        the solution does not hold what it claims.
    """
    certificate = certify_sequential(sequential, solution)
    assert solution.tree is not None
    notes = iter(_leaf_notes(sequential, solution.tree))
    lines: list[str] = []

    def say(node: Node, indent: str, read: frozenset[str]) -> None:
        if isinstance(node, Leaf):
            lines.append(f"{indent}decide {_decision(sequential, node, wording)}    ({next(notes)})")
            return
        lines.append(f"{indent}{_reading(sequential, node, read)}; if {_condition(sequential, node, wording)}")
        after = read | sequential.sensors_of(node.features)
        say(node.left, indent + "    ", after)
        lines.append(f"{indent}else")
        say(node.right, indent + "    ", after)

    say(solution.tree, "", frozenset())
    return "\n".join([*lines, *_summary(solution, certificate, sequential.problem.n_samples)])


def _reading(sequential: SequentialProblem, node: Split | HyperplaneSplit, read: frozenset[str]) -> str:
    parts = []
    for sensor in sorted(sequential.sensors_of(node.features)):
        cost = sequential.path_cost(read | {sensor}) - sequential.path_cost(read)
        parts.append(f"{shown(sensor)} ({'already read: free' if sensor in read else f'cost {number(cost)}'})")
        read = read | {sensor}
    return "read " + ", ".join(parts)


def _condition(sequential: SequentialProblem, node: Split | HyperplaneSplit, wording: Wording) -> str:
    return f"{condition(node, sequential.problem.feature_names)} {wording.unit}".strip()


def _decision(sequential: SequentialProblem, leaf: Leaf, wording: Wording) -> str:
    name = f"{wording.label} = " if wording.label else ""
    return f"{name}{shown(sequential.problem.class_names[leaf.label])} {wording.label_unit}".strip()


def _leaf_notes(sequential: SequentialProblem, tree: Node) -> Sequence[str]:
    """Return for each leaf, from the left, how many samples end there and what they have paid."""
    problem = sequential.problem
    assert sequential.shares is not None
    reached = leaf_index(tree, problem.features)
    notes = []
    for k, read in enumerate(sequential.read_at_leaves(tree)):
        share = math.fsum(sequential.shares[reached == k])
        counts = np.bincount(problem.codes[reached == k], minlength=problem.n_classes)
        label = leaves(tree)[k].label
        wrong = f"{counts.sum() - counts[label]} of {counts.sum()} wrong"
        notes.append(
            f"{percent(share)} of cases, {wrong}; {_readings(len(read))}, cost {number(sequential.path_cost(read))}"
        )
    return notes


def _readings(count: float) -> str:
    return f"{number(count)} reading{'' if count == 1 else 's'}"


def _summary(solution: Solution, found: SequentialCertificate, n_samples: int) -> list[str]:
    proof = f"proven optimal among {narrow_scope(solution) or 'all trees of this depth'}"
    if not solution.is_optimal:
        proof = f"not proven: none is below {number(solution.bound)}"
    cheapest = ", and none as good is cheaper" if solution.details.get("cheapest") == "proven" else ""
    return [
        f"expected cost {number(found.expected_cost)} ({_readings(found.expected_readings)}); "
        f"worst {number(found.worst_cost)} ({_readings(found.worst_readings)})",
        f"{found.errors} of {n_samples} samples wrong; objective {number(found.objective)}, {proof}{cheapest}",
    ]
