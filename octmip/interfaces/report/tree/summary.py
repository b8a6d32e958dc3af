"""The top of the page: what the tree decides, how good it is, whether that is proven, what the greedy tree loses."""

import math
from collections.abc import Mapping
from typing import Any

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.new_rows import choice_of
from octmip.interfaces.report.tree.evidence import Evidence
from octmip.interfaces.report.tree.measure import Measure
from octmip.interfaces.report.tree.words import Card, Wording, counted, figure, listed, percent, short_name, short_names
from octmip.trees.answer.scope import depth_in_words
from octmip.trees.answer.solution import Stop
from octmip.trees.nodes.tree import depth, features_used
from octmip.trees.question.losses import ClassCosts
from octmip.trees.tradeoff import score


def title(file: TreeFile) -> str:
    """Return the heading."""
    return f"A decision tree for {short_name(file.target_column, 60)}" if file.target_column else "A decision tree"


def subtitle(file: TreeFile, measure: Measure, wording: Wording) -> str:
    """Return what the tree decides from what."""
    levels = depth(file.tree)
    if not levels:
        return f"{measure.answers()}; this tree always gives the same answer."
    asked = f"at most {counted(levels, 'question')}"
    return f"{measure.answers()}, by {asked} about {_columns_read(file, wording)}."


def columns_read(file: TreeFile, wording: Wording) -> list[str]:
    """Return the columns of the table that the tree reads, in the order of the table."""
    return list(dict.fromkeys(wording.feature(j).column for j in features_used(file.tree)))


def _columns_read(file: TreeFile, wording: Wording) -> str:
    return listed(short_names(columns_read(file, wording)), 5)


def trees_meant(file: TreeFile) -> str:
    """Return the trees over which the bound speaks."""
    scope = file.solution.scope
    return (
        f"among {short_name(scope)}, no tree"
        if scope
        else f"no tree {depth_in_words(file.settings['depth'])} with these settings"
    )


def verdict(file: TreeFile, evidence: Evidence | None, measure: Measure) -> str:
    """Return the answer in two or three sentences."""
    good = measure.training_sentence(evidence)
    proof, greedy = _proof_sentence(file, measure), _greedy_sentence(evidence, measure, file)
    return " ".join(filter(None, [_new_samples(file, evidence, measure), good, proof, greedy]))


MORE = "let the solver run for longer"
WAYS_ON = {
    Stop.FINISHED: "the search has ended, so ask a method that proves (exact) or another seed",
    Stop.GAP: "ask for a smaller gap",
    Stop.MEMORY: "give the solver more memory",
    Stop.NUMERICS: "scale the columns, as arithmetic allows no more",
}


def _new_samples(file: TreeFile, evidence: Evidence | None, measure: Measure) -> str:
    """Return what holds on new samples: counted on samples held out, or expected by cross-validation."""
    if evidence is not None and (held := evidence.held_out) is not None:
        lost = {"": held.tree, "the greedy tree": held.greedy}
        found = {name: score(evidence.problem, tree, held.samples) for name, tree in lost.items()}
        found |= {f"{name} of a hundred trees or more": one for name, one in evidence.ensembles.items()}
        words = [f"{name}{name and ': '}{measure.on_new_samples(one)}" for name, one in found.items()]
        return f"On new samples: {'; '.join(words)}."
    expected = expected_errors(file)
    if expected is None:
        return ""
    beside = (
        "" if expected["cart"] is None else f", of CART pruned by the same folds {percent(expected['cart']['mean'])}"
    )
    return f"On new samples {percent(expected['tree']['mean'])} are expected to be wrong{beside} (cross-validation)."


def expected_errors(file: TreeFile) -> Mapping[str, Any] | None:
    """Return what a chosen tree costs on new samples, where that is a share of errors; None without a choice."""
    choice = choice_of(file.solution) or {}
    is_share = isinstance(file.loss, ClassCosts) and file.loss.is_zero_one and not file.is_weighted
    return choice.get("expected") if is_share else None


