"""Inputs of an inference: a campaign averaged into cells, the twin, the noise, the discrepancy and the candidates.

All of them hold whatever the states of the asset are; what depends on the states is the linear model's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, TwinError
from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.noise import Noise, sizes
from octmip.gap.channels.checks import calm, checked, noise_of, noise_of_run
from octmip.gap.inference.candidates import Candidate, Priors, candidates_of, priors_of
from octmip.gap.inference.difference import (
    Difference,
    learnt,
    log_at_levels,
    poor_readings,
    usual_difference,
    wander_of,
)
from octmip.gap.inference.rows import Frame, Rows, recorded
from octmip.gap.odds import Differences, Odds
from octmip.gap.twins import CachedTwin
from octmip.twin import MIXED, Effect, Load, Twin, amounts_of, load_words, units_of

Floats = NDArray[np.float64]
Groups = tuple[tuple[int, ...], ...]

FIRST_OF_RUN = 1_000_000
"""Number of the first test of a commissioning run: no test of a campaign has it."""
OF_MODELS = {2.0: 0.85, 4.0: 0.15}
"""Levels of the difference without a run, and their probabilities: two models of a wing differ by 2.

With 1 as the most probable level 56 of 76 sound wings were called faulty without a run; clear effects are named as
often."""
STATED = {0.5: 0.2, 1.0: 0.45, 2.0: 0.25, 4.0: 0.1}
"""The same where `Odds` say themselves how far twin and asset lie apart, or where the constants are open beside it."""
NAMED = 4
"""Readings named one by one in a sentence about many."""


@dataclass(frozen=True, slots=True, eq=False)
class NoiseOfMeans:
    """A noise that repeats leave open.

    Attributes
    ----------
    noise
        of the readings.
    scatter, covariance
        (n, n) of the means, without the unknown offsets of gauges that jumped and with them.
    log_share
        log probability.
    """

    noise: Noise
    scatter: Floats
    covariance: Floats
    log_share: float

    @classmethod
    def every(cls, noise: Noise, averages: Sequence[Cell]) -> "tuple[NoiseOfMeans, ...]":
        """Return that of every size of a walk or memory, the most probable first."""
        rows = recorded(averages)
        open_ = [(own, own.of_averages(averages, *rows), share) for own, share in sizes(noise, averages)]
        return tuple(cls(own, found, found + own.of_jumps(averages, *rows), share) for own, found, share in open_)


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A commissioning run beside the twin.

    Attributes
    ----------
    campaign, averages, rows
        its readings.
    noises
        for every size of a walk or memory that its repeats leave open.
    noise
        covariance (n, n) of the one that bears its readings best.
    """

    campaign: Campaign
    averages: tuple[Cell, ...]
    rows: Rows
    noises: tuple[NoiseOfMeans, ...]
    noise: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Inputs:
    """The inputs of an inference.

    Attributes
    ----------
    campaign, difference, candidates
        as named; the difference is that of twin and asset before any effect.
    priors
        of the candidates.
    averages
        the campaign's repeats, averaged.
    reference
        load of the greatest healthy readings.
    groups
        cells that share one unknown state, each a tuple of cell indices.
    odds
        how probable causes are before any reading.
    frame
        what rows are measured by.
    run
        the commissioning run, if there is one that counts.
    noises, noise_of_means
        every noise that the repeats leave open, and the one that is taken.
    """

    campaign: Campaign
    difference: Difference
    candidates: tuple[Candidate, ...]
    priors: Priors
    averages: tuple[Cell, ...]
    reference: Load
    groups: Groups
    frame: Frame
    noises: tuple[NoiseOfMeans, ...]
    noise_of_means: NoiseOfMeans
    run: Run | None
    odds: Odds

    @property
    def noise(self) -> Noise:
        """The noise of the readings that is taken."""
        return self.noise_of_means.noise

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the state parameters."""
        return self.twin.parameters

    @property
    def units(self) -> tuple[str, ...]:
        """(n_gauges,) unit of the readings of each of the campaign's gauges."""
        units = units_of(self.twin)
        return tuple(units[k] for k in self.order)

    @property
    def channels(self) -> tuple[str, ...]:
        """(n_gauges,) instrument of the readings of each of the campaign's gauges."""
        return tuple(self.twin.channels[k] for k in self.order)

    @property
    def unit(self) -> str:
        """The unit of what is made of several gauges' readings: theirs where they have one, else `MIXED`."""
        return self.units[0] if len(set(self.units)) == 1 else MIXED

    @property
    def scale(self) -> Floats:
        """(n_gauges,) what readings are divided by where several gauges' are taken together: 1 where they share a unit.

        Otherwise the typical standard deviation of one reading of each unit.
        """
        if self.unit != MIXED:
            return np.ones(len(self.units))
        sd, units = np.sqrt(np.diag(self.noise.covariance)), np.array(self.units)
        return np.array([float(np.median(sd[units == unit])) for unit in self.units])

    @property
    def usual(self) -> Difference:
        """The difference to expect from the twin alone."""
        return usual_difference(self.frame, self.odds.differences, has_course=self.run is not None)

    @property
    def twin(self) -> CachedTwin:
        """The model."""
        return self.frame.twin

    @property
    def open(self) -> Mapping[str, tuple[float, float]]:
        """Constants that no run says, as the frame has them."""
        return self.frame.open

    @property
    def order(self) -> tuple[int, ...]:
        """(n_gauges,) position in the twin's gauges of each of the campaign's."""
        return self.frame.order

    def healthy(self, load: Load) -> Floats:
        """Return what the twin predicts (n_gauges,) of the healthy state at a load, for the campaign's gauges."""
        return self.twin.predict({}, load)[list(self.order)]

    def share_of_reference(self, load: Load) -> float:
        """Return how large a load is beside the reference load: their ratio, of several loads that of their readings.

        The readings' is phi, the projection of the healthy prediction on the one at the reference load.
        """
        if isinstance(load, float) and isinstance(self.reference, float):
            return load / self.reference
        return self.frame.share(self.healthy(load))

    @property
    def last_test(self) -> str:
        """The test that was read last."""
        return max(self.averages, key=lambda one: (one.time, one.number)).test

    def effects(self) -> list[tuple[Effect, tuple[str, ...]]]:
        """Return every effect with its places, in the order of `candidates`."""
        grouped = [list(group) for _, group in groupby(self.candidates, key=lambda candidate: candidate.name)]
        return [(group[0].effect, tuple(candidate.place for candidate in group)) for group in grouped]

    def named(self, state: Floats) -> dict[str, float]:
        """Return a state (n_parameters,) as a mapping."""
        return dict(zip(self.names, state.tolist(), strict=True))


