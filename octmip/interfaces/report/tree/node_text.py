"""The lines in a node's box, and all about it in one sentence."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.interfaces.report.tree.letters import wrapped
from octmip.interfaces.report.tree.words import ROOM, Question, Wording, answered, counted, figure, number, percent
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split, ValueLeaf

MOST_TERMS = 4
"""Lines of a split over several features; further ones are counted."""
SPREAD_DIGITS = 3
MOST_LINES = 8
"""Of a question for a set of texts."""


@dataclass(frozen=True, slots=True)
class NodeText:
    """The lines of a box, its title, and how many of the lines say the answer of a leaf."""

    lines: tuple[str, ...]
    title: str
    n_answer: int = 0


def split_text(node: Split | HyperplaneSplit, asked: Question, wording: Wording, n_samples: int) -> NodeText:
    """Return the text of a split."""
    lines, written = asked.lines, wording.written
    if len(lines) > MOST_TERMS + 1:
        lines = (*lines[: MOST_TERMS - 1], f"+ {len(lines) - MOST_TERMS} more", lines[-1])
    most = [2] * (len(lines) - 1) + [MOST_LINES]
    parts = [part for line, most in zip(lines, most, strict=True) for part in wrapped(written(line), ROOM, most)]
    come = f"{counted(n_samples, 'sample')} come here"
    return NodeText(tuple(parts), f"{asked.text}? {_missing(node, wording)}{come}")


def leaf_text(
    node: Leaf, name: str, wording: Wording, counts: NDArray[np.int64], total: int, spread: float | None
) -> NodeText:
    """Return the text of a leaf, whose answer is `name`; `spread` is the standard deviation about its number."""
    here = int(counts.sum())
    share = percent(round(here / max(1, total), 3))
    size, end = f"{here:,}, {share}", f"{counted(here, 'sample')} ({share} of all)"
    if not isinstance(node, ValueLeaf):
        wrong, name_in_box = here - int(counts[node.label]), wording.boxed(wording.classes[node.label])
        answer = wrapped(wording.written(name_in_box), ROOM)
        title = f"Answer: {name}. {end}, {wrong:,} of them wrong"
        return NodeText((*answer, size, f"{wrong:,} wrong"), title, len(answer))
    answer = wrapped(wording.written(name), ROOM, MOST_LINES if node.features else 2)
    title = f"Answer: {name if node.features else name.replace(answered(node.value), number(node.value))}. {end}"
    if spread is None:
        return NodeText((*answer, size), title, len(answer))
    off = figure(spread, SPREAD_DIGITS)
    return NodeText((*answer, f"± {off}", size), f"{title}, standard deviation {off}", len(answer))


def _missing(node: Split | HyperplaneSplit, wording: Wording) -> str:
    """Return where a missing value goes where the question does not say it."""
    is_doubled = isinstance(node, Split) and wording.feature(node.feature).kind == "missing-right"
    is_right = is_doubled or (node.missing == "right" and not _asks_for_missing(node, wording))
    return "A missing value goes to no. " if is_right else ""


def _asks_for_missing(node: Split | HyperplaneSplit, wording: Wording) -> bool:
    """Whether the question itself is whether a value is missing, or is one of text, which has an answer of its own."""
    is_text = isinstance(node, Split) and wording.feature(node.feature).kind in ("is", "is-missing", "among")
    return is_text or (isinstance(node, Split) and node.threshold is None)
