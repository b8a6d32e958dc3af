"""Inputs of an inference: a campaign averaged into cells, the twin, the noise, the discrepancy and the candidates.

All of them hold whatever the states of the asset are; what depends on the states is the linear model's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign.averages import AveragedCell, averages_of
from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.noise import Noise
from octmip.gap.channels.checks import calm, checked
from octmip.gap.channels.source_of_noise import noise_of
from octmip.gap.inference.candidates import Candidate, Priors, candidates_of, priors_of
from octmip.gap.inference.discrepancy import Discrepancy, calibrated, uncalibrated
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
    discrepancy, of_discrepancy = _discrepancy(known, asked, campaign.gauges, reference)
    groups, of_groups = _open_groups(campaign)
    inputs = Inputs(
        campaign=campaign,
        twin=asked,
        noise=noise,
        discrepancy=discrepancy,
        candidates=candidates_of(effects, asked, campaign.gauges),
        averages=averages_of(campaign, any(getattr(effect, "uses_time", False) for effect in effects.values())),
        reference=reference,
        groups=groups,
        progress=progress,
    )
    return inputs, [*checks.notes, *of_noise, *of_discrepancy, *of_groups]


def _discrepancy(
    known: Campaign | Discrepancy | None, twin: CachedTwin, gauges: tuple[str, ...], reference: float
) -> tuple[Discrepancy, list[str]]:
    """Return what twin and asset differ by before any effect: known, from a commissioning run, or what is usual."""
    if isinstance(known, Discrepancy):
        return known, []
    if known is not None:
        return calibrated(known, twin, gauges, reference), []
    healthy = twin.predict({}, reference)[[twin.gauges.index(name) for name in gauges]]
    return uncalibrated(healthy), [
        "No commissioning run: twin and asset may differ by about 1 % in common and 1 % per gauge before any effect; "
        "effects that scale all strains by less than about 1.5 % are invisible."
    ]


def _reference(campaign: Campaign, commissioning: Campaign | None) -> float:
    loads = [*campaign.loads, *(commissioning.loads if commissioning is not None else ())]
    greatest = max(loads, key=abs)
    return greatest if greatest != 0.0 else 1.0


def _open_groups(campaign: Campaign) -> tuple[Groups, list[str]]:
    """Return the cells that share an unknown state.

    Rows of one test share their state. Tests that were read at one load each, all loads different, are one state
    at several loads, as in a commissioning run.
    """
    by_test: dict[str, list[int]] = {}
    for k, cell in enumerate(campaign.cells):
        if not cell.is_known:
            by_test.setdefault(cell.test, []).append(k)
    loads = [{campaign.cells[k].load_factor for k in cells} for cells in by_test.values()]
    single = [next(iter(found)) for found in loads if len(found) == 1]
    if len(by_test) > 1 and len(single) == len(by_test) and len(set(single)) == len(single):
        note = (
            f"Tests {', '.join(by_test)} have unknown states and one load each, all different: read as one state at "
            "several loads. Give the state columns where that is wrong."
        )
        return (tuple(k for cells in by_test.values() for k in cells),), [note]
    return tuple(tuple(cells) for cells in by_test.values()), []
