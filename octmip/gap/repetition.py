"""Diagnosis in rounds: what was found is taken off the readings, and what is left is diagnosed again."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.diagnosis import Diagnosis, diagnose
from octmip.gap.twins.augmented import AugmentedTwin
from octmip.trees.tree import Node
from octmip.twin import Effect, Twin


def rounds(
    campaign: Campaign,
    twin: Twin,
    commissioning: Campaign | None = None,
    most: int = 4,
    effects: Mapping[str, Effect] | None = None,
    tree: Node | None = None,
    feature_names: Sequence[str] = (),
    noise_sd: float | Mapping[str, float] | None = None,
) -> list[Diagnosis]:
    """Diagnose, add what was found, diagnose again; stop when nothing more is found or the gap stops closing.

    What the effects found change is taken off the readings, so the commissioning run, which is of the sound asset,
    serves every round. The other arguments are those of `diagnose`.
    """
    found: list[Diagnosis] = []
    left = campaign
    for _ in range(most):
        found.append(diagnose(left, twin, effects, commissioning, tree, feature_names, noise_sd))
        last = found[-1]
        if last.is_sound or last.shrinkage is None or not last.shrinkage.closed > 0.05:
            break
        left = _without_found(left, last, twin)
    return found


def _without_found(campaign: Campaign, diagnosis: Diagnosis, twin: Twin) -> Campaign:
    """Return the campaign less what the effects of the first cause change in it, states as they were estimated."""
    inputs, augmented = diagnosis.posterior.model.inputs, diagnosis.augmented(twin)
    plain = AugmentedTwin(twin, (), augmented.calibration, augmented.calibration_load)
    states = diagnosis.which[0].judged.model.states
    columns = [twin.gauges.index(name) for name in campaign.gauges]
    readings = campaign.readings.copy()
    for cell, state in zip(inputs.campaign.cells, states, strict=True):
        named = inputs.named(state)
        change = augmented.predict(named, cell.load, cell.time) - plain.predict(named, cell.load, cell.time)
        readings[cell.rows] -= change[columns]
    return replace(campaign, readings=readings)
