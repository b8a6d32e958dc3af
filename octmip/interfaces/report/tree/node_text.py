"""The lines in a node's box, and all about it in one sentence."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.interfaces.report.tree.letters import fitting, wrapped
from octmip.interfaces.report.tree.words import Question, Wording, answered, counted, figure, number, percent
from octmip.trees.tree import HyperplaneSplit, Leaf, Split, ValueLeaf

ROOM = 208
"""Longest line of a box [px]."""
MOST_TERMS = 4
"""Lines of a split over several features; further ones are counted."""
SPREAD_DIGITS = 3
Written = Callable[[str], str]


@dataclass(frozen=True, slots=True)
class NodeText:
    """The lines of a box, its title, and how many of the lines say the answer of a leaf."""

    lines: tuple[str, ...]
    title: str
    n_answer: int = 0


def split_text(
    node: Split | HyperplaneSplit, asked: Question, wording: Wording, n_samples: int, written: Written
) -> NodeText:
    """Return the text of a split."""
    come = f"{counted(n_samples, 'sample')} come here"
    return NodeText(
        _few(asked.lines, written) if isinstance(node, HyperplaneSplit) else _two_each(asked.lines, written),
        f"{asked.text}? {_missing(node, wording)}{come}",
    )


def leaf_text(
    node: Leaf, name: str, counts: NDArray[np.int64], total: int, spread: float | None, written: Written
) -> NodeText:
    """Return the text of a leaf; `spread` is the standard deviation about its number."""
    here = int(counts.sum())
    share = percent(round(here / max(1, total), 3))
    answer, size = wrapped(written(name), ROOM), f"{here:,}, {share}"
    title = f"Answer: {name}. {counted(here, 'sample')} ({share} of all)"
    if isinstance(node, ValueLeaf) and not node.features:
        title = title.replace(answered(node.value), number(node.value))
    if not isinstance(node, ValueLeaf):
        wrong = here - int(counts[node.label])
        return NodeText((*answer, size, f"{wrong:,} wrong"), f"{title}, {wrong:,} of them wrong", len(answer))
    if spread is None:
        return NodeText((*answer, size), title, len(answer))
    off = figure(spread, SPREAD_DIGITS)
    return NodeText((*answer, f"± {off}", size), f"{title}, standard deviation {off}", len(answer))


def _two_each(lines: Sequence[str], written: Written) -> tuple[str, ...]:
    return tuple(part for line in lines for part in wrapped(written(line), ROOM))


def _few(lines: Sequence[str], written: Written) -> tuple[str, ...]:
    if len(lines) > MOST_TERMS + 1:
        lines = [*lines[: MOST_TERMS - 1], f"+ {len(lines) - MOST_TERMS} more", lines[-1]]
    return tuple(fitting(written(line), ROOM) for line in lines)


def _missing(node: Split | HyperplaneSplit, wording: Wording) -> str:
    """Return where a missing value goes where the question does not say it."""
    is_doubled = isinstance(node, Split) and wording.feature(node.feature).kind == "missing-right"
    is_right = is_doubled or (node.missing == "right" and not _asks_for_missing(node, wording))
    return "A missing value goes to no. " if is_right else ""


def _asks_for_missing(node: Split | HyperplaneSplit, wording: Wording) -> bool:
    """Whether the question itself is whether a value is missing, or is one of text, which has an answer of its own."""
    is_text = isinstance(node, Split) and wording.feature(node.feature).kind in ("is", "is-missing", "among")
    return is_text or (isinstance(node, Split) and node.threshold is None)
