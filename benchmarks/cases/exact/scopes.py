"""Every scope that is said, hunted for a better tree: `python -m benchmarks.run scopes`, some ten minutes.

Random small problems (weights, costs, missing readings, leaf sizes, numbers of splits, sensors, lines over two
features, numbers to predict), every method in turn under random limits, and the default. What the answer says of its
scope, in the words of screen, certificate, page and JSON, is read by another parser; all trees inside are enumerated,
and none may cost less than the bound. What the words leave out limits nothing there, so a limit left out is seen.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.answer.scope import scope_of
from octmip.trees.answer.solution import Limits, Solution
from octmip.trees.question.losses import ClassCosts, SquaredError
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import Run
from octmip.trees.solver import solve
from octmip.trees.tradeoff.default import solve_default
from tests.oracles.scopes import least_inside

SEEDS, STREAM = 2000, 68
AXIS = ("auto", "exact", "search", "cart", "oct", "flow", "benders")
LINES = ("auto", "two_feature", "search", "oct_h", "flow")
NUMBERS = ("auto", "exact", "search", "cart")
DEFAULT = "default"
MARGIN = 1e-7
"""Share of an objective below which one tree costs as much as another."""


def results(limit: float, threads: Sequence[int], seeds: int = SEEDS, seed: int = 0) -> Iterator[Line]:
    """Yield a line for each answer that says a scope, `seeds` of them from a seed on; it has one thread."""
    said = 0
    while said < (seeds or SEEDS):
        line = outcome(seed)
        seed += 1
        if line["scope"]:
            said += 1
            yield line


def outcome(seed: int) -> Line:
    """Return what the answer to one random problem says of its scope, and the cost of a better tree inside, if any."""
    rng = np.random.default_rng([STREAM, seed])
    kind = str(rng.choice(["axis", "axis", "lines", "numbers", DEFAULT]))
    problem = _problem(rng, kind)
    method = DEFAULT if kind == DEFAULT else str(rng.choice({"axis": AXIS, "lines": LINES, "numbers": NUMBERS}[kind]))
    n, p = problem.samples.features.shape
    line: Line = {"size": f"{n} x {p}", "seed": seed, "method": method, "kind": kind}
    try:
        asked, solution = answered(problem, method, float(rng.choice([0.05, 0.3, 3.0])), seed)
    except OctmipError as error:
        return line | {"scope": "", "fault": "", "refused": str(error)}
    if not np.isfinite(solution.bound) or solution.tree is None:
        return line | {"scope": "", "fault": ""}
    scope = scope_of(asked, solution)
    bound = float(str(solution.details.get("bound_in_scope", solution.bound)))
    cuts: Any = solution.details.get("cuts", ())
    least = least_inside(asked, scope, cuts)
    fault = f"bound {bound}, and a tree inside costs {least}" if bound > least + MARGIN * max(1.0, abs(least)) else ""
    narrow = bool(solution.scope)
    return line | {"scope": scope, "narrow": narrow, "optimal": solution.is_optimal, "fault": fault}


def answered(problem: Problem, method: str, seconds: float, seed: int) -> tuple[Problem, Solution]:
    """Return the problem that a method, or the default, has answered, and its answer."""
    if method != DEFAULT:
        return problem, solve(problem, method, Limits(seconds=seconds), seed=seed)  # type: ignore[arg-type]
    found = solve_default(problem, Run(limits=Limits(seconds=1.0), seed=seed))
    return found.problem, found.solution


def _problem(rng: np.random.Generator, kind: str) -> Problem:
    n = int(rng.integers(20, 40)) if kind == DEFAULT else int(rng.integers(5, 10 if kind == "lines" else 14))
    p = 2 if kind in ("lines", DEFAULT) else int(rng.integers(1, 4))
    features = rng.normal(size=(n, p)) if rng.random() < 0.7 else rng.integers(0, 5, (n, p)).astype(float)
    asked: dict[str, Any] = {"depth": int(rng.integers(1, 4 if kind == "axis" else 3))}
    if kind == "lines":
        asked |= {"split": "hyperplane", "split_size": 2}
    elif kind in ("axis", DEFAULT) and rng.random() < 0.2:
        features[rng.random((n, p)) < 0.15] = np.nan
        features[0] = 0.0
        asked["takes_missing"] = True
    if kind in ("numbers",) or (kind == DEFAULT and rng.random() < 0.2):
        targets: Any = np.round(features[:, 0] + rng.normal(size=n), 1)
        targets = np.where(np.isnan(targets), 0.0, targets)
        asked["loss"] = SquaredError()
    else:
        targets = (np.nan_to_num(features[:, 0]) > 0) * 1 ^ (rng.random(n) < 0.3) * 1
        targets[:2] = 0, 1
        if rng.random() < 0.3:
            asked["loss"] = ClassCosts(np.array([[0.0, float(rng.integers(1, 5))], [1.0, 0.0]]))
    if rng.random() < 0.3:
        asked["weights"] = rng.integers(1, 4, n).astype(float)
    if rng.random() < 0.4:
        asked["leaf_size"] = int(rng.integers(2, 4))
    if rng.random() < 0.3:
        asked["leaf_penalty"] = float(rng.choice([0.5, 1.0]))
    if kind == "axis" and rng.random() < 0.25:
        asked["max_splits"] = int(rng.integers(1, 4))
    if p > 1 and rng.random() < 0.25:
        asked["sensor_budget"] = 1.0
    if kind == "axis" and asked.get("leaf_penalty") and rng.random() < 0.3:
        asked["depth"] = None
    return Problem(features, targets, **asked)


def summary(lines: Sequence[Line]) -> str:
    """Return how many scopes of each method were said, narrower ones too, and those with a better tree inside."""
    said = Counter(line["method"] for line in lines)
    rows = [
        {
            "method": method,
            "scopes": n,
            "narrower than the question": sum(line["narrow"] for line in lines if line["method"] == method),
            "said optimal": sum(line["optimal"] for line in lines if line["method"] == method),
            "better tree inside": sum(bool(line["fault"]) for line in lines if line["method"] == method),
        }
        for method, n in sorted(said.items())
    ]
    faults = [f"{line['seed']} {line['method']}: {line['fault']} ({line['scope']})" for line in lines if line["fault"]]
    return "\n\n".join([markdown_table(rows), *faults])
