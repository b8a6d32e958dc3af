"""The data of a mission page: what stays the same, and one entry per step, as JSON values with visible text."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission.player.record import Course, MissionStep, Region
from octmip.errors import DataError
from octmip.input.names import shown, visible
from octmip.interfaces.report.text import condition
from octmip.monitor import Belief, CompiledTree, Library, ParameterTree, Refusal
from octmip.trees.nodes.tree import Leaf, Node
from octmip.twin import Twin

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Asset:
    """What a mission is about.

    Attributes
    ----------
    library
        the states that are believed in.
    trees
        those at work.
    twin
        the model.
    limits
        by parameter, the value beyond which caution is needed.
    traced
        gauges whose strain is drawn.
    """

    library: Library
    trees: tuple[ParameterTree, ...]
    twin: Twin
    limits: Mapping[str, float]
    traced: tuple[str, ...]


def fixed_data(asset: Asset, course: Course, regions: Sequence[Region]) -> dict[str, Any]:
    """Return what is the same at every step."""
    parameters = [
        {"name": name, "most": _most(asset.library, k), "limit": asset.limits.get(name)}
        for k, name in enumerate(asset.library.parameters)
    ]
    return {
        "parameters": parameters,
        "traced": [shown(name) for name in asset.traced],
        "trees": [_tree_data(asset, tree) for tree in asset.trees],
        "course": _course_data(course),
        "structure": _structure_data(asset, regions),
    }


def _most(library: Library, parameter: int) -> float:
    """Return the upper end of a parameter's axis."""
    return round(float(library.states[:, parameter].max() + library.widths[parameter] / 2) or 1.0, 6)


def _tree_data(asset: Asset, tree: ParameterTree) -> dict[str, Any]:
    """Return a tree as nodes in preorder, each with its text and the number of its parent."""
    nodes: list[dict[str, Any]] = []

    def add(node: Node, parent: int, side: str) -> None:
        number = len(nodes)
        text = percent(tree.values[node.label]) if isinstance(node, Leaf) else condition(node, tree.gauges)
        nodes.append({"parent": parent, "side": side, "text": text, "leaf": isinstance(node, Leaf)})
        if not isinstance(node, Leaf):
            add(node.left, number, "yes")
            add(node.right, number, "no")

    add(tree.tree, -1, "")
    return {"name": tree.parameter, "nodes": nodes}


def percent(share: float) -> str:
    """Return a state parameter's value in per cent."""
    return f"{100 * share:.3g} %"


def _course_data(course: Course) -> dict[str, Any]:
    lines = [{"name": visible(name), "points": _points(line)} for name, line in course.lines.items()]
    return {"lines": lines, "obstacles": [list(one) for one in course.obstacles], "goal": course.goal}


def _points(points: Any) -> list[list[float]]:
    found: list[list[float]] = np.round(np.asarray(points, dtype=np.float64)[:, :2], 4).tolist()
    return found


def _structure_data(asset: Asset, regions: Sequence[Region]) -> dict[str, Any]:
    """Return outline, gauges and regions of the structure."""
    at = dict(zip(asset.twin.gauges, _points(getattr(asset.twin, "gauge_positions", [])), strict=False))
    gauges = [{"name": shown(name), "at": at[name]} for name in asset.library.gauges if name in at]
    parameters = asset.library.parameters
    known = [{"of": parameters.index(r.parameter), "outline": _points(r.outline)} for r in regions]
    return {"outline": _points(getattr(asset.twin, "outline", [])), "gauges": gauges, "regions": known}


def steps_data(asset: Asset, steps: Sequence[MissionStep]) -> list[dict[str, Any]]:
    """Return one entry per step; where a reading was refused the belief before it stands."""
    compiled = [CompiledTree(tree.tree, tree.gauges) for tree in asset.trees]
    columns = [[asset.library.gauges.index(name) for name in tree.gauges] for tree in asset.trees]
    believed: list[dict[str, Any]] | None = None
    off: list[str] = []
    found = []
    for step in steps:
        result = step.result
        refused = isinstance(result, Refusal)
        belief = None if isinstance(result, Refusal) else result.belief
        believed = believed if belief is None else _belief_data(asset.library, belief)
        finding = None if isinstance(result, Refusal) else result.finding
        off = off if finding is None else [shown(name) for name in finding.gauges]
        row = step.reading / step.load_factor
        seen = [_seen(tree, row[own]) for tree, own in zip(compiled, columns, strict=True)]
        told = [None if label is None else t.values[label] for (label, _), t in zip(seen, asset.trees, strict=True)]
        found.append(
            {
                "load": _short(step.load_factor, 3),
                "decision": visible(step.decision),
                "cautious": bool(step.is_cautious),
                "reason": visible(step.reason),
                "belief": believed,
                "paths": [path for _, path in seen],
                "told": told,
                "truth": _truth(asset.library, step),
                "strain": _strain_data(asset, row, believed),
                "p": None if isinstance(result, Refusal) else _maybe(result.p_value, 4),
                "alarm": "" if finding is None else visible(finding.words),
                "refused": visible(result.words) if isinstance(result, Refusal) else "",
                "off": off,
                "at": None if step.at is None else [_short(v, 2) for v in step.at],
                "figures": [[visible(name), visible(value)] for name, value in step.figures.items()],
            }
        )
        assert refused == bool(found[-1]["refused"])
    return found


def _seen(tree: CompiledTree, row: Floats) -> tuple[int | None, list[int]]:
    """Return the class that a tree gives a reading and the way there; None where it lacks a gauge it asks for."""
    try:
        return tree.label(row), list(tree.path_to(tree.node(row)))
    except DataError:
        return None, []


def _belief_data(library: Library, belief: Belief) -> list[dict[str, Any]]:
    """Return every parameter's probabilities, median and 90 % interval."""
    found = []
    for name in library.parameters:
        levels, mass = belief.marginal(name)
        low, high = belief.interval(name)
        found.append(
            {
                "at": [_short(v, 4) for v in levels],
                "bars": [_short(v, 4) for v in mass[0]],
                "median": _short(belief.quantile(name, 0.5)[0], 4),
                "low": _short(max(0.0, float(low[0])), 4),
                "high": _short(high[0], 4),
            }
        )
    return found


def _truth(library: Library, step: MissionStep) -> list[float] | None:
    if step.truth is None:
        return None
    return [_short(step.truth.get(name, 0.0), 4) for name in library.parameters]


def _strain_data(asset: Asset, row: Floats, believed: list[dict[str, Any]] | None) -> list[list[float | None]]:
    """Return measured and expected strain per unit of load of the traced gauges."""
    columns = [asset.library.gauges.index(name) for name in asset.traced]
    expected = None if believed is None else _expected(asset, [of["median"] for of in believed])
    return [[_maybe(float(row[g]), 1), None if expected is None else _maybe(float(expected[g]), 1)] for g in columns]


def _expected(asset: Asset, state: list[float]) -> Floats:
    """Return the strains (n_gauges,) per unit of load of a believed state."""
    library = asset.library
    load, factor = library.asked_at
    strains = asset.twin.predict(dict(zip(library.parameters, state, strict=True)), load) / factor
    return np.asarray(strains)[[asset.twin.gauges.index(name) for name in library.gauges]]


def _short(value: float, digits: int) -> float:
    return round(float(value), digits)


def _maybe(value: float | None, digits: int) -> float | None:
    return None if value is None or not np.isfinite(value) else _short(value, digits)
