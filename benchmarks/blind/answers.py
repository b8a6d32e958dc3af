"""Diagnose sealed cases: reads campaigns and the commissioning run, and nothing else."""

import json
import time
from pathlib import Path

import numpy as np

from femlib.wing import WingTwin, uav_wing
from femlib.wing.effects import wing_effects
from octmip.gap import diagnose, read_campaign
from octmip.gap.memory import Memory
from octmip.gap.words import as_object

HELD_LOAD = 2.5
_twins: dict = {}


def twin(refinement=1.0):
    """Return this process's twin, made once; its memory serves all cases."""
    if refinement not in _twins:
        wing = uav_wing(refinement=refinement)
        _twins[refinement] = Memory(WingTwin(wing, wing_effects(wing)))
    return _twins[refinement]


def answer(folder: Path, name: str, is_calibrated: bool, refinement: float):
    """Diagnose one campaign and return what the scorer may see."""
    model = twin(refinement)
    campaign = read_campaign(folder / "campaigns" / f"{name}.csv", model)
    run = read_campaign(folder / "commissioning.csv", model) if is_calibrated else None
    start = time.process_time()
    diagnosis = diagnose(campaign, model, commissioning=run)
    seconds = time.process_time() - start
    found = as_object(diagnosis)
    return {
        "name": name,
        "calibrated": is_calibrated,
        "seconds": seconds,
        "which": found["which"],
        "credible": [[sorted(names) for names in cause.names] for cause in diagnosis.credible],
        "names": [[sorted(names) for names in cause.names] for cause in diagnosis.which],
        "unknown_probability": found["unknown_probability"],
        "inclusion": found["inclusion"],
        "findings": found["noise"]["findings"],
        "significant": [entry["name"] for entry in found["where"]["entries"]],
        "entries": [entry.name for entry in diagnosis.where.entries],
        "correction": _correction(diagnosis, model),
        "ranking": _chi_squared_ranking(diagnosis),
        "residual": _features(diagnosis),
        "lasso": None,
    }


def _correction(diagnosis, model):
    """Return what the first cause adds at the held load in the first test's state (n_gauges,)."""
    setting = diagnosis.posterior.scene.setting
    scene = diagnosis.which[0].judged.scene
    state = dict(zip(setting.names, scene.states[0].tolist(), strict=True))
    augmented = diagnosis.augmented(model)
    plain = type(augmented)(model, (), augmented.calibration, augmented.calibration_load)
    end = max(block.time for block in setting.blocks)
    moved = augmented.predict(state, HELD_LOAD, end) - plain.predict(state, HELD_LOAD)
    return moved[list(setting.order)].tolist()


def _chi_squared_ranking(diagnosis):
    """Return the effect whose best column leaves the least chi-squared: no prior, no look-elsewhere correction."""
    scene = diagnosis.posterior.scene
    prior = scene.setting.priors
    gain = np.where(
        prior.is_fact, 2 * scene.pull - np.diag(scene.gram), scene.pull**2 / np.maximum(np.diag(scene.gram), 1e-12)
    )
    return scene.setting.columns[int(np.argmax(gain))].name


def _features(diagnosis):
    """Return whitened residuals at no load and their slope with the load, for the classifier baseline."""
    scene = diagnosis.posterior.scene
    loads = np.array([scene.setting.cell_of(b).load_factor for b in scene.setting.blocks])[scene.block]
    z = scene.residual / np.sqrt(np.diag(scene.covariance))
    n = len(scene.setting.order)
    at_rest = [float(z[(scene.gauge == g) & (loads == 0)].mean()) if (loads == 0).any() else 0.0 for g in range(n)]
    loaded = [float(z[(scene.gauge == g) & (loads > 0)].mean()) if (loads > 0).any() else 0.0 for g in range(n)]
    return [*at_rest, *loaded]


def group_lasso(folder: Path, name: str, refinement: float):
    """Return the effect that a group lasso keeps longest (cvxpy, columns in units of the prior sd), or "" for none."""
    import cvxpy as cp

    model = twin(refinement)
    campaign = read_campaign(folder / "campaigns" / f"{name}.csv", model)
    scene = diagnose(campaign, model, commissioning=read_campaign(folder / "commissioning.csv", model)).posterior.scene
    prior = scene.setting.priors
    columns = scene.white * np.where(prior.is_fact, 1.0, prior.sd)
    names = [c.name for c in scene.setting.columns]
    groups = {n: [k for k, other in enumerate(names) if other == n] for n in dict.fromkeys(names)}
    best = {
        n: float(np.linalg.norm(columns[:, k].T @ scene.white_residual)) / np.sqrt(len(k)) for n, k in groups.items()
    }
    size = cp.Variable(columns.shape[1])
    penalty = sum(np.sqrt(len(k)) * cp.norm(size[k]) for k in groups.values())
    weight = 0.5 * max(best.values())
    cp.Problem(cp.Minimize(0.5 * cp.sum_squares(scene.white_residual - columns @ size) + weight * penalty)).solve(
        solver="CLARABEL"
    )
    norms = {n: float(np.linalg.norm(size.value[k])) for n, k in groups.items()}
    return max(norms, key=lambda n: norms[n]) if max(norms.values()) > 1e-4 else ""


def write(path: Path, found):
    """Write diagnoses as one JSON line each."""
    path.write_text("".join(json.dumps(line) + "\n" for line in found))
