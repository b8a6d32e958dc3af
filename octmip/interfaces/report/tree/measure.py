"""What a tree is judged by: errors where every sample and every error counts the same, else its cost."""

from dataclasses import dataclass

import numpy as np

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.tree.words import counted, figure
from octmip.trees.tree import leaves


@dataclass(frozen=True, slots=True)
class Measure:
    """Whether the objective is the number of errors, and the words for it."""

    is_errors: bool

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

    def is_worse(self, difference: float) -> str:
        """Return by how much a tree is worse, as a predicate: makes 3 more errors; costs 2.5 more."""
        if self.is_errors:
            return f"makes {counted(round(difference), 'more error')}"
        return f"costs {figure(difference)} more"


def measure_of(file: TreeFile) -> Measure:
    """Return what the tree of a file is judged by."""
    costs = np.array(file.settings["loss"]["costs"])
    is_plain = bool((costs == 1 - np.eye(len(costs))).all()) and not file.settings["leaf_penalty"]
    return Measure(is_plain and file.weights_column is None and file.solution.objective == errors_of(file))


def errors_of(file: TreeFile) -> int:
    """Return how many training samples the tree gets wrong."""
    labels = [leaf.label for leaf in leaves(file.tree)]
    right = sum(int(row[label]) for label, row in zip(labels, file.leaf_counts, strict=True))
    return int(file.leaf_counts.sum()) - right
