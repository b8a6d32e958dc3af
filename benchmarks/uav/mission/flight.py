"""One mission, step by step, with everything that its page shows."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission import course
from benchmarks.uav.mission.aircraft import CRITICAL, Aircraft, capability
from benchmarks.uav.mission.histories import MOST_STEPS, Histories, draw
from benchmarks.uav.mission.outside import example_signature
from benchmarks.uav.mission.policies import Pilot, Policy
from benchmarks.uav.mission.simulation import damage_at, readings_at
from octmip.formats.tree_file import TreeFile
from octmip.monitor import Belief, CompiledTree
from octmip.report.text import condition
from octmip.tree import Leaf, Node, depth, nodes

Floats = NDArray[np.float64]

NAMES = ("mu1", "mu2")
POLICY = Policy("filter, 40 %, watch", "filter", "paper", has_watch=True)
"""The paper's rule on the belief, so that the path changes at about 40 %."""
TRACES = 3
"""Gauges whose strain is drawn."""


def recorded(aircraft: Aircraft, kind: str, seed: int) -> dict[str, Any]:
    """Return a mission of a kind as JSON values: what stays the same, and one entry per step."""
    rng = np.random.default_rng([seed, 9])
    read = tuple(aircraft.gauges.index(gauge) for gauge in aircraft.selector.gauges_read)
    histories = draw(kind, 1, rng, read)
    chain = aircraft.filter(16)
    pilot = Pilot(POLICY, aircraft, 1, chain, aircraft.watch())
    signature = example_signature(aircraft.gauges) if kind == "outside" else None
    chosen = _traced(aircraft, histories)
    compiled = [CompiledTree(file.tree, file.feature_names) for file in aircraft.trees]
    steps: list[dict[str, Any]] = []
    x, width, load = np.zeros(1), np.zeros(1), np.full(1, 3.0)
    for k in range(MOST_STEPS):
        truth = damage_at(histories, k)
        readings = readings_at(aircraft, histories, k, load, rng, signature)
        is_cautious = pilot.decide(readings, load, truth)
        assert pilot.belief is not None
        assert pilot.monitor_state is not None
        row = readings[0] / load[0]
        paths = [tree.path_to(tree.node(row)) for tree in compiled]
        told = [file.class_names[tree.label(row)] / 100 for file, tree in zip(aircraft.trees, compiled, strict=True)]
        step = _state(pilot.belief, truth[0], told)
        step |= {"x": _short(x[0]), "y": _short(course.height(x, width)[0]), "read_at": float(load[0]), "paths": paths}
        load = np.where(is_cautious, 2.0, 3.0)
        believed = float(pilot.belief.expectation(capability(chain.library.states))[0])
        step |= {"bears": _short(capability(truth)[0], 3), "believed_to_bear": _short(believed, 3)}
        step |= {"load": float(load[0]), "p": float(pilot.monitor_state.p_value[0])}
        step["log_e"] = _short(float(pilot.monitor_state.log_e[0]) / np.log(10.0), 2)
        model = aircraft.strains(np.array([[step["belief"][name]["median"] for name in NAMES]]))[0]
        step["strain"] = [[_short(row[g], 1), _short(model[g], 1)] for g in chosen]
        step["finding"] = pilot.findings[0].words if 0 in pilot.findings else ""
        step["off"] = list(pilot.findings[0].gauges) if 0 in pilot.findings else []
        step["words"] = _words(k, step)
        steps.append(step)
        if x[0] >= course.GOAL:
            break
        x, width = course.advance(x, width, is_cautious)
    return {**_fixed(aircraft, kind, seed, chosen), "steps": steps}


def _short(value: float, digits: int = 2) -> float:
    return round(float(value), digits)


def _traced(aircraft: Aircraft, histories: Histories) -> list[int]:
    """Return the gauges that are drawn: of those that the trees read, the ones that move most; a dead one first."""
    read = [aircraft.gauges.index(gauge) for gauge in aircraft.selector.gauges_read]
    ends = aircraft.strains(np.array([[0.0, 0.0], [0.8, 0.0], [0.0, 0.8]]))
    first = [int(g) for g in histories.dead_gauge if g >= 0]
    for change in (ends[1] - ends[0], ends[2] - ends[0], ends[2] - ends[0]):
        first += [g for g in sorted(read, key=lambda g: -abs(change[g])) if g not in first][:1]
    return sorted(first[:TRACES])


