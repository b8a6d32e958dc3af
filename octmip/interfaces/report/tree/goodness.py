"""How good the tree is: beside the greedy tree, on samples held out, and against trees of lower depth."""

from typing import Any

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.tree.evidence import DepthPoint, Evidence
from octmip.interfaces.report.tree.measure import Measure
from octmip.interfaces.report.tree.summary import expected_errors, way_on
from octmip.interfaces.report.tree.words import Wording, counted, differs, figure
from octmip.trees.nodes.tree import Node, depth, features_used, n_splits


def quality(file: TreeFile, evidence: Evidence | None, measure: Measure) -> list[str]:
    """Return what the figures below mean."""
    if evidence is None:
        return [
            "This page was made from the tree file alone. Given the data too, it also shows the greedy tree, trees of "
            "lower depth, and the samples in each leaf."
        ]
    sentences = ["A greedy tree (CART) chooses each split by itself and never looks back; most software grows it."]
    if file.settings["split"] == "hyperplane":
        sentences.append("The greedy tree has one feature in each split; this one may weigh several.")
    held = evidence.held_out
    if held is None:
        sentences.append(
            "Errors on training samples flatter every tree. The error that is expected on new samples stands above."
            if expected_errors(file)
            else "Errors on training samples flatter every tree. How it does on new samples was not measured for this "
            "page."
        )
    else:
        sentences.append(
            f"The error on new samples was measured on {counted(held.n_samples, 'sample')} of {held.source}."
        )
    if held is not None:
        sentences += measure.held_caution(held)
    return sentences


def comparison(file: TreeFile, evidence: Evidence | None, measure: Measure, wording: Wording) -> dict[str, Any]:
    """Return the table of this tree beside the greedy one."""
    if evidence is None:
        rows = [*measure.training_rows(None), ["splits", n_splits(file.tree)], ["depth", depth(file.tree)]]
        return {"head": ["", "this tree"], "rows": rows}
    greedy = evidence.greedy.tree
    rows = [*measure.training_rows(evidence), *measure.held_rows(evidence)]
    for name, count in (("splits", n_splits), ("depth", depth)):
        rows.append([name, count(file.tree), count(greedy), ""])
    rows.append(["columns read", _n_columns(file.tree, wording), _n_columns(greedy, wording), ""])
    if file.settings["sensor_budget"] is not None or any(cost != 1 for cost in evidence.problem.shape.sensor_costs):
        costs = [evidence.problem.shape.sensor_cost_of(tree) for tree in (file.tree, greedy)]
        rows.append(["cost of the sensors read", *(figure(cost) for cost in costs), differs(costs[1] - costs[0])])
    return {"head": ["", "this tree", "greedy tree", "greedy loses"], "rows": rows}


def _n_columns(tree: Node, wording: Wording) -> int:
    return len({wording.feature(j).column for j in features_used(tree)})


def depth_words(evidence: Evidence, measure: Measure) -> dict[str, Any]:
    """Return the sentences and the table beside the curve of depths."""
    points = evidence.depths
    head = ["depth", f"{measure.noun}, best tree", "proven at least", f"{measure.noun}, greedy"]
    rows = [[p.depth, figure(p.objective), _bound(p, measure), figure(p.greedy_objective)] for p in points]
    caption = f"Training {measure.noun} of the best tree found and of the greedy tree, by depth."
    if any(not p.is_proven for p in points):
        caption += " A line below a point reaches the bound: a better tree may lie on it."
    caption += f" Each lower depth had at most {figure(evidence.seconds, 2)} s."
    if any(p.greedy_objective is None for p in points):
        caption += f" The greedy tree, {figure(evidence.greedy.seconds, 2)} s each, was not grown for every depth."
    return {
        "depth_sentence": _depth_sentence(evidence, measure),
        "depth_table": {"head": head, "rows": rows},
        "curve_caption": caption,
    }


def _bound(point: DepthPoint, measure: Measure) -> str:
    return "the same: proven" if point.is_proven else figure(point.bound)


def _depth_sentence(evidence: Evidence, measure: Measure) -> str:
    points = evidence.depths
    last = points[-1]
    better = next((p for p in points if p.objective < last.objective), None)
    if better is not None:
        return (
            f"A tree of depth {better.depth} that was found for this page is better than this one of depth "
            f"{last.depth}: {way_on(measure.file)}."
        )
    same = next(p for p in points if p.objective == last.objective)
    if same.depth < last.depth:
        amount = measure.amount(same.objective)
        return f"No: a tree of depth {same.depth} is as good on the training samples, with {amount}."
    before = points[-2]
    loss = measure.is_worse(before.objective - last.objective)
    catch = next((p.depth for p in points if p.objective <= evidence.greedy.objective), last.depth)
    shallow = (
        f" The best tree of depth {catch} is no worse than the greedy tree of depth {last.depth}."
        if catch < last.depth
        else ""
    )
    return f"Depth {last.depth} pays on the training samples: the best tree of depth {before.depth} {loss}.{shallow}"
