"""What a page says of trees of numbers: the error that the loss sums up, and how far answers are off."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.tree.evidence import Evidence, HeldOut
from octmip.interfaces.report.tree.words import (
    MINUS,
    Card,
    Wording,
    answered,
    compact,
    counted,
    differs,
    figure,
    short_name,
)
from octmip.trees.nodes.tree import Leaf, Node, ValueLeaf, leaf_index, leaves, predict_values
from octmip.trees.tradeoff.held_out import Score, score

SHARES = (0.5, 0.8, 0.95, 1.0)
"""Shares of the samples that are no farther off than the tables say."""
DIGITS = 4
MEASURES = {"mae": "mean absolute error", "rmse": "root of the mean squared error"}
"""Words of the measures of which less is better; others are called by their names."""


@dataclass(frozen=True, slots=True)
class OfNumbers:
    """The words and tables about a tree of numbers; attributes as those of `OfClasses`."""

    kicker = "Regression tree"
    detail_heading = "How far off it is"
    leaf_column = "off by, on average"
    file: TreeFile

    @property
    def noun(self) -> str:
        """What the objective adds up."""
        return f"{self.file.loss.words} with splits charged" if self.file.settings["leaf_penalty"] else self._error

    @property
    def _error(self) -> str:
        return self.file.loss.words

    @property
    def _target(self) -> str:
        return short_name(self.file.target_column or "target", 40)

    def fewer(self) -> str:
        """Return what a better tree would do."""
        return f"has less {self.noun}"

    def amount(self, value: float) -> str:
        """Return an objective in words: a squared error of 28.5."""
        return f"{self._a_noun} of {figure(value)}"

    def below(self, value: float) -> str:
        """Return that a tree is below an objective, as a predicate: has a squared error below 28.5."""
        return f"has {self._a_noun} below {figure(value)}"

    @property
    def _a_noun(self) -> str:
        return f"{'an' if self.noun[0] in 'aeiou' else 'a'} {self.noun}"

    def is_worse(self, difference: float) -> str:
        """Return by how much a tree is worse, as a predicate."""
        return f"adds {figure(difference)} to the {self.noun}"

    def least(self, bound: float) -> float:
        """Return the least objective that a bound leaves open."""
        return bound

    def none(self) -> str:
        """Return what is left when the objective is 0."""
        return f"no {self.noun}"

    def difference(self, value: float) -> str:
        """Return a difference of objectives, for a card."""
        return figure(value)

    def answers(self) -> str:
        """Return what is estimated."""
        return f"An estimate of {self._target}"

    def training_sentence(self, evidence: Evidence | None) -> str:
        """Return how far off the tree is, where the data are at hand; else what it costs."""
        if evidence is None:
            return f"Over {counted(self.file.n_samples, 'sample')} it has {self.amount(self.file.solution.objective)}."
        off = figure(score(evidence.problem, self.file.tree).measures["mae"], DIGITS)
        return (
            f"On average the tree is off by {off} over {counted(self.file.n_samples, 'sample')}, with "
            f"{self.amount(self.file.solution.objective)}."
        )

    def cards(self, evidence: Evidence | None) -> list[Card]:
        """Return how far off the tree is, and what that costs."""
        cost = (self.noun.capitalize(), compact(self.file.solution.objective), f"{self.file.n_samples:,} samples")
        if evidence is None:
            return [cost]
        found = score(evidence.problem, self.file.tree)
        return [("Off by, in training", compact(found.measures["mae"]), "mean absolute error"), cost]

    def held_card(self, evidence: Evidence) -> Card:
        """Return how far off the tree is on samples held out."""
        held = evidence.held_out
        if held is None:
            return ("Off by, on new samples", "unknown", "none were held out")
        found = score(evidence.problem, held.tree, held.samples)
        return ("Off by, on new samples", compact(found.measures["mae"]), f"{held.n_samples:,} held out")

    def held_caution(self, held: HeldOut) -> list[str]:
        """Return the interval of the mean absolute error, by the spread of its samples."""
        off = np.abs(predict_values(held.tree, held.samples.features) - held.samples.codes)
        if len(off) < 2:
            return []
        half = 1.96 * float(off.std(ddof=1)) / len(off) ** 0.5
        low, high = max(0.0, float(off.mean()) - half), float(off.mean()) + half
        return [
            f"A mean absolute error from {figure(low, DIGITS)} to {figure(high, DIGITS)} agrees with these samples "
            "(95 %)."
        ]

    def training_rows(self, evidence: Evidence | None) -> list[list[Any]]:
        """Return objective, mean absolute error and root of the mean squared error."""
        mine = self.file.solution.objective
        if evidence is None:
            return [[self.noun, figure(mine)]]
        its = evidence.greedy.objective
        scores = [score(evidence.problem, tree) for tree in (self.file.tree, evidence.greedy.tree)]
        return [[self.noun, figure(mine), figure(its), differs(its - mine)], *_rows(scores, "in training")]

    def held_rows(self, evidence: Evidence) -> list[list[Any]]:
        """Return the same of samples held out."""
        held = evidence.held_out
        if held is None:
            return []
        scores = [score(evidence.problem, tree, held.samples) for tree in (held.tree, held.greedy)]
        costs = [one.cost / held.n_samples for one in scores]
        each = [figure(cost, DIGITS) for cost in costs]
        first = [f"{self._error} per held-out sample", *each, differs(costs[1] - costs[0])]
        return [first, *_rows(scores, "held out")]

    def recounted(self) -> str:
        """Return what a recount gives beside the objective: that says all."""
        return ""

    def legend(self) -> list[str]:
        """Return the names of the colours in the drawing: they say nothing."""
        return []

    @property
    def leaf_note(self) -> str:
        """What a leaf shows."""
        shows = (
            "A leaf shows its answer, behind ± the standard deviation of its samples where the data are at hand, and "
            "the samples that end there with their share of all."
        )
        if self.file.settings["leaf_model"] == "linear":
            return shows
        return f"{shows} Its bar says where the answer lies between the least of all leaves and the greatest."

    def details(self, evidence: Evidence | None, wording: Wording) -> list[dict[str, Any]]:
        """Return how far off shares of the samples are, in training and held out."""
        if evidence is None:
            return []
        samples = evidence.problem.samples
        found = [_misses("Training samples", predict_values(self.file.tree, samples.features) - samples.codes)]
        if evidence.held_out is not None:
            held = evidence.held_out
            off = predict_values(held.tree, held.samples.features) - held.samples.codes
            found.append(_misses("Samples held out", off))
        return found

    def leaf_cells(self, evidence: Evidence | None) -> list[Any]:
        """Return how far off each leaf is on average."""
        if evidence is None:
            return [figure(None) for _ in leaves(self.file.tree)]
        return [figure(float(off.mean()), DIGITS) if len(off) else figure(None) for off in self._off(evidence)]

    def _off(self, evidence: Evidence) -> list[NDArray[np.float64]]:
        """Return how far off each training sample is, those of each leaf together, leaves from the left."""
        problem, tree = evidence.problem, self.file.tree
        off = np.abs(predict_values(tree, problem.samples.features) - problem.samples.codes)
        reached = leaf_index(tree, problem.samples.features)
        return [off[reached == k] for k in range(len(leaves(tree)))]

    def answer(self, leaf: Leaf, wording: Wording) -> str:
        """Return the number, or the sum of a linear leaf."""
        return value_words(leaf, wording, self.file.target_column)

    def risk(self) -> dict[str, Any]:
        """Return how errors are weighed: all alike."""
        return {"sentences": [], "rows": []}

    def settings(self) -> list[tuple[str, str | None]]:
        """Return the column of the target, the loss, and what a leaf holds."""
        asked, column = self.file.settings, self.file.target_column
        is_linear = asked["leaf_model"] == "linear"
        return [
            ("column of the target", short_name(column) if column else None),
            ("loss", self._error),
            ("a leaf holds", f"a ridge regression, ridge {figure(asked['ridge'])}" if is_linear else "one number"),
        ]

    def script_data(self, wording: Wording) -> dict[str, Any]:
        """Return the name of the target; no classes."""
        return {"classes": [], "label": self._target}

    def script_leaf(self, leaf: Leaf, index: int, evidence: Evidence | None, wording: Wording) -> dict[str, Any]:
        """Return the answer, and how far it is off on average."""
        off = None if evidence is None else self._off(evidence)[index]
        known = off is not None and len(off) > 0
        miss = f"off by {figure(float(off.mean()), DIGITS)} on average" if known and off is not None else ""
        return {"answer": self.answer(leaf, wording), "miss": miss}

    def script_samples(self, evidence: Evidence, rows: Sequence[int], leaf: int) -> list[list[Any]]:
        """Return the target of each sample, and by how much the answer misses it."""
        problem, chosen = evidence.problem, list(rows)
        off = predict_values(self.file.tree, problem.samples.features[chosen]) - problem.samples.codes[chosen]
        pairs = zip(problem.samples.codes[chosen].tolist(), off.tolist(), strict=True)
        return [[f"{figure(true)} ({_signed(miss)})", 0] for true, miss in pairs]

    def on_new_samples(self, found: Score) -> str:
        """Return the measures of the loss on samples held out."""
        measured = (f"{MEASURES.get(name, name)} {figure(value, DIGITS)}" for name, value in found.measures.items())
        return ", ".join([counted(found.n_samples, "sample"), *measured])

    def line(self, evidence: Evidence, tree: Node, held: HeldOut | None = None) -> str:
        """Return the measures of the loss, and of the training the objective."""
        problem = evidence.problem
        found = score(problem, tree, None if held is None else held.samples)
        words = problem.loss.words_of(found.measures, found.n_samples)
        return words if held is not None else f"{words}, objective {figure(problem.objective(tree))}"


def value_words(leaf: Leaf, wording: Wording, target: str | None = None) -> str:
    """Return what a leaf of numbers answers: the number with its unit, or the sum of a linear leaf."""
    assert isinstance(leaf, ValueLeaf)
    terms = [answered(leaf.value)]
    for feature, coefficient in zip(leaf.features, leaf.coefficients, strict=True):
        sign = MINUS if coefficient < 0 else "+"
        terms.append(f"{sign} {answered(abs(coefficient))} {wording.short(wording.features[feature])}")
    return " ".join(terms) + (wording.unit(target) if target and not leaf.features else "")


def _signed(miss: float) -> str:
    return "exact" if miss == 0 else f"{'+' if miss > 0 else ''}{figure(miss, DIGITS)}"


def _rows(scores: Sequence[Score], where: str) -> list[list[Any]]:
    """Return a row for each measure of this tree and the greedy one."""
    rows: list[list[Any]] = []
    for name in scores[0].measures:
        mine, its = (one.measures[name] for one in scores)
        loses = differs(its - mine) if name in MEASURES else ""
        words = MEASURES.get(name, name)
        rows.append([f"{words}, {where}", figure(mine, DIGITS), figure(its, DIGITS), loses])
    return rows


def _misses(what: str, off: NDArray[np.float64]) -> dict[str, Any]:
    ordered = np.sort(np.abs(off))
    rows = []
    for share in SHARES:
        most = float(ordered[max(0, int(np.ceil(share * len(ordered))) - 1)])
        rows.append([f"{round(100 * share)} % of the samples" if share < 1 else "all samples", figure(most, DIGITS)])
    too_high = int((off > 0).sum())
    rows.append(["estimated too high", f"{too_high:,}"])
    rows.append(["estimated too low", f"{int((off < 0).sum()):,}"])
    return {
        "caption": f"{what}: how far off, and how many to each side",
        "head": ["", "off by at most"],
        "rows": rows,
        "right": (1,),
    }