def prepare(
    campaign: Campaign,
    twin: Twin,
    effects: Mapping[str, Effect],
    commissioning: Campaign | None = None,
    noise_sd: float | Mapping[str, float] | None = None,
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
    campaign = replace(campaign, units=tuple(units_of(asked)[asked.gauges.index(name)] for name in campaign.gauges))
    _refuse_other_loads(campaign, commissioning, asked)
    checks = checked(campaign, asked)
    campaign = checks.campaign
    run = calm(commissioning, asked) if commissioning is not None else None
    noise, of_noise = noise_of(checks, run, noise_sd)
    _refuse_unsought(campaign, asked)
    reference = _reference(campaign, run, asked)
    _refuse_nothing_predicted(campaign, asked, reference)
    frame = Frame.of(asked, campaign.gauges, reference, [*campaign.loads, *(run.loads if run is not None else ())])
    known, of_run = (None, [WITHOUT_RUN]) if run is None else _read(run, frame, noise)
    candidates = candidates_of(effects, asked, campaign.gauges, odds)
    averages = campaign.averages(any(getattr(effect, "uses_time", False) for effect in effects.values()))
    noises = NoiseOfMeans.every(noise, averages)
    inputs = Inputs(
        campaign=campaign,
        noises=noises,
        noise_of_means=noises[0],
        difference=usual_difference(frame, odds.differences),
        candidates=candidates,
        priors=priors_of(candidates),
        averages=averages,
        reference=reference,
        groups=_open_groups(campaign),
        frame=frame,
        run=known,
        odds=odds,
    )
    inputs = relearnt(inputs, known) if known is not None else inputs
    return inputs, [*checks.notes, *of_noise, *of_run, *_of_difference(inputs)]


def relearnt(inputs: Inputs, run: Run) -> Inputs:
    """Return the inputs beside a run, the difference with what that alone says of it."""
    rows, residual = run.rows, run.rows.residual
    usual = inputs.usual
    best = max(run.noises, key=lambda one: one.log_share + log_at_levels(usual, rows, residual, one.covariance))
    noise = best.covariance
    run = replace(run, noise=noise)
    wander = wander_of(usual, rows, residual, noise)
    found = learnt(replace(usual, wander=wander), rows, residual, noise)
    return replace(inputs, run=run, difference=found)


def levels_without_run(inputs: Inputs) -> Mapping[float, float]:
    """Return the levels of the difference, with their probabilities, where no run measures it."""
    return OF_MODELS if inputs.odds.differences == Differences() and not inputs.open else STATED


def _of_difference(inputs: Inputs) -> list[str]:
    """Return notes on what a run says of the difference."""
    poor = poor_readings(inputs.difference, inputs.campaign.gauges)
    notes = []
    if poor:
        named = ", ".join(poor[:NAMED]) + (f" and {len(poor) - NAMED} more" if len(poor) > NAMED else "")
        notes.append(
            f"The twin is poor at {named}: the difference there is several times the usual one. It is learnt from the "
            "commissioning run and used."
        )
    if inputs.difference.wander.any():
        notes.append(
            "The tests of the commissioning run differ by more than their repeats: the campaign's are taken to differ "
            "by as much."
        )
    return notes


def _read(run: Campaign, frame: Frame, noise: Noise) -> tuple[Run, list[str]]:
    """Return a commissioning run as rows, and notes on its noise.

    Raises
    ------
    DataError
        it lacks a gauge of the campaign, or holds an unknown state.
    """
    unknown = [cell for cell in run.cells if not cell.is_known]
    if unknown:
        raise DataError(f"the commissioning run holds an unknown state ({unknown[0].name}); give its state columns")
    of_run, notes = noise_of_run(run, noise)
    columns = [run.gauges.index(name) for name in noise.gauges]
    averages = tuple(cell.of_gauges(columns) for cell in run.cells)
    parameters = [run.parameters.index(name) for name in frame.twin.parameters]
    states = np.array([cell.state for cell in run.cells])[:, parameters]
    noises = NoiseOfMeans.every(of_run, averages)
    return Run(run, averages, frame.rows(averages, states, FIRST_OF_RUN), noises, noises[0].covariance), notes


WITHOUT_RUN = (
    "No commissioning run: twin and asset may differ by 2 % and more in common and per gauge before any effect; "
    "effects that scale all readings by less than some 10 % are invisible."
)


def _refuse_unsought(campaign: Campaign, twin: CachedTwin) -> None:
    """Refuse an unknown state where the twin has no range in which to look for it."""
    for cell in campaign.cells:
        for name, value in zip(campaign.parameters, cell.state.tolist(), strict=True):
            if np.isnan(value) and not twin.state_limits.get(name, 1.0) > 0.0:
                raise DataError(
                    f"{cell.name}: state {name} is unknown, and the twin gives no range in which to look for it; "
                    "expected a value; give it in the campaign, or the greatest one as state_limits in the twin's card"
                )


def _refuse_other_loads(campaign: Campaign, run: Campaign | None, twin: CachedTwin) -> None:
    """Refuse a campaign or a run whose loads are not the twin's."""
    for name, one in (("campaign", campaign), ("commissioning run", run)):
        if one is not None and one.load_names != twin.loads:
            raise DataError(
                f"the {name} has the loads {list(one.load_names)} but the twin {list(twin.loads)}; expected the same "
                "names in the same order; give them as load_names"
            )


def _refuse_nothing_predicted(campaign: Campaign, twin: CachedTwin, load: Load) -> None:
    """Refuse a twin without a healthy reading: differences between twin and asset are measured by their size."""
    if not any(twin.predict({}, load)[twin.gauges.index(name)] for name in campaign.gauges):
        raise TwinError(
            f"{twin.name} answers 0 for each of {len(campaign.gauges)} readings of the healthy state at the greatest "
            f"load ({load_words(twin.loads, load) or 'none is applied'}); expected readings that are not all 0; "
            "correct it, or let it answer the readings themselves and not their changes"
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


def _open_groups(campaign: Campaign) -> Groups:
    """Return the cells that share an unknown state: those of one test."""
    by_test: dict[str, list[int]] = {}
    for k, cell in enumerate(campaign.cells):
        if not cell.is_known:
            by_test.setdefault(cell.test, []).append(k)
    return tuple(tuple(cells) for cells in by_test.values())