def _state(belief: Belief, truth: Floats, told: list[float]) -> dict[str, Any]:
    """Return truth, the trees' and the filter's estimates of one step."""
    known: dict[str, Any] = {}
    for name in NAMES:
        low, high = belief.interval(name)
        known[name] = {
            "bars": [_short(p, 4) for p in belief.marginal(name)[1][0]],
            "median": _short(belief.quantile(name, 0.5)[0], 4),
            "low": _short(low[0], 4),
            "high": _short(high[0], 4),
        }
    above = float(belief.probability_above(dict.fromkeys(NAMES, CRITICAL))[0])
    return {"truth": [_short(v, 4) for v in truth], "told": told, "belief": known, "above": _short(above, 4)}


def _words(k: int, step: dict[str, Any]) -> str:
    """Return the decision and its reason in words."""
    parts = []
    for name in NAMES:
        of = step["belief"][name]
        low, median, high = (round(100 * of[key]) for key in ("low", "median", "high"))
        parts.append(f"{name} at {median} % (90 % of the belief: {low} to {high} %)")
    over = [name for name in NAMES if step["belief"][name]["median"] > CRITICAL]
    if over:
        why = f"{' and '.join(over)} over 40 %: wide turns at 2 g."
    elif step["load"] < 3.0:
        why = "the watch has raised the alarm: wide turns at 2 g."
    else:
        why = "both at most 40 %: tight turns at 3 g."
    seen = step["finding"] or f"The readings fit the library (p = {step['p']:.2f})."
    return f"Step {k}. Believed: {', '.join(parts)}. Decision: {why} {seen}"


def _fixed(aircraft: Aircraft, kind: str, seed: int, chosen: list[int]) -> dict[str, Any]:
    wing = aircraft.wing
    x = np.linspace(0.0, course.GOAL, 200)
    return {
        "kind": kind,
        "seed": seed,
        "source": aircraft.source,
        "policy": POLICY.name,
        "critical": CRITICAL,
        "goal": course.GOAL,
        "obstacles": list(course.OBSTACLES),
        "radius": course.RADIUS,
        "lines": [
            [[_short(a, 1), _short(b, 1)] for a, b in zip(x, course.height(x, np.full(200, w)), strict=True)]
            for w in (0.0, 1.0)
        ],
        "outline": np.round(wing.outline(), 4).tolist(),
        "regions": [np.round(wing.region_outline(region), 4).tolist() for region in wing.regions],
        "gauges": [
            {"name": g, "at": np.round(wing.gauges.position[wing.gauges.names.index(g), :2], 4).tolist()}
            for g in aircraft.gauges
        ],
        "traced": [aircraft.gauges[g] for g in chosen],
        "trees": [drawn_tree(file) for file in aircraft.trees],
    }


def drawn_tree(file: TreeFile) -> list[dict[str, Any]]:
    """Return the nodes of a tree in preorder, with place, text and parent."""
    levels = depth(file.tree)
    found: list[dict[str, Any]] = []
    column = iter(range(len(list(nodes(file.tree)))))

    def add(node: Node, level: int, parent: int) -> float:
        own: dict[str, Any] = {"y": level / max(1, levels), "parent": parent, "is_leaf": isinstance(node, Leaf)}
        found.append(own)
        number = len(found) - 1
        if isinstance(node, Leaf):
            own |= {"x": float(next(column)), "text": f"{file.class_names[node.label]} %"}
        else:
            sides = [add(side, level + 1, number) for side in (node.left, node.right)]
            own |= {"x": sum(sides) / 2, "text": condition(node, file.feature_names)}
        return float(own["x"])

    add(file.tree, 0, -1)
    width = max(node["x"] for node in found) or 1.0
    for node in found:
        node["x"] = node["x"] / width
    return found