def _proof_sentence(file: TreeFile, measure: Measure) -> str:
    solution = file.solution
    if solution.meets_bound and solution.objective == 0:
        return "No tree can do better on them."
    if solution.meets_bound:
        return f"Proven: {trees_meant(file)} {measure.fewer()}."
    if not math.isfinite(solution.bound):
        return "Whether a better tree exists is not known: the method that found it gives no proof."
    least = measure.least(solution.bound)
    if least <= 0:
        return f"Not proven to be the best: nothing is ruled out yet, so {way_on(file)}."
    return (
        f"Not proven to be the best: {trees_meant(file)} {measure.below(least)}, "
        f"so a gap of {percent(solution.gap)} stays open."
    )


def way_on(file: TreeFile) -> str:
    """Return what finds a better tree, by what the solver ended with."""
    solution = file.solution
    if solution.meets_bound and (scope := solution.scope):
        return f"it is the best among {short_name(scope)} only"
    return WAYS_ON.get(solution.stop, MORE)


def _greedy_sentence(evidence: Evidence | None, measure: Measure, file: TreeFile) -> str:
    if evidence is None:
        return ""
    loss = evidence.greedy.objective - file.solution.objective
    if loss > 0:
        return f"The usual greedy tree (CART) {measure.is_worse(loss)}."
    if loss < 0:
        return f"The usual greedy tree (CART) is better than this one: {way_on(file)}."
    return f"The usual greedy tree (CART) happens to be as good: {measure.amount(evidence.greedy.objective)} too."


def figures(file: TreeFile, evidence: Evidence | None, measure: Measure, wording: Wording) -> list[Card]:
    """Return the key figures."""
    cards = measure.cards(evidence)
    if evidence is not None:
        held = measure.held_card(evidence) if evidence.held_out is not None else _expected_card(file)
        cards = [held or measure.held_card(evidence), *cards, _greedy_card(file, evidence, measure)]
    return [*cards, _proof_card(file, measure), _reads_card(file, wording)]


def _expected_card(file: TreeFile) -> Card | None:
    """Return what cross-validation expects on new samples; None where no tree was chosen by it."""
    expected = expected_errors(file)
    if expected is None:
        return None
    low, high = percent(expected["tree"]["low"]), percent(expected["tree"]["high"])
    return ("Wrong on new samples", percent(expected["tree"]["mean"]), f"expected; {low} to {high}")


def _greedy_card(file: TreeFile, evidence: Evidence, measure: Measure) -> Card:
    loss = evidence.greedy.objective - file.solution.objective
    both = f"{figure(evidence.greedy.objective)} instead of {figure(file.solution.objective)}"
    if loss > 0:
        return ("Greedy tree loses", measure.difference(loss), both)
    if loss < 0:
        return ("Greedy tree", "is better", both, "warn")
    return ("Greedy tree loses", "nothing", f"{measure.amount(evidence.greedy.objective)} too")


def _proof_card(file: TreeFile, measure: Measure) -> Card:
    solution = file.solution
    if solution.meets_bound:
        scope = solution.scope
        among = f"among {short_name(scope)}" if scope else depth_in_words(file.settings["depth"])
        return ("Proven best", "yes", among, "good")
    if not math.isfinite(solution.bound):
        return ("Proven best", "no", "no bound is known", "warn")
    return (
        "Proven best",
        "not yet",
        f"gap {percent(solution.gap)}" if solution.bound > 0 else "nothing is ruled out yet",
        "warn",
    )


def _reads_card(file: TreeFile, wording: Wording) -> Card:
    read = columns_read(file, wording)
    of = len({wording.feature(j).column for j in range(len(file.feature_names))})
    return (
        "Columns to read",
        f"{len(read):,}",
        f"of {of:,}: {listed(short_names(read, 24), 3)}" if read else f"of {of:,}",
    )
