"""The selector's answers to all cases of a set, once its keys are open; they are kept in a file beside the keys."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.blind.answers import Found
from benchmarks.blind.assets.asset import Asset
from benchmarks.blind.cases import Case
from benchmarks.blind.limit.record import limit
from benchmarks.blind.score import Pair, figures
from benchmarks.blind.sealing import Key
from benchmarks.blind.truths import Truth
from benchmarks.figure import Figure

UNSAID = ("seconds", "noise named", "channel named", "localisation", "exactly confounded")
"""Rows of which a selector says nothing."""


def limits(answers: Mapping[str, Key], assets: Mapping[str, Asset], kept: Path) -> list[Found]:
    """Return the selector's answers, with the commissioning run and without, computed where `kept` has none."""
    known: dict[str, list[Found]] = json.loads(kept.read_text()) if kept.exists() else {}
    for name, answer in answers.items():
        case = case_of(answer)
        if name in known or case.stratum == "channel":
            continue
        means = np.array(answer["means"])
        known[name] = [limit(case, assets[case.family], means, is_calibrated) for is_calibrated in (True, False)]
        kept.write_text(json.dumps(known))
    return [found for name in answers for found in known.get(name, [])]


def case_of(answer: Key) -> Case:
    """Return the case that a key was sealed for."""
    record = answer["case"]
    truths = tuple(Truth(**truth) for truth in record["truths"])
    states = tuple(tuple(state) for state in record["states"])
    loads = tuple(record["loads"])
    return Case(
        record["name"], record["stratum"], truths, states, record["is_known"], loads, record["noise"],
        record["family"], record["is_split"], record["run"],
    )  # fmt: skip


def judged(cases: Sequence[Pair]) -> list[Figure]:
    """Return the figures of what does no more than select: those that a diagnosis is judged by."""
    return [row for row in figures(cases) if not any(word in row.name for word in UNSAID)]
