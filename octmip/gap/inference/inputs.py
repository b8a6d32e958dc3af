"""Inputs of an inference: a campaign averaged into cells, the twin, the noise, the discrepancy and the candidates.

All of them hold whatever the states of the asset are; what depends on the states is the linear model's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign.averages import AveragedCell, averages_of
from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.noise import Noise
from octmip.gap.channels.checks import calm, checked
from octmip.gap.channels.source_of_noise import noise_of, noise_of_run
from octmip.gap.inference.candidates import Candidate, Priors, candidates_of, priors_of
from octmip.gap.inference.discrepancy import Discrepancy, calibrated, uncalibrated
from octmip.gap.odds import Odds
from octmip.gap.progress import Progress, silent
from octmip.gap.twins.cached import CachedTwin
from octmip.twin import Effect, Twin

Floats = NDArray[np.float64]
Groups = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Inputs:
    """The inputs of an inference.

    Attributes
    ----------
    campaign, twin, noise, discrepancy, candidates
        as named.
    averages
        the campaign's repeats, averaged.
    reference
        load factor of the greatest healthy strain.
    groups
        cells that share one unknown state, each a tuple of cell indices.
    progress
        told at every stage of what is made of these inputs.
    odds
        how probable causes are before any reading.
    Derived:
        order: position in the twin's gauges of each of the campaign's.
        priors: of the candidates.
    """

    campaign: Campaign
    twin: CachedTwin
    noise: Noise
    discrepancy: Discrepancy
    candidates: tuple[Candidate, ...]
    averages: tuple[AveragedCell, ...]
    reference: float
    groups: Groups
    progress: Progress = silent
    odds: Odds = Odds()  # noqa: RUF009  (frozen)
    order: tuple[int, ...] = field(init=False)
    priors: Priors = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "order", tuple(self.twin.gauges.index(name) for name in self.campaign.gauges))
        object.__setattr__(self, "priors", priors_of(self.candidates))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the state parameters."""
        return self.twin.parameters

    @property
    def load_factors(self) -> Floats:
        """(n_averages,) load factor of every averaged cell."""
        return np.array([self.cell_of(average).load_factor for average in self.averages])

    def effects(self) -> list[tuple[Effect, tuple[str, ...]]]:
        """Return every effect with its places, in the order of `candidates`."""
        grouped = [list(group) for _, group in groupby(self.candidates, key=lambda candidate: candidate.name)]
        return [(group[0].effect, tuple(candidate.place for candidate in group)) for group in grouped]

    def cell_of(self, average: AveragedCell) -> Cell:
        """Return the campaign's cell of an averaged one."""
        return self.campaign.cells[average.cell]

    def named(self, state: Floats) -> dict[str, float]:
        """Return a state (n_parameters,) as a mapping."""
        return dict(zip(self.names, state.tolist(), strict=True))


def prepare(
    campaign: Campaign,
    twin: Twin,
    effects: Mapping[str, Effect],
    commissioning: Campaign | Discrepancy | None = None,
    noise_sd: float | Mapping[str, float] | None = None,
    progress: Progress = silent,
    odds: Odds = Odds(),  # noqa: B008  (frozen)
) -> tuple[Inputs, list[str]]:
    """Return the inputs of an inference, and notes for the reader.

    Raises
    ------
    DataError
        a gauge that the twin does not know, no repeats at all, or a commissioning run that does not fit.
    """
    unknown = [name for name in campaign.gauges if name not in twin.gauges]
    if unknown:
        raise DataError(f"column {unknown[0]!r} is no gauge of the twin; expected among {list(twin.gauges[:3])}...")
    asked = twin if isinstance(twin, CachedTwin) else CachedTwin(twin)
    checks = checked(campaign)
    campaign = checks.campaign
    run = calm(commissioning) if isinstance(commissioning, Campaign) else None
    noise, of_noise = noise_of(checks, run, noise_sd)
    reference = _reference(campaign, run)
    known = commissioning if isinstance(commissioning, Discrepancy) else run
    discrepancy, of_discrepancy = _discrepancy(known, asked, noise, reference)
    inputs = Inputs(
        campaign=campaign,
        twin=asked,
        noise=noise,
        discrepancy=discrepancy,
        candidates=candidates_of(effects, asked, campaign.gauges, odds),
        averages=averages_of(campaign, any(getattr(effect, "uses_time", False) for effect in effects.values())),
        reference=reference,
        groups=_open_groups(campaign),
        odds=odds,
        progress=progress,
    )
    return inputs, [*checks.notes, *of_noise, *of_discrepancy]


def _discrepancy(
    known: Campaign | Discrepancy | None, twin: CachedTwin, noise: Noise, reference: float
) -> tuple[Discrepancy, list[str]]:
    """Return what twin and asset differ by before any effect: known, from a commissioning run, or what is usual."""
    if isinstance(known, Discrepancy):
        return known, []
    if known is not None:
        of_run, notes = noise_of_run(known, noise)
        return calibrated(known, twin, of_run, reference), notes
    return uncalibrated(twin, noise.gauges, reference), [
        "No commissioning run: twin and asset may differ by about 1 % in common and 1 % per gauge before any effect; "
        "effects that scale all strains by less than about 1.5 % are invisible."
    ]


def _reference(campaign: Campaign, commissioning: Campaign | None) -> float:
    loads = [*campaign.loads, *(commissioning.loads if commissioning is not None else ())]
    greatest = max(loads, key=abs)
    return greatest if greatest != 0.0 else 1.0


def _open_groups(campaign: Campaign) -> Groups:
    """Return the cells that share an unknown state: those of one test."""
    by_test: dict[str, list[int]] = {}
    for k, cell in enumerate(campaign.cells):
        if not cell.is_known:
            by_test.setdefault(cell.test, []).append(k)
    return tuple(tuple(cells) for cells in by_test.values())


def one_state(inputs: Inputs) -> Inputs | None:
    """Return the inputs with all unknown states the same, where tests were read at one load each, all different.

    So a commissioning run is read by some: one state, each load a test. Where tests have several loads, or a load comes
    twice, there is no sign of it.
    """
    loads = [{inputs.campaign.cells[k].load_factor for k in group} for group in inputs.groups]
    single = [next(iter(found)) for found in loads if len(found) == 1]
    if len(loads) < 2 or len(single) < len(loads) or len(set(single)) < len(single):
        return None
    return replace(inputs, groups=(tuple(k for group in inputs.groups for k in group),))


def doubted_state(inputs: Inputs, test: str) -> Inputs:
    """Return the inputs with the stated state of a test taken as unknown."""
    campaign = inputs.campaign
    states = campaign.states.copy()
    states[np.array(campaign.test) == test] = np.nan
    unknown = replace(campaign, states=states)
    return replace(inputs, campaign=unknown, groups=_open_groups(unknown))
