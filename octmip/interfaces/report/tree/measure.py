"""What a tree is judged by, and all that the page says of it: whichever the loss, one of these answers.

`Measure` is what every page needs; `octmip.interfaces.report.tree.of_classes` and `of_numbers` say it of classes and
of numbers. `measure_of` in `contents.py` chooses.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.tree.evidence import Evidence, HeldOut
from octmip.interfaces.report.tree.words import Wording, figure
from octmip.trees.nodes.tree import Leaf, Node
from octmip.trees.tradeoff import Score

Card = tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class Measure(ABC):
    """The words and tables about what a tree of a file costs.

    Attributes
    ----------
    kicker
        what kind of tree it is.
    detail_heading
        heading of the tables that say how the tree goes wrong.
    leaf_column
        head of the table of leaves, behind answer, samples and share.
    """

    kicker: ClassVar[str]
    detail_heading: ClassVar[str]
    leaf_column: ClassVar[str]
    file: TreeFile

    # What is summed up

    @property
    @abstractmethod
    def noun(self) -> str:
        """What the objective counts."""

    @abstractmethod
    def fewer(self) -> str:
        """Return what a better tree would do."""

    @abstractmethod
    def amount(self, value: float) -> str:
        """Return an objective in words: 6 errors; a cost of 28.5."""

    @abstractmethod
    def below(self, value: float) -> str:
        """Return that a tree is below an objective, as a predicate: has less than 6 errors."""

    @abstractmethod
    def is_worse(self, difference: float) -> str:
        """Return by how much a tree is worse, as a predicate: makes 3 more errors; costs 2.5 more."""

    def least(self, bound: float) -> float:
        """Return the least objective that a bound leaves open."""
        return bound

    def none(self) -> str:
        """Return what is left when the objective is 0."""
        return f"no {self.noun}"

    def difference(self, value: float) -> str:
        """Return a difference of objectives, for a card."""
        return figure(value)

    # The top of the page

    @abstractmethod
    def answers(self) -> str:
        """Return what the tree answers with: one of three classes; a number."""

    @abstractmethod
    def training_sentence(self, evidence: Evidence | None) -> str:
        """Return how good the tree is on its training samples."""

    @abstractmethod
    def cards(self, evidence: Evidence | None) -> list[Card]:
        """Return the figures of the training samples."""

    @abstractmethod
    def held_card(self, evidence: Evidence) -> Card:
        """Return the figure of the samples held out."""

    # How good it is

    @abstractmethod
    def held_caution(self, held: HeldOut) -> list[str]:
        """Return what few samples held out leave open."""

    @abstractmethod
    def training_rows(self, evidence: Evidence | None) -> list[list[Any]]:
        """Return rows of this tree's figures; with evidence those of the greedy tree beside, and what it loses."""

    @abstractmethod
    def held_rows(self, evidence: Evidence) -> list[list[Any]]:
        """Return the same of the samples held out."""

    def recounted(self) -> str:
        """Return what a recount gives beside the objective; by itself it says all."""
        return ""

    # The tree and its leaves

    def legend(self) -> list[str]:
        """Return the names of the colours in the drawing; none where they say nothing."""
        return []

    @property
    @abstractmethod
    def leaf_note(self) -> str:
        """What a leaf shows."""

    @abstractmethod
    def details(self, evidence: Evidence | None, wording: Wording) -> list[dict[str, Any]]:
        """Return these tables."""

    @abstractmethod
    def leaf_cells(self, evidence: Evidence | None) -> list[Any]:
        """Return the cells below `leaf_column`, leaves from the left."""

    @abstractmethod
    def answer(self, leaf: Leaf, wording: Wording) -> str:
        """Return what a leaf answers."""

    # What errors cost, and settings

    def risk(self) -> dict[str, Any]:
        """Return how errors are weighed, where that is not all alike: sentences, and a table."""
        return {"sentences": [], "rows": []}

    @abstractmethod
    def settings(self) -> list[tuple[str, str | None]]:
        """Return the settings that only this kind of tree has."""

    # The scripts of the page

    @abstractmethod
    def script_data(self, wording: Wording) -> dict[str, Any]:
        """Return what the scripts say: the classes, or none of them; the name of what is answered."""

    @abstractmethod
    def script_leaf(self, leaf: Leaf, index: int, evidence: Evidence | None, wording: Wording) -> dict[str, Any]:
        """Return what they say of a leaf, the `index`-th from the left."""

    @abstractmethod
    def script_samples(self, evidence: Evidence, rows: Sequence[int], leaf: int) -> list[list[Any]]:
        """Return for samples of a leaf what is true, and how the answer misses it."""

    # Words on the command line

    def on_new_samples(self, found: Score) -> str:
        """Return what was lost on samples held out, in the page's figures."""
        return self.file.loss.words_of(found.measures, found.n_samples)

    @abstractmethod
    def line(self, evidence: Evidence, tree: Node, held: HeldOut | None = None) -> str:
        """Return how good a tree is on the training samples, or on those held out."""


def differs(value: float) -> str:
    """Return a difference of two trees as a cell of a table."""
    return "nothing" if value == 0 else f"{figure(value, 4)}" if value > 0 else f"{figure(value, 4)} (better)"
