"""What is asked about a stranger's machine, and what it says: names, probabilities, seconds."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmarks.plain.selector import select
from octmip.gap import Campaign, FunctionTwin, diagnose, read_campaign

Groups = list[list[str]]
"""For every effect of a cause the names that cannot be told apart."""


@dataclass(frozen=True)
class Said:
    """An answer: names of the first cause and of the 95 % set, probabilities, doubts of the run, CPU seconds."""

    names: Groups
    credible: list[Groups]
    probability: float
    unknown_probability: float
    doubts: list[str]
    seconds: float


Selector = Callable[[Campaign, FunctionTwin, Campaign], Said]


def diagnosis(campaign: Campaign, twin: FunctionTwin, run: Campaign) -> Said:
    """Return what octmip.gap says."""
    start = time.process_time()
    found = diagnose(campaign, twin, commissioning=run)
    names = [[sorted(group) for group in cause.names] for cause in found.credible]
    first = found.which[0].probability
    return Said(names[0], names, first, found.unknown_probability, list(found.doubts), time.process_time() - start)


def plain(campaign: Campaign, twin: FunctionTwin, run: Campaign) -> Said:
    """Return what the plain selector says."""
    start = time.process_time()
    found = select(campaign, twin, run)
    names = [[["unknown"]] if c.is_unknown else [sorted(group) for group in c.names] for c in found.credible]
    first = found.causes[0].probability
    return Said(names[0], names, first, found.unknown_probability, [], time.process_time() - start)


SELECTORS: Mapping[str, Selector] = {"diagnosis": diagnosis, "plain": plain}


def answer(place: Path, twin: FunctionTwin, selector: str) -> Said:
    """Return what a selector says of the case in a folder."""
    campaign, run = (read_campaign(place / f"{name}.csv", twin) for name in ("campaign", "run"))
    return SELECTORS[selector](campaign, twin, run)
