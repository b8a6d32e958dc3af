"""What the plain selector says of a case, in the form in which a diagnosis is scored."""

import time
from collections.abc import Sequence

from benchmarks.blind.answers import HELD_LOAD, MOST_PROBABLE, CauseRecord, Found, Task
from benchmarks.plain.selector import PlainCause, select
from octmip.gap import Addition, AugmentedTwin, Campaign
from octmip.gap.effects import in_chain
from octmip.gap.twins import CachedTwin


def plain(task: Task, model: CachedTwin, campaign: Campaign, run: Campaign | None) -> Found:
    """Return the plain selector's answer to a case, with the commissioning run or without."""
    start = time.process_time()
    selection = select(campaign, model, run)
    seconds = time.process_time() - start
    state = dict.fromkeys(model.parameters, 0.0)
    augmented = AugmentedTwin(model, _additions(selection.causes[0]))
    end = max(cell.time for cell in campaign.cells)
    moved = augmented.predict(state, HELD_LOAD, end) - model.predict(state, HELD_LOAD)
    return {
        "name": task.name,
        "calibrated": run is not None,
        "seconds": seconds,
        "which": [_record(cause) for cause in selection.causes[:MOST_PROBABLE]],
        "credible": [_names(cause) for cause in selection.credible],
        "names": [_names(cause) for cause in selection.causes[:MOST_PROBABLE]],
        "unknown_probability": selection.unknown_probability,
        "inclusion": {},
        "findings": [],
        "doubts": [],
        "stuck": [],
        "significant": [],
        "correction": moved[[model.gauges.index(name) for name in campaign.gauges]].tolist(),
    }


def _additions(cause: PlainCause) -> tuple[Addition, ...]:
    parts = zip(cause.members, cause.sizes[:, 0].tolist(), strict=True)
    found = [Addition(effect, place, size) for (effect, place), size in parts]
    return tuple(sorted(found, key=lambda addition: in_chain(addition.effect)))  # the structure first, the chain last


def _names(cause: PlainCause) -> list[list[str]]:
    return [["unknown"]] if cause.is_unknown else [sorted(names) for names in cause.names]


def _record(cause: PlainCause) -> CauseRecord:
    effects: Sequence[str] = ["unknown"] if cause.is_unknown else [effect.name for effect, _ in cause.members]
    sizes = zip(cause.members, cause.sizes.tolist(), strict=True)
    return {
        "effects": list(effects),
        "probability": cause.probability,
        "parameters": [
            {"effect": effect.name, "place": place, "size": size, "low": low, "high": high}
            for (effect, place), (size, low, high) in sizes
        ],
    }
