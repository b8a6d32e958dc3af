"""Inputs of an inference: a campaign averaged into cells, the twin, the noise, the discrepancy and the candidates.

All of them hold whatever the states of the asset are; what depends on the states is the linear model's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.clipping import unclipped
from octmip.gap.campaign.noise import Noise, estimate_noise, given_noise
from octmip.gap.inference.candidates import Candidate, Priors, candidates_of, priors_of
from octmip.gap.inference.discrepancy import Discrepancy, calibrated, uncalibrated
from octmip.gap.progress import Progress, silent
from octmip.gap.twins.cached import CachedTwin
from octmip.twin import Effect, Load, Twin, amounts_of

Floats = NDArray[np.float64]
Groups = tuple[tuple[int, ...], ...]

ENOUGH_FOR_HALVES = 16
"""Repeats from which a cell is averaged in two halves where time matters."""


@dataclass(frozen=True, slots=True, eq=False)
class AveragedCell:
    """Repeats that are averaged together: a cell of the campaign, or half of one where time matters.

    Attributes
    ----------
    cell
        index of the campaign's cell.
    mean, count
        (n_gauges,) of these repeats.
    time
        mean time [s].
    """

    cell: int
    mean: Floats
    count: NDArray[np.int64]
    time: float


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
        load of the greatest healthy readings.
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
    reference: Load
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
    def loads(self) -> tuple[Load, ...]:
        """(n_averages,) load of every averaged cell."""
        return tuple(self.cell_of(average).load for average in self.averages)

    def healthy(self, load: Load) -> Floats:
        """Return what the twin predicts (n_gauges,) of the healthy state at a load, for the campaign's gauges."""
        return self.twin.predict({}, load)[list(self.order)]

    def share_of_reference(self, load: Load) -> float:
        """Return how large a load is beside the reference load: their ratio, of several loads that of their readings.

        The readings' is phi, the projection of the healthy prediction on the one at the reference load.
        """
        if isinstance(load, float) and isinstance(self.reference, float):
            return load / self.reference
        return self.discrepancy.share(self.healthy(load), self.healthy(self.reference))

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
    campaign, rails, of_clipping = unclipped(campaign)
    run = unclipped(commissioning)[0] if isinstance(commissioning, Campaign) else None
    noise, of_noise = _noise(campaign, run, rails, noise_sd)
    _refuse_other_loads(campaign, run, asked)
    reference = _reference(campaign, run, asked)
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
    return inputs, [*of_clipping, *of_noise, *of_discrepancy, *of_groups]


def averages_of(campaign: Campaign, split: bool) -> tuple[AveragedCell, ...]:
    """Return whole cells, or the earlier and later half of each where `split` and time was recorded, averaged."""
    found = []
    start = float(np.nanmin(campaign.time)) if np.isfinite(campaign.time).any() else 0.0
    for k, cell in enumerate(campaign.cells):
        halves = [cell.rows]
        if split and campaign.has_time and len(cell.rows) >= ENOUGH_FOR_HALVES:
            rows = cell.rows[np.argsort(campaign.time[cell.rows], kind="stable")]
            halves = [rows[: len(rows) // 2], rows[len(rows) // 2 :]]
        for rows in halves:
            readings = campaign.readings[rows]
            count = np.isfinite(readings).sum(axis=0)
            mean = np.where(count > 0, np.nansum(readings, axis=0) / np.maximum(count, 1), np.nan)
            time = float(np.nanmean(campaign.time[rows])) - start if campaign.has_time else cell.time
            found.append(AveragedCell(k, mean, count, time))
    return tuple(found)


def _noise(
    campaign: Campaign,
    run: Campaign | None,
    rails: Mapping[str, float],
    noise_sd: float | Mapping[str, float] | None,
) -> tuple[Noise, list[str]]:
    """Return the noise with what is clipped, and notes on where it is from and on stuck channels."""
    noise, notes = _source_of_noise(campaign, run, noise_sd)
    if rails:
        noise = replace(noise, clipped=rails, findings=(*noise.findings, "clipping"))
    if noise.stuck:
        notes.append(f"Readings of {', '.join(noise.stuck)} never change between repeats: a stuck channel.")
    return noise, notes


def _source_of_noise(
    campaign: Campaign, run: Campaign | None, noise_sd: float | Mapping[str, float] | None
) -> tuple[Noise, list[str]]:
    """Return the noise and where it is from: the repeats, else the commissioning run's, else what is given."""
    given = None if noise_sd is None else given_noise(campaign.gauges, noise_sd)
    if campaign.has_repeats:
        unused = "The noise is estimated from the repeats; the given standard deviation is not used."
        return estimate_noise(campaign, run), [] if given is None else [unused]
    few = "Every test holds too few repeats to estimate the noise; "
    if given is not None:
        return given, [few + "the given standard deviation is taken as known."]
    return estimate_noise(campaign, run).of_gauges(campaign.gauges), [few + "the commissioning run's noise is used."]


def _discrepancy(
    known: Campaign | Discrepancy | None, twin: CachedTwin, gauges: tuple[str, ...], reference: Load
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


def _refuse_other_loads(campaign: Campaign, run: Campaign | None, twin: CachedTwin) -> None:
    """Refuse a campaign or a run whose loads are not the twin's."""
    for name, one in (("campaign", campaign), ("commissioning run", run)):
        if one is not None and one.load_names != twin.loads:
            raise DataError(
                f"the {name} has the loads {list(one.load_names)} but the twin {list(twin.loads)}; expected the same "
                "names in the same order; give them as load_names"
            )


def _reference(campaign: Campaign, commissioning: Campaign | None, twin: CachedTwin) -> Load:
    """Return the greatest load: of one load by its size, of several by what the healthy twin shows, gauge by gauge."""
    loads = [*campaign.loads, *(commissioning.loads if commissioning is not None else ())]
    if len(campaign.load_names) == 1:
        greatest = max(loads, key=lambda load: abs(amounts_of(load)[0]))
        return greatest if greatest != 0.0 else 1.0
    columns = [twin.gauges.index(name) for name in campaign.gauges]
    healthy = np.array([twin.predict({}, load)[columns] for load in loads])
    relative = healthy / np.maximum(np.abs(healthy).max(axis=0), 1e-300)
    return loads[int(np.argmax(np.sum(relative**2, axis=1)))]


def _open_groups(campaign: Campaign) -> tuple[Groups, list[str]]:
    """Return the cells that share an unknown state.

    Rows of one test share their state. Tests that were read at one load each, all loads different, are one state
    at several loads, as in a commissioning run.
    """
    by_test: dict[str, list[int]] = {}
    for k, cell in enumerate(campaign.cells):
        if not cell.is_known:
            by_test.setdefault(cell.test, []).append(k)
    loads = [{campaign.cells[k].load for k in cells} for cells in by_test.values()]
    single = [next(iter(found)) for found in loads if len(found) == 1]
    if len(by_test) > 1 and len(single) == len(by_test) and len(set(single)) == len(single):
        note = (
            f"Tests {', '.join(by_test)} have unknown states and one load each, all different: read as one state at "
            "several loads. Give the state columns where that is wrong."
        )
        return (tuple(k for cells in by_test.values() for k in cells),), [note]
    return tuple(tuple(cells) for cells in by_test.values()), []
