"""The form in which every set of real measurements is answered: one case a row, written as JSON."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.real.by_diagnosis import Said

CREDIBLE = 0.95
MOST_CAUSES = 6
LEAST_PROBABILITY = 0.05
"""Of a cause beside the first hypothesis that is still listed."""
SURE = 0.9
"""Probability to be sound up to which the most probable cause is listed all the same."""
UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Answer:
    """What is said about a case.

    Attributes
    ----------
    case
        its name.
    judged
        hypotheses, most probable first.
    closed
        share of the gap that the first closes; None where it is not asked.
    note
        what was held out for it.
    """

    case: str
    judged: tuple[Said, ...]
    closed: float | None
    note: str = ""

    @property
    def sound_probability(self) -> float:
        """Probability that nothing acts."""
        return sum(one.probability for one in self.judged if not one.causes)

    @property
    def first(self) -> Said:
        """The most probable hypothesis."""
        return self.judged[0]

    def row(self) -> dict[str, Any]:
        """Return the case as the form wants it."""
        unknown = sum(one.probability for one in self.judged if UNKNOWN in {c.kind for c in one.causes})
        return {
            "case": self.case,
            "sound_probability": round(self.sound_probability, 4),
            "causes": _causes(self.judged),
            "set95": credible_set(self.judged),
            "unexplained_probability": round(unknown, 4),
            **({} if self.closed is None else {"closed": round(self.closed, 4)}),
            **({"note": self.note} if self.note else {}),
        }


def _causes(judged: Sequence[Said]) -> list[dict[str, Any]]:
    """Return the causes of the first hypothesis, then others, each with the probability that it acts at all."""
    acts: dict[tuple[str, str], float] = {}
    sizes: dict[tuple[str, str], tuple[np.ndarray, str]] = {}
    for one in judged:
        for cause, size in zip(one.causes, one.sizes, strict=False):
            key = (cause.kind, cause.place)
            acts[key] = acts.get(key, 0.0) + one.probability
            sizes.setdefault(key, (size, cause.unit))
    first = [(cause.kind, cause.place) for cause in judged[0].causes]
    first.sort(key=lambda key: -acts[key])
    others = sorted((key for key in acts if key not in first), key=lambda key: -acts[key])
    sound = sum(one.probability for one in judged if not one.causes)
    n_others = max(sum(acts[key] >= LEAST_PROBABILITY for key in others), 0 if first or sound > SURE else 1)
    kept = [*first, *others[:n_others]][:MOST_CAUSES]
    return [
        {
            "kind": kind, "place": place, "size": round(float(size[0]), 4), "low": round(float(size[1]), 4),
            "high": round(float(size[2]), 4), "unit": unit, "probability": round(acts[kind, place], 4),
        }
        for (kind, place), (size, unit) in ((key, sizes[key]) for key in kept) if kind != UNKNOWN
    ]  # fmt: skip


def credible_set(judged: Sequence[Said], share: float = CREDIBLE) -> list[list[str]]:
    """Return few causes of which one acts with this probability: the one that helps most is added until they do.

    A hypothesis of several causes is held by any one of them; ("sound", "") stands for none.
    """
    held = [{(c.kind, c.place) for c in one.causes} or {("sound", "")} for one in judged]
    left, found = [one.probability for one in judged], []
    while sum(left) > (1.0 - share) * sum(one.probability for one in judged):
        gain: dict[tuple[str, str], float] = {}
        for keys, probability in zip(held, left, strict=True):
            for key in keys:
                gain[key] = gain.get(key, 0.0) + probability
        best = max(gain, key=lambda key: gain[key])
        found.append(list(best))
        left = [0.0 if best in keys else probability for keys, probability in zip(held, left, strict=True)]
    return found


def write_answers(path: Path, answers: Sequence[Answer]) -> None:
    """Write the answers of a set as JSON, one case a line."""
    rows = ",\n".join(json.dumps(answer.row()) for answer in answers)
    path.write_text(f'{{"cases": [\n{rows}\n]}}\n')
