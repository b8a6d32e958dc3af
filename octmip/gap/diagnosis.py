"""Diagnose: campaign and twin in; where, which, how far, and what to test next out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.clipping import unclipped
from octmip.gap.campaign.noise import Noise, estimate_noise, given_noise
from octmip.gap.causes import UNKNOWN, Cause, Tie, cleared, credible_set, tell_causes, with_misfit
from octmip.gap.effects import CHAIN
from octmip.gap.inference.candidates import library_columns, priors
from octmip.gap.inference.confounding import ABSURD, detectable
from octmip.gap.inference.discrepancy import Discrepancy, calibrated, uncalibrated
from octmip.gap.inference.linear_model import Scene, Setting, blocks_of
from octmip.gap.inference.posterior import Posterior, attribute
from octmip.gap.inference.states import joint_covariance, state_posterior
from octmip.gap.location import Where, localise
from octmip.gap.next_test import Proposal, next_tests
from octmip.gap.shrinkage import Shrinkage, measure_shrinkage
from octmip.gap.tree_nodes import flips
from octmip.gap.twins.augmented import Addition, AugmentedTwin
from octmip.gap.twins.cached import Memory
from octmip.tree import Node
from octmip.twin import Effect, Twin

CORRELATED = 0.9
"""Posterior correlation of a damage and an effect beyond which they are not told apart."""
SOUND = 0.5
"""The asset is called sound when no effect is more probable than all others together."""
TRACELESS = 1e6
"""Detectable size over the prior's sd beyond which the signature is nothing but zero."""


