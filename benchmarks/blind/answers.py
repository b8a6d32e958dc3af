"""Diagnose sealed cases: reads campaigns and the commissioning run, and nothing else."""

import hashlib
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import femlib
import octmip
from femlib.wing import WingTwin, tapered_wing
from femlib.wing.effects import wing_effects
from octmip.gap import AugmentedTwin, Campaign, Diagnosis, diagnose
from octmip.gap.twins import CachedTwin
from octmip.interfaces.report.diagnosis.as_json import as_object

HELD_LOAD = 2.5
MOST_PROBABLE = 6
"""Causes that are written down."""
_twins: dict[float, CachedTwin] = {}


@dataclass(frozen=True)
class Task:
    """One case to diagnose.

    Attributes
    ----------
    place
        folder of its asset, which holds `commissioning.csv`, `campaigns`, and `runs` of cases that have their own.
    name
        of the case.
    refinement
        of the twin's mesh.
    without
        whether to diagnose once more without the commissioning run.
    selector
        what answers it, of `selectors.SELECTORS`.
    """

    place: Path
    name: str
    refinement: float = 1.0
    without: bool = True
    selector: str = "diagnosis"


class ParameterRecord(TypedDict):
    """One effect of a cause, its place, and its size with a 90 % interval."""

    effect: str
    place: str
    size: float
    low: float
    high: float


class CauseRecord(TypedDict):
    """A cause as the diagnosis writes it: names of its effects, probability, sizes."""

    effects: list[str]
    probability: float
    parameters: list[ParameterRecord]


class Found(TypedDict):
    """The diagnosis of one case, with the commissioning run (`calibrated`) or without.

    `names` holds for each cause of `which` the groups of names that cannot be told apart, `credible` the same for the
    causes of the 95 % set.
    """

    name: str
    calibrated: bool
    seconds: float
    which: list[CauseRecord]
    credible: list[list[list[str]]]
    names: list[list[list[str]]]
    unknown_probability: float
    inclusion: dict[str, float]
    findings: list[str]
    doubts: list[str]
    stuck: list[str]
    significant: list[str]
    correction: list[float]


def twin(refinement: float = 1.0) -> CachedTwin:
    """Return this process's twin, made once; what it has answered serves all cases."""
    if refinement not in _twins:
        wing = tapered_wing(refinement=refinement)
        _twins[refinement] = CachedTwin(WingTwin(wing, wing_effects(wing)))
    return _twins[refinement]


def code() -> str:
    """Return the SHA-256 (12 digits) of the code that diagnoses: octmip.gap and femlib."""
    folders = (Path(octmip.__file__).parent / "gap", Path(femlib.__file__).parent)
    files = sorted(path for folder in folders for path in folder.rglob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:12]


def diagnosed(task: Task, model: CachedTwin, campaign: Campaign, run: Campaign | None) -> Found:
    """Return the diagnosis of a case, with the commissioning run or without."""
    start = time.process_time()
    diagnosis = diagnose(campaign, model, commissioning=run)
    seconds = time.process_time() - start
    written = as_object(diagnosis)
    return {
        "name": task.name,
        "calibrated": run is not None,
        "seconds": seconds,
        "which": written["which"][:MOST_PROBABLE],
        "credible": [[sorted(names) for names in cause.names] for cause in diagnosis.credible],
        "names": [[sorted(names) for names in cause.names] for cause in diagnosis.which][:MOST_PROBABLE],
        "unknown_probability": written["unknown_probability"],
        "inclusion": written["inclusion"],
        "findings": written["noise"]["findings"],
        "doubts": list(getattr(diagnosis, "doubts", ())),
        "stuck": written["noise"]["stuck"],
        "significant": [entry["name"] for entry in written["where"]["entries"]],
        "correction": _correction(diagnosis, model),
    }


def _correction(diagnosis: Diagnosis, model: CachedTwin) -> list[float]:
    """Return what the first cause adds at the held load in the first test's state (n_gauges,)."""
    inputs = diagnosis.posterior.model.inputs
    state = inputs.named(diagnosis.which[0].judged.model.states[0])
    augmented = diagnosis.augmented(model)
    plain = AugmentedTwin(model, (), augmented.difference)
    end = max(average.time for average in inputs.averages)
    moved = augmented.predict(state, HELD_LOAD, end) - plain.predict(state, HELD_LOAD)
    correction: list[float] = moved[list(inputs.order)].tolist()
    return correction
