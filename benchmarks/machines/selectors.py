"""What is asked about a machine, and what it says: names, probabilities, sizes, the new load, seconds, calls."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.machines.machine import Machine
from benchmarks.plain.least_squares import FITS, fits_of
from benchmarks.plain.selector import CREDIBLE, select
from octmip.gap import Campaign, Differences, FunctionTwin, Odds, diagnose, read_campaign
from octmip.twin import load_of

BUILT = 0.05
"""Sd of a constant of an asset over that of the drawing, where a diagnosis is told it."""
Groups = list[list[str]]
"""For every effect of a cause the names that cannot be told apart."""
Sizes = list[tuple[str, str, float, float]]
"""Name, place and 90 % interval of every effect of the first cause."""


@dataclass(frozen=True)
class Said:
    """An answer.

    Attributes
    ----------
    names, credible
        of the first cause and of the 95 % set.
    probability, unknown_probability
        as named.
    sizes
        of the first cause.
    doubts
        of the run.
    closed
        what the page says that the first cause closes; None where it says nothing.
    constants
        name and 90 % interval of each, where no run says them.
    new, before
        (n_readings,) at the load that no campaign holds, with the first cause and without.
    """

    names: Groups
    credible: list[Groups]
    probability: float
    unknown_probability: float
    sizes: Sizes
    doubts: list[str]
    closed: float | None = None
    new: tuple[float, ...] = ()
    before: tuple[float, ...] = ()
    constants: tuple[tuple[str, float, float], ...] = ()
    seconds: float = 0.0
    calls: int = 0


Selector = Callable[[Campaign, FunctionTwin, Campaign, Machine], Said]


def diagnosis(campaign: Campaign, twin: FunctionTwin, run: Campaign, machine: Machine) -> Said:
    """Return what octmip.gap says."""
    start = time.process_time()
    found = diagnose(campaign, twin, commissioning=run)
    seconds = time.process_time() - start
    calls = len(twin.answers)
    names = [[sorted(group) for group in cause.names] for cause in found.credible]
    first, closing = found.which[0], found.shrinkage
    load = load_of(twin.loads, tuple(machine.new_cell.values()))
    whole = found.augmented(twin)
    before = type(whole)(whole.twin, (), whole.difference)
    return Said(
        names=names[0],
        credible=names,
        probability=first.probability,
        unknown_probability=found.unknown_probability,
        sizes=[(p.effect, p.place, p.low, p.high) for p in first.parameters],
        doubts=list(found.doubts),
        closed=None if closing is None else float(closing.closed),
        new=tuple(whole.predict({}, load).tolist()),
        before=tuple(before.predict({}, load).tolist()),
        seconds=seconds,
        calls=calls,
    )


def plain(campaign: Campaign, twin: FunctionTwin, run: Campaign, machine: Machine) -> Said:
    """Return what the plain selector says."""
    start = time.process_time()
    found = select(campaign, twin, run)
    names = [[["unknown"]] if c.is_unknown else [sorted(group) for group in c.names] for c in found.credible]
    first = found.causes[0]
    return Said(
        names=names[0],
        credible=names,
        probability=first.probability,
        unknown_probability=found.unknown_probability,
        sizes=[(e.name, p, *s[1:]) for (e, p), s in zip(first.members, first.sizes.tolist(), strict=True)],
        doubts=[],
        seconds=time.process_time() - start,
        calls=len(twin.answers),
    )


def squares(campaign: Campaign, twin: FunctionTwin, run: Campaign, machine: Machine) -> Said:
    """Return what least squares with BIC and a chi-squared of the rest say."""
    start = time.process_time()
    fits = fits_of(campaign, twin, run)
    first, chance = fits[0], max(fit.chance for fit in fits)
    share = np.exp(-0.5 * np.array([fit.bic - first.bic for fit in fits]))
    share /= share.sum()
    before = np.cumsum([0.0, *share])
    names = [[[e.name] for e, _ in fit.members] for fit, sum_ in zip(fits, before, strict=False) if sum_ < CREDIBLE]
    is_unknown = chance < FITS
    return Said(
        names=[["unknown"]] if is_unknown else names[0],
        credible=[[["unknown"]]] if is_unknown else names,
        probability=1.0 - chance if is_unknown else float(share[0]),
        unknown_probability=1.0 - chance,
        sizes=[(e.name, p, *s[1:]) for (e, p), s in zip(first.members, first.sizes.tolist(), strict=True)],
        doubts=[],
        seconds=time.process_time() - start,
        calls=len(twin.answers),
    )


def bare(campaign: Campaign, twin: FunctionTwin, run: Campaign, machine: Machine) -> Said:
    """Return what octmip.gap says without the run, told how far constants are from the drawing."""
    start = time.process_time()
    found = diagnose(campaign, twin, odds=Odds(differences=Differences(constants=BUILT)))
    seconds = time.process_time() - start
    names = [[sorted(group) for group in cause.names] for cause in found.credible]
    constants = tuple((one.name, *one.interval) for one in found.constants)
    unknown = found.unknown_probability
    return Said(names[0], names, found.which[0].probability, unknown, [], [], constants=constants, seconds=seconds)


SELECTORS: Mapping[str, Selector] = {"diagnosis": diagnosis, "plain": plain, "squares": squares, "bare": bare}


def answer(place: Path, machine: Machine, selector: str) -> Said:
    """Return what a selector says of the case in a folder."""
    twin = machine.twin()
    campaign, run = (read_campaign(place / f"{name}.csv", twin) for name in ("campaign", "run"))
    return SELECTORS[selector](campaign, twin, run, machine)


def far(machine: Machine, values: tuple[float, ...], truth: list[float]) -> float:
    """Return how far readings are from the truth, in sds of noise."""
    return float(np.linalg.norm((np.array(values) - np.array(truth)) / machine.noise))