@dataclass(frozen=True, slots=True)
class StateEstimate:
    """An unknown damage state as the most probable cause leaves it.

    Attributes:
        tests: tests that share it.
        mean, sd: by parameter, fractions.
    """

    tests: tuple[str, ...]
    mean: dict[str, float]
    sd: dict[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """What the campaign says about the twin.

    Attributes:
        where: the gap by gauge, load, test and tree node.
        which: causes, most probable first.
        shrinkage: how far the first cause of the library closes the gap (None when it names no effect).
        next_test: tests worth running, best value first; empty when little doubt is left.
        noise: what the repeats say.
        inclusion: probability of every effect to be among the causes.
        unknown_probability: probability that something outside the library acts.
        detectable: size of every effect that would have been seen with 95 % power, in its unit.
        refused: effects of which these readings say nothing, with the reason.
        states: unknown states under the first cause.
        notes: what the reader should know about the data.
        posterior: all hypotheses.
    """

    where: Where
    which: tuple[Cause, ...]
    shrinkage: Shrinkage | None
    next_test: tuple[Proposal, ...]
    noise: Noise
    inclusion: dict[str, float]
    unknown_probability: float
    detectable: dict[str, float]
    refused: dict[str, str]
    states: tuple[StateEstimate, ...]
    notes: tuple[str, ...]
    posterior: Posterior

    @property
    def ambiguity(self) -> tuple[Tie, ...]:
        """Effects of the first cause that these readings cannot tell from others."""
        return self.which[0].ties if self.which else ()

    @property
    def is_sound(self) -> bool:
        """Whether no effect and nothing unknown is needed to explain the readings."""
        return bool(self.which) and not self.which[0].effects

    @property
    def credible(self) -> tuple[Cause, ...]:
        """The fewest causes that hold 95 % of the probability."""
        return credible_set(self.which)

    def augmented(self, twin: Twin) -> AugmentedTwin:
        """Return the twin with the effects of the first cause and the calibration added."""
        setting = self.posterior.scene.setting
        parts = self.which[0].parameters if self.which else ()
        by_name = {column.name: column.effect for column in setting.columns}
        additions = tuple(Addition(by_name[p.effect], p.variant, p.size) for p in parts)
        additions = tuple(
            sorted(additions, key=lambda a: a.effect.name in CHAIN)
        )  # the structure first, the chain last
        calibration = np.zeros(len(twin.gauges))
        calibration[list(setting.order)] = setting.discrepancy.mean
        return AugmentedTwin(twin, additions, calibration, setting.reference)


def diagnose(
    campaign: Campaign,
    twin: Twin,
    effects: Mapping[str, Effect] | None = None,
    commissioning: Campaign | Discrepancy | None = None,
    tree: Node | None = None,
    feature_names: Sequence[str] = (),
    noise_sd: float | Mapping[str, float] | None = None,
) -> Diagnosis:
    """Return where campaign and twin differ, which effects explain it, how far the gap closes, and what to test next.

    Args:
        campaign: readings of the asset.
        twin: the model, with the structure's effects in `twin.effects`.
        effects: the library; None: the measuring chain's effects and the twin's own.
        commissioning: readings of the same asset while it was known to be sound; calibrates the twin gauge by gauge. Or
            the discrepancy that an earlier calibration left.
        tree: a deployed tree, to rank its nodes by flipped decisions.
        feature_names: the tree's features, names of gauges.
        noise_sd: standard deviation of one reading [microstrain], of all gauges or by gauge, from the instrument's
            card; used where no load was read often enough to tell the noise.

    Raises:
        DataError: nothing to compare (no repeats at all, a gauge that the twin does not know, a commissioning run that
            lacks a gauge or a known state).
    """
    with threadpool_limits(1):  # the matrices are small: threads cost more than they save
        return _diagnose(campaign, twin, effects, commissioning, tree, feature_names, noise_sd)


def _diagnose(
    campaign: Campaign,
    twin: Twin,
    effects: Mapping[str, Effect] | None,
    commissioning: Campaign | Discrepancy | None,
    tree: Node | None,
    feature_names: Sequence[str],
    noise_sd: float | Mapping[str, float] | None,
) -> Diagnosis:
    chosen = {**CHAIN, **_structural(twin)} if effects is None else dict(effects)
    setting, notes = prepare(campaign, twin, chosen, commissioning, noise_sd)
    posterior = attribute(setting)
    which = tell_causes(posterior)
    scene = posterior.scene
    library_cause = next((cause for cause in which if UNKNOWN not in cause.effects), None)
    closing = None
    if library_cause is not None and library_cause.effects:
        closing = measure_shrinkage(library_cause.judged.scene, library_cause.judged.members)
    which, strange = with_misfit(which, library_cause, closing, posterior.unknown_probability)
    nodes = flips(scene, tree, feature_names) if tree is not None else ()
    sizes = detectable(scene)
    return Diagnosis(
        where=localise(scene, nodes),
        which=which,
        shrinkage=closing,
        next_test=next_tests(scene, cleared(posterior.judged)),
        noise=setting.noise,
        inclusion=posterior.inclusion(),
        unknown_probability=strange,
        detectable=sizes,
        refused=_refused(which, scene, sizes),
        states=_states(which),
        notes=(*campaign.notes, *notes),
        posterior=posterior,
    )


def prepare(
    campaign: Campaign,
    twin: Twin,
    effects: Mapping[str, Effect],
    commissioning: Campaign | Discrepancy | None = None,
    noise_sd: float | Mapping[str, float] | None = None,
) -> tuple[Setting, list[str]]:
    """Return the campaign laid out against the twin, and notes for the reader."""
    unknown = [name for name in campaign.gauges if name not in twin.gauges]
    if unknown:
        raise DataError(f"column {unknown[0]!r} is no gauge of the twin; expected among {list(twin.gauges[:3])}...")
    memory = twin if isinstance(twin, Memory) else Memory(twin)
    campaign, rails, notes = unclipped(campaign)
    run = unclipped(commissioning)[0] if isinstance(commissioning, Campaign) else None
    noise, of_noise = _noise(campaign, run, noise_sd)
    notes += of_noise
    if rails:
        noise = replace(noise, clipped=rails, findings=(*noise.findings, "clipping"))
    if noise.stuck:
        notes.append(f"Readings of {', '.join(noise.stuck)} never change between repeats: a stuck channel.")
    order = tuple(twin.gauges.index(name) for name in campaign.gauges)
    reference = _reference(campaign, run)
    healthy = memory.predict({}, reference)[list(order)]
    if isinstance(commissioning, Discrepancy):
        discrepancy = commissioning
    elif run is not None:
        discrepancy = calibrated(run, memory, campaign.gauges, reference)
    else:
        discrepancy = uncalibrated(healthy)
        notes.append(
            "No commissioning run: twin and asset may differ by about 1 % in common and 1 % a gauge before any effect; "
            "effects that scale all strains by less than about 1.5 % are invisible."
        )
    columns = library_columns(effects, memory, campaign.gauges)
    groups, about = _open_groups(campaign)
    split = any(getattr(effect, "uses_time", False) for effect in effects.values())
    blocks = blocks_of(campaign, split)
    setting = Setting(campaign, memory, noise, discrepancy, columns, blocks, order, reference, groups, priors(columns))
    return setting, notes + about


def _noise(
    campaign: Campaign, run: Campaign | None, noise_sd: float | Mapping[str, float] | None
) -> tuple[Noise, list[str]]:
    """Return the noise and where it is from: the repeats, else the commissioning run's, else what is given."""
    given = None if noise_sd is None else given_noise(campaign.gauges, noise_sd)
    if campaign.has_repeats:
        unused = "The noise is estimated from the repeats; the given standard deviation is not used."
        return estimate_noise(campaign, run), [] if given is None else [unused]
    few = "Every test holds too few repeats to tell the noise; "
    if given is not None:
        return given, [few + "the given standard deviation is taken as known."]
    return estimate_noise(campaign, run).of_gauges(campaign.gauges), [few + "the commissioning run's noise is used."]


def _structural(twin: Twin) -> dict[str, Effect]:
    return dict(getattr(twin, "effects", {}))


def _reference(campaign: Campaign, commissioning: Campaign | None) -> float:
    loads = [*campaign.loads, *(commissioning.loads if commissioning is not None else ())]
    greatest = max(loads, key=abs)
    return greatest if greatest != 0.0 else 1.0


def _open_groups(campaign: Campaign) -> tuple[tuple[tuple[int, ...], ...], list[str]]:
    """Return the cells that share an unknown state.

    Rows of one test share their state. Tests that were read at one load each, all loads different, are one state
    carried through the loads, as in a commissioning run.
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


def _states(which: Sequence[Cause]) -> tuple[StateEstimate, ...]:
    if not which:
        return ()
    scene = which[0].judged.allowed
    setting = scene.setting
    if not setting.groups:
        return ()
    mean, covariance = state_posterior(scene, which[0].judged.fit)
    sd = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    n = len(setting.names)
    found = []
    for k, group in enumerate(setting.groups):
        part = slice(k * n, (k + 1) * n)
        tests = tuple(dict.fromkeys(setting.campaign.cells[c].test for c in group))
        low = np.clip(mean[part], 0.0, 1.0).tolist()
        found.append(
            StateEstimate(
                tests,
                dict(zip(setting.names, low, strict=True)),
                dict(zip(setting.names, sd[part].tolist(), strict=True)),
            )
        )
    return tuple(found)


def _refused(which: Sequence[Cause], scene: Scene, sizes: Mapping[str, float]) -> dict[str, str]:
    """Return the effects about which the readings are silent: hidden behind damage, or far below what could be seen."""
    refused = {}
    priors = {column.name: column.effect for column in scene.setting.columns}
    baseline = "a healthy commissioning run at load factors 0, 1, 2 and 3 would separate them"
    for name, size in sizes.items():
        effect = priors[name]
        if size > TRACELESS * effect.prior_sd:
            refused[name] = f"leaves no trace in any gauge: {effect.separated_by}"
        elif size > ABSURD * effect.prior_sd and effect.prior_mean == 0.0:
            hidden = "hidden behind the unknown damage" if scene.setting.groups else "too weak in these readings"
            hint = f"; {baseline}" if scene.setting.groups else ""
            refused[name] = f"{hidden}: only more than {size:.3g} {effect.unit} would have been seen{hint}"
    for cause in which[:1]:
        own = cause.judged.fit
        if not scene.setting.groups or not own.members:
            continue
        joint = joint_covariance(cause.judged.allowed, own)
        n_open = len(joint) - len(own.members)
        sd = np.sqrt(np.maximum(np.diag(joint), 1e-300))
        correlation = np.abs(joint / np.outer(sd, sd))[n_open:, :n_open]
        for j, row in zip(own.members, correlation, strict=True):
            if row.max(initial=0.0) > CORRELATED:
                name = scene.setting.columns[j].name
                refused[name] = f"correlated {row.max():.2f} with an unknown damage: {baseline}"
    return refused


def rounds(
    campaign: Campaign, twin: Twin, commissioning: Campaign | None = None, most: int = 4, **settings: Any
) -> list[Diagnosis]:
    """Diagnose, add what was found, diagnose again; stop when nothing more is found or the gap stops closing.

    The commissioning run calibrates the first round; the augmented twin carries the calibration on, and later rounds
    know only how uncertain it is. An effect that depends on time ends the loop: a twin predicts states, not moments.
    """
    found: list[Diagnosis] = []
    current: Twin = twin
    known: Campaign | Discrepancy | None = commissioning
    for _ in range(most):
        found.append(diagnose(campaign, current, commissioning=known, **settings))
        last = found[-1]
        closing = last.shrinkage
        if last.is_sound or closing is None or not closing.closed > 0.05:
            break
        augmented = last.augmented(current)
        if any(getattr(addition.effect, "uses_time", False) for addition in augmented.additions):
            break
        discrepancy = last.posterior.scene.setting.discrepancy
        known = replace(discrepancy, mean=np.zeros_like(discrepancy.mean))
        current = augmented
    return found
