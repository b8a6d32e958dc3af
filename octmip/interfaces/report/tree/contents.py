"""The words and tables of the page of a tree, as its template takes them."""

import math
import shlex
from typing import Any

from octmip.formats.tree_file import TreeFile
from octmip.input.names import shown, visible
from octmip.interfaces.report.text import tree_text
from octmip.interfaces.report.tree.curve import depth_curve
from octmip.interfaces.report.tree.drawing import draw_tree
from octmip.interfaces.report.tree.embedded import node_data, sample_data
from octmip.interfaces.report.tree.evidence import Evidence
from octmip.interfaces.report.tree.goodness import comparison, depth_words, quality
from octmip.interfaces.report.tree.measure import Measure, measure_of
from octmip.interfaces.report.tree.proof import certificate_words
from octmip.interfaces.report.tree.seen import Seen
from octmip.interfaces.report.tree.settings import reads, risk, settings_rows
from octmip.interfaces.report.tree.summary import figures, subtitle, title, verdict
from octmip.interfaces.report.tree.svg import drawing_svg
from octmip.interfaces.report.tree.words import Wording, percent, question
from octmip.trees.answer.certificate import leaf_counts
from octmip.trees.answer.solution import Stop
from octmip.trees.nodes.tree import Leaf, Node, leaves
from octmip.trees.question.part_check import places
from octmip.trees.question.parts import address
from octmip.trees.tradeoff.edits import EditPrice

WIDE = 1100
"""A drawing wider than this takes the whole width of the page [px]."""


def page_contents(
    file: TreeFile,
    source: str | None,
    evidence: Evidence | None,
    wording: Wording,
    data: str | None,
    histograms: bool = False,
) -> dict[str, Any]:
    """Return the context of `tree.html`."""
    measure = measure_of(file)
    seen = Seen.of(evidence.problem, file.tree, histograms) if evidence else None
    drawing = draw_tree(file.tree, wording, file.leaf_counts, measure.answer, seen)
    page = {
        "kicker": measure.kicker,
        "title": title(file),
        "subtitle": subtitle(file, measure, wording),
        "verdict": verdict(file, evidence, measure),
        "figures": figures(file, evidence, measure, wording),
        "legend": measure.legend(),
        "leaf_note": measure.leaf_note,
        "is_wide": drawing.width > WIDE,
        "drawing_svg": drawing_svg(drawing, "The tree; arrow keys move, Enter selects", "tree"),
        "quality": quality(file, evidence, measure),
        "comparison": comparison(file, evidence, measure, wording),
        "greedy_svg": _greedy_svg(evidence, measure, wording, histograms),
        "detail_heading": measure.detail_heading,
        "details": measure.details(evidence, wording),
        "reads": reads(file, wording),
        "risk": risk(file, measure, evidence),
        "certificate": certificate_words(file, evidence, measure, data),
        "words": tree_text(file.tree, file.feature_names, file.class_names, file.leaf_counts, wording.columns),
        "leaves": _leaves(file, measure, evidence, wording),
        "edits": [[address(path), *one] for path, some in _others(file, measure, evidence).items() for one in some],
        "settings": settings_rows(file, measure),
        "commands": _commands(source, data) if source else "",
        "data": _data(file, measure, evidence, wording),
    }
    return page | _depths(evidence, measure)


def _greedy_svg(evidence: Evidence | None, measure: Measure, wording: Wording, histograms: bool) -> str:
    if evidence is None:
        return ""
    tree = evidence.greedy.tree
    counts, seen = leaf_counts(evidence.problem, tree), Seen.of(evidence.problem, tree, histograms)
    return drawing_svg(draw_tree(tree, wording, counts, measure.answer, seen), "The greedy tree")


def _depths(evidence: Evidence | None, measure: Measure) -> dict[str, Any]:
    if evidence is None or len(evidence.depths) < 2:
        return {"curve": None}
    words = depth_words(evidence, measure)
    return words | {"curve": depth_curve(evidence.depths, measure.noun)}


def _leaves(file: TreeFile, measure: Measure, evidence: Evidence | None, wording: Wording) -> dict[str, Any]:
    total = max(1, file.n_samples)
    ways = zip(_paths(file.tree, wording), leaves(file.tree), file.leaf_counts, strict=True)
    rows = []
    for (path, leaf, counts), cell in zip(ways, measure.leaf_cells(evidence), strict=True):
        here = int(counts.sum())
        rows.append([path or "always", measure.answer(leaf, wording), here, percent(here / total), cell])
    return {"head": ["questions on the way", "answer", "samples", "share", measure.leaf_column], "rows": rows}


def _paths(node: Node, wording: Wording) -> list[str]:
    """Return the answers that lead to each leaf, leaves from the left."""
    if isinstance(node, Leaf):
        return [""]
    asked = question(node, wording)
    words = ("yes", "no") if asked.yes_is_left else ("no", "yes")
    found = []
    for side, word in zip((node.left, node.right), words, strict=True):
        found += [f"{asked.text}: {word}{'; ' if path else ''}{path}" for path in _paths(side, wording)]
    return found


def _commands(source: str, data: str | None) -> str:
    """Return the commands that check the tree again; none where it is in no file."""
    if not source:
        return ""
    tree, table = shlex.quote(visible(source)), shlex.quote(visible(data)) if data else "DATA"
    return f"octmip certify {tree} {table}\noctmip certify {tree} {table} --proof LOG"


def _others(file: TreeFile, measure: Measure, evidence: Evidence | None) -> dict[str, list[list[str]]]:
    """Return by path other columns and what they cost there."""
    edits, own = {} if evidence is None else evidence.edits, file.solution.objective
    return {
        path: [[shown(price.sensor), price_words(price, own, measure)] for price in prices]
        for path, prices in edits.items()
    }


def price_words(price: EditPrice, own: float, measure: Measure) -> str:
    """Return what the best tree with another column costs, beside the objective of the page's tree."""
    if not price.is_possible:
        return "no such tree"
    if price.stop is Stop.OPTIMAL:
        more = price.objective - own
        change = f"{measure.difference(abs(more))} {'more' if more > 0 else 'less'}" if more else "no more"
        return f"{measure.amount(price.objective)} at the best, {change} than this tree; proven"
    least = measure.amount(measure.least(price.bound))
    most = f" and at most {measure.amount(price.objective)}" if math.isfinite(price.objective) else ""
    return f"not proven: at least {least}{most}"


def _data(file: TreeFile, measure: Measure, evidence: Evidence | None, wording: Wording) -> dict[str, Any]:
    others = _others(file, measure, evidence)
    said = [measure.script_leaf(leaf, k, evidence, wording) for k, leaf in enumerate(leaves(file.tree))]
    return {
        "nodes": node_data(
            file.tree, wording, file.leaf_counts, said, [others.get(path, []) for path, _ in places(file.tree)]
        ),
        **measure.script_data(wording),
        "total": file.n_samples,
        "samples": None if evidence is None else sample_data(evidence, measure, wording),
    }
