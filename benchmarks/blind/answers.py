"""Diagnose sealed cases: reads campaigns and the commissioning run, and nothing else."""

import hashlib
import importlib
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypedDict, cast

import numpy as np

import femlib
import octmip
from femlib.wing import WingTwin, tapered_wing
from femlib.wing.effects import wing_effects
from octmip.gap import AugmentedTwin, Campaign, Diagnosis, Differences, Odds, diagnose
from octmip.gap.diagnosis import library_of
from octmip.gap.twins.cached import CachedTwin
from octmip.interfaces.report.diagnosis.as_json import as_object
from octmip.twin import Effect

HELD_LOAD = 2.5
MOST_PROBABLE = 6
"""Causes that are written down."""
_twins: dict[float, CachedTwin] = {}


@dataclass(frozen=True)
class Constants:
    """Constants of a diagnosis: differences of two models, and the error of the trace of each effect by name."""

    differences: Differences
    trace_errors: Mapping[str, float]


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
    lasso
        whether to ask a group lasso too.
    constants
        of the diagnosis, where they are not its own.
    selector
        what answers it, of `selectors.SELECTORS`.
    """

    place: Path
    name: str
    refinement: float = 1.0
    without: bool = True
    lasso: bool = False
    constants: Constants | None = None
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
    causes of the 95 % set. `ranking`, `residual` and `lasso` are the baselines'.
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
    ranking: str
    residual: list[float]
    lasso: str | None


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
    odds, effects = Odds(), None
    if task.constants is not None:
        odds, errors = Odds(differences=task.constants.differences), task.constants.trace_errors
        effects = {name: with_error(effect, errors.get(name)) for name, effect in library_of(model, campaign).items()}
    diagnosis = diagnose(campaign, model, effects, commissioning=run, odds=odds)
    seconds = time.process_time() - start
    written = as_object(diagnosis)
    is_calibrated = run is not None
    return {
        "name": task.name,
        "calibrated": is_calibrated,
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
        "ranking": _chi_squared_ranking(diagnosis),
        "residual": _features(diagnosis),
        "lasso": group_lasso(diagnosis) if task.lasso and is_calibrated else None,
    }


def with_error(effect: Effect, error: float | None) -> Effect:
    """Return an effect whose trace has another error; itself where none was settled."""
    return effect if error is None else cast(Effect, replace(cast(Any, effect), signature_error=error))


def _correction(diagnosis: Diagnosis, model: CachedTwin) -> list[float]:
    """Return what the first cause adds at the held load in the first test's state (n_gauges,)."""
    inputs = diagnosis.posterior.model.inputs
    state = inputs.named(diagnosis.which[0].judged.model.states[0])
    augmented = diagnosis.augmented(model)
    plain = AugmentedTwin(model, (), augmented.calibration, augmented.calibration_load)
    end = max(average.time for average in inputs.averages)
    moved = augmented.predict(state, HELD_LOAD, end) - plain.predict(state, HELD_LOAD)
    correction: list[float] = moved[list(inputs.order)].tolist()
    return correction


def _chi_squared_ranking(diagnosis: Diagnosis) -> str:
    """Return the effect whose best candidate leaves the least chi-squared: no prior, no look-elsewhere correction."""
    inputs, white = diagnosis.posterior.model.inputs, diagnosis.posterior.model.whitened
    length, projection = np.diag(white.gram), white.projection
    free = projection**2 / np.maximum(length, 1e-12)
    gain = np.where(inputs.priors.is_discrete, 2 * projection - length, free)
    return inputs.candidates[int(np.argmax(gain))].name


def _features(diagnosis: Diagnosis) -> list[float]:
    """Return whitened residuals at no load and their slope with the load, for the classifier baseline."""
    model = diagnosis.posterior.model
    loads = model.load_factors
    z = model.residual / np.sqrt(np.diag(model.covariance))
    n = len(model.inputs.order)
    # A gauge that is left out at a load (clipped, say) has no residual there.
    parts = [z[(model.gauge == g) & at] for at in (loads == 0, loads > 0) for g in range(n)]
    return [float(part.mean()) if len(part) else 0.0 for part in parts]


def group_lasso(diagnosis: Diagnosis) -> str:
    """Return the effect that a group lasso keeps longest (cvxpy, columns in units of the prior sd), or "" for none."""
    cp: Any = importlib.import_module("cvxpy")  # it takes a second, and few cases are asked
    inputs, white = diagnosis.posterior.model.inputs, diagnosis.posterior.model.whitened
    columns = white.signatures * np.where(inputs.priors.is_discrete, 1.0, inputs.priors.sd)
    names = [c.name for c in inputs.candidates]
    groups = {n: [k for k, other in enumerate(names) if other == n] for n in dict.fromkeys(names)}
    best = {n: float(np.linalg.norm(columns[:, k].T @ white.residual)) / np.sqrt(len(k)) for n, k in groups.items()}
    size = cp.Variable(columns.shape[1])
    penalty = sum(np.sqrt(len(k)) * cp.norm(size[k]) for k in groups.values())
    weight = 0.5 * max(best.values())
    cp.Problem(cp.Minimize(0.5 * cp.sum_squares(white.residual - columns @ size) + weight * penalty)).solve(
        solver="CLARABEL"
    )
    norms = {n: float(np.linalg.norm(size.value[k])) for n, k in groups.items()}
    return max(norms, key=lambda n: norms[n]) if max(norms.values()) > 1e-4 else ""
