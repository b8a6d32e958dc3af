"""What a page says of trees of classes: errors where every sample and every error counts the same, else their cost."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.tree.curve import roc_curve
from octmip.interfaces.report.tree.evidence import Evidence, HeldOut
from octmip.interfaces.report.tree.words import (
    Card,
    Wording,
    compact,
    counted,
    differs,
    figure,
    listed,
    percent,
    short_name,
    short_names,
)
from octmip.trees.nodes.tree import Leaf, Node, leaves, predict
from octmip.trees.tradeoff.held_out import Ranking, Score, balanced_accuracy, recall_precision, score

MOST_CLASSES = 30
"""Classes that a table of confusions has room for."""
MOST_COSTS = 12
"""Classes that a table of costs has room for."""
FEW = 100
"""Samples below which the interval of an error rate is said."""


@dataclass(frozen=True, slots=True)
class OfClasses:
    """The words and tables about a tree of classes.

    Attributes
    ----------
    kicker
        what kind of tree it is.
    detail_heading
        heading of the tables that say how the tree goes wrong.
    leaf_column
        head of the table of leaves, behind answer, samples and share.
    file
        the tree and its claims.
    is_errors
        whether the objective is the number of errors.
    """

    kicker = "Classification tree"
    detail_heading = "Which classes the tree confuses"
    leaf_column = "wrong"
    file: TreeFile
    is_errors: bool

    @classmethod
    def of(cls, file: TreeFile) -> "OfClasses":
        """Return the measure of a file of classes."""
        costs = np.array(file.settings["loss"]["costs"])
        is_plain = bool((costs == 1 - np.eye(len(costs))).all()) and not file.settings["leaf_penalty"]
        return cls(file, is_plain and not file.is_weighted and file.solution.objective == errors_of(file))

    @property
    def noun(self) -> str:
        """What the objective counts."""
        return "errors" if self.is_errors else "cost"

    def fewer(self) -> str:
        """Return what a better tree would do."""
        return "makes fewer errors" if self.is_errors else "costs less"

    def amount(self, value: float) -> str:
        """Return an objective in words: 6 errors; a cost of 28.5."""
        return counted(round(value), "error") if self.is_errors else f"a cost of {figure(value)}"

    def below(self, value: float) -> str:
        """Return that a tree is below an objective, as a predicate."""
        return f"has less than {self.amount(value)}"

    def is_worse(self, difference: float) -> str:
        """Return by how much a tree is worse, as a predicate: makes 3 more errors; costs 2.5 more."""
        if self.is_errors:
            return f"makes {counted(round(difference), 'more error')}"
        return f"costs {figure(difference)} more"

    def least(self, bound: float) -> float:
        """Return the least objective that a bound leaves open: errors are whole."""
        return math.ceil(bound - 1e-9) if self.is_errors else bound

    def none(self) -> str:
        """Return what is left when the objective is 0."""
        return f"no {'error' if self.is_errors else 'cost'}"

    def difference(self, value: float) -> str:
        """Return a difference of objectives, for a card."""
        unit = f" {'error' if value == 1 else 'errors'}" if self.is_errors else ""
        return f"{figure(value)}{unit}"

    def answers(self) -> str:
        """Return how many classes there are, and which."""
        names = self.file.class_names
        return f"One of {len(names)} classes ({listed(short_names(names), 6)})"

    def training_sentence(self, evidence: Evidence | None) -> str:
        """Return how many samples are right, and what the tree costs."""
        n, wrong = self.file.n_samples, errors_of(self.file)
        right = f"The tree gets {n - wrong:,} of {counted(n, 'sample')} right ({percent((n - wrong) / n)})"
        return f"{right}{'' if self.is_errors else f', at {self.amount(self.file.solution.objective)}'}."

    def cards(self, evidence: Evidence | None) -> list[Card]:
        """Return errors, and the cost where that is something else."""
        wrong, n = errors_of(self.file), self.file.n_samples
        cards: list[Card] = [("Wrong in training", f"{wrong:,}", f"of {n:,} ({percent(wrong / n)})")]
        cost = ("Cost", compact(self.file.solution.objective), "errors weighed, splits charged")
        return cards if self.is_errors else [*cards, cost]

    def held_card(self, evidence: Evidence) -> Card:
        """Return the share of the samples held out that are wrong."""
        held = evidence.held_out
        if held is None:
            return ("Wrong on new samples", "unknown", "none were held out")
        wrong = _wrong(held, held.tree)
        return ("Wrong on new samples", percent(wrong / held.n_samples), f"{wrong:,} of {held.n_samples:,} held out")

    def held_caution(self, held: HeldOut) -> list[str]:
        """Return the interval of the error rate where samples are few."""
        if held.n_samples >= FEW:
            return []
        low, high = _wilson(_wrong(held, held.tree), held.n_samples)
        return [
            f"So few samples say little: an error rate from {percent(low)} to {percent(high)} agrees with them (95 %)."
        ]

    def training_rows(self, evidence: Evidence | None) -> list[list[Any]]:
        """Return errors, and costs where they are something else."""
        wrong = errors_of(self.file)
        if evidence is None:
            return [["wrong on training samples", f"{wrong:,}"]]
        other = evidence.greedy_certificate.errors
        rows: list[list[Any]] = [["wrong on training samples", wrong, other, differs(other - wrong)]]
        if not self.is_errors:
            mine, its = self.file.solution.objective, evidence.greedy.objective
            rows.append(["cost", figure(mine), figure(its), differs(its - mine)])
        return rows

    def held_rows(self, evidence: Evidence) -> list[list[Any]]:
        """Return errors on samples held out, and the cost of one."""
        held = evidence.held_out
        if held is None:
            return []
        counts = [_wrong(held, tree) for tree in (held.tree, held.greedy)]
        shares = [f"{count:,} ({percent(count / held.n_samples)})" for count in counts]
        rows: list[list[Any]] = [["wrong on samples held out", *shares, differs(counts[1] - counts[0])]]
        if not self.is_errors:
            scores = [score(evidence.problem, tree, held.samples) for tree in (held.tree, held.greedy)]
            costs = [one.cost / held.n_samples for one in scores]
            each = [figure(cost, 4) for cost in costs]
            rows.append(["cost per held-out sample", *each, differs(costs[1] - costs[0])])
        return rows

    def recounted(self) -> str:
        """Return the errors where the objective is something else."""
        return "" if self.is_errors else f" and {counted(errors_of(self.file), 'error')}"

    def legend(self) -> list[str]:
        """Return the classes."""
        return short_names(self.file.class_names)

    @property
    def leaf_note(self) -> str:
        """What a leaf shows."""
        return (
            "A leaf shows its answer, the samples that end there with their share of all, and how many of them it gets "
            "wrong."
        )

    def details(self, evidence: Evidence | None, wording: Wording) -> list[dict[str, Any]]:
        """Return samples by true and predicted class, in training and held out."""
        found = [_confusion("Training samples", confusion_of(self.file), wording)]
        if evidence is not None and evidence.held_out is not None:
            held = evidence.held_out
            judged = score(evidence.problem, held.tree, held.samples)
            assert judged.confusion is not None
            assert judged.rank is not None
            found.append(_confusion("Samples held out", judged.confusion, wording, judged.rank()))
        return found

    def leaf_cells(self, evidence: Evidence | None) -> list[Any]:
        """Return how many samples of each leaf are wrong."""
        rows = zip(leaves(self.file.tree), self.file.leaf_counts, strict=True)
        return [int(counts.sum()) - int(counts[leaf.label]) for leaf, counts in rows]

    def answer(self, leaf: Leaf, wording: Wording) -> str:
        """Return the name of the class."""
        return wording.short(wording.classes[leaf.label])

    def risk(self) -> dict[str, Any]:
        """Return what the errors cost where they do not cost the same."""
        costs = np.array(self.file.settings["loss"]["costs"])
        if (costs == 1 - np.eye(len(costs))).all():
            return {"sentences": [], "rows": []}
        names = self.legend()
        if len(names) > MOST_COSTS:
            words = f"costs from {figure(float(costs.min()))} to {figure(float(costs.max()))}, by true class and answer"
            return {"sentences": [f"Errors do not cost the same: {words}."], "rows": []}
        rows = [[name, *(figure(cost) for cost in row)] for name, row in zip(names, costs.tolist(), strict=True)]
        caption = "Cost of an answer: true class in rows, answer in columns"
        table = {"head": ["true class", *names], "rows": rows, "right": range(1, len(names) + 1), "caption": caption}
        return {"sentences": ["Errors do not cost the same:"], **table}

    def settings(self) -> list[tuple[str, str | None]]:
        """Return the column of the class."""
        column = self.file.target_column
        return [("column of the class", short_name(column) if column else None)]

    def script_data(self, wording: Wording) -> dict[str, Any]:
        """Return the classes and the name of the label."""
        return {"classes": self.legend(), "label": short_name(self.file.target_column or "class", 40)}

    def script_leaf(self, leaf: Leaf, index: int, evidence: Evidence | None, wording: Wording) -> dict[str, Any]:
        """Return the class, and how many samples are wrong."""
        counts = self.file.leaf_counts[index]
        wrong = int(counts.sum()) - int(counts[leaf.label])
        return {
            "answer": short_names(self.file.class_names)[leaf.label],
            "miss": f"{wrong:,} of them wrong" if wrong else "none of them wrong",
        }

    def script_samples(self, evidence: Evidence, rows: Sequence[int], leaf: int) -> list[list[Any]]:
        """Return the true class of each sample, and 1 where the answer is another."""
        label = leaves(self.file.tree)[leaf].label
        codes = evidence.problem.samples.codes[list(rows)].tolist()
        names = self.legend()
        return [[names[code], int(code != label)] for code in codes]

    def on_new_samples(self, found: Score) -> str:
        """Return what was lost on samples held out."""
        return self.file.loss.words_of(found.measures, found.n_samples)

    def line(self, evidence: Evidence, tree: Node, held: HeldOut | None = None) -> str:
        """Return how many samples are wrong, and of the training the objective."""
        problem = evidence.problem
        found = score(problem, tree, None if held is None else held.samples)
        share = percent(found.error_rate)
        if held is not None:
            return f"{found.errors} of {found.n_samples} wrong ({share})"
        return f"{found.errors} wrong ({share}), objective {figure(problem.objective(tree))}"


def errors_of(file: TreeFile) -> int:
    """Return how many training samples the tree gets wrong."""
    labels = [leaf.label for leaf in leaves(file.tree)]
    right = sum(int(row[label]) for label, row in zip(labels, file.leaf_counts, strict=True))
    return int(file.leaf_counts.sum()) - right


def _wrong(held: HeldOut, tree: Node) -> int:
    return int((predict(tree, held.samples.features) != held.samples.codes).sum())


def _wilson(wrong: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """Return the interval of an error rate. Source: Wilson (1927)."""
    share, width = wrong / n, 1 + z * z / n
    middle = (share + z * z / (2 * n)) / width
    half = z / width * (share * (1 - share) / n + z * z / (4 * n * n)) ** 0.5
    return max(0.0, middle - half), min(1.0, middle + half)


def confusion_of(file: TreeFile) -> NDArray[np.int64]:
    """Return training samples by true and predicted class, shape (n_classes, n_classes)."""
    counts = np.zeros((len(file.class_names), len(file.class_names)), dtype=np.int64)
    for leaf, row in zip(leaves(file.tree), file.leaf_counts, strict=True):
        counts[:, leaf.label] += row
    return counts


def _confusion(
    what: str, counts: NDArray[np.int64], wording: Wording, ranking: Ranking | None = None
) -> dict[str, Any]:
    names = short_names(wording.classes)
    good = f"balanced accuracy {percent(balanced_accuracy(counts))}"
    caption = f"{what}: true class in rows, answer of the tree in columns; {good}, the mean recall of the classes"
    if len(names) <= MOST_CLASSES:
        recall, precision = (list(map(percent, shares.tolist())) for shares in recall_precision(counts))
        by_class = {"recall": recall}
        if ranking is not None:
            by_class["AUROC"] = [figure(area, 3) for area in ranking.auroc.tolist()]
        lines = zip(names, counts.tolist(), *by_class.values(), strict=True)
        rows = [[name, *row, sum(row), *shown] for name, row, *shown in lines]
        return {
            "caption": caption,
            "head": ["true class", *names, "all", *by_class],
            "rows": [*rows, ["precision", *precision, "", *("" for _ in by_class)]],
            "right": range(1, len(names) + 2 + len(by_class)),
            "roc": ranking and roc_curve(ranking, names),
        }
    wrong = counts - np.diag(np.diag(counts))
    worst = np.argsort(-wrong, axis=None, kind="stable")[:MOST_CLASSES]
    pairs = [divmod(int(k), len(names)) for k in worst if wrong.flat[k] > 0]
    rows = [[names[true], names[got], int(wrong[true, got])] for true, got in pairs]
    head = ["true class", "answer", "samples"]
    return {"caption": f"{what}: the most frequent errors", "head": head, "rows": rows, "right": (2,)}
