"""The diagnosis as one JSON object for machines: the keys are stable, numbers that do not exist are null.

Numbers in the readings' unit stand beside their "unit"; keys that end in _microstrain are null where it is another.
"""

import math
from typing import Any

from octmip.gap.causes import Cause, ConfoundedEffects
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.location import Place, Where
from octmip.gap.next_test import Proposal
from octmip.gap.shrinkage import Shrinkage
from octmip.gap.sizes import Parameter
from octmip.interfaces.report.diagnosis.measured import noise_sds
from octmip.interfaces.report.diagnosis.recommendation import recommend, verdict_of
from octmip.twin import MICROSTRAIN, MIXED


def as_object(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the diagnosis as one JSON object."""
    inputs = diagnosis.posterior.model.inputs
    content = {
        "verdict": recommend(diagnosis),
        "kind": str(verdict_of(diagnosis)),
        "certainty": str(diagnosis.which[0].certainty),
        "is_sound": diagnosis.is_sound,
        "where": _where(diagnosis.where),
        "which": [_cause(cause) for cause in diagnosis.which],
        "credible_set": [list(cause.effects) for cause in diagnosis.credible],
        "inclusion": diagnosis.inclusion,
        "ambiguity": [_confounded(found) for found in diagnosis.ambiguity],
        "parameters": [_parameter(p) for p in diagnosis.which[0].parameters],
        "unknown_probability": diagnosis.unknown_probability,
        "detectable": diagnosis.detectable,
        "refused": diagnosis.refused,
        "noise": _noise(diagnosis),
        "units": dict(zip(inputs.campaign.gauges, inputs.units, strict=True)),
        "shrinkage": None if diagnosis.shrinkage is None else _shrinkage(diagnosis.shrinkage),
        "next_test": [_proposal(p) for p in diagnosis.next_test],
        "states": [{"tests": list(e.tests), "mean": e.mean, "sd": e.sd} for e in diagnosis.states],
        "notes": list(diagnosis.notes),
        "doubts": list(diagnosis.doubts),
        "nothing_acts": diagnosis.nothing_acts,
    }
    finite: dict[str, Any] = _finite(content)
    return finite


def _where(where: Where) -> dict[str, Any]:
    return {
        "rms": where.rms,
        "unit": where.unit,
        "rms_microstrain": _strain(where.rms, where.unit),
        "p_value": where.p_value,
        "entries": [_place(p) for p in where.entries if p.is_significant],
        "gauges": [_place(p) for p in where.gauges],
        "loads": [_place(p) for p in where.loads],
        "tests": [_place(p) for p in where.tests],
        "nodes": [
            {"path": f.path, "split": f.words, "simulated": f.simulated, "real": f.real, "share": f.share}
            for f in where.nodes
        ],
    }


def _place(p: Place) -> dict[str, Any]:
    return {
        "name": p.name,
        "z": p.z,
        "p_value": p.p_value,
        "is_significant": p.is_significant,
        "share": p.share,
        "gap": p.gap,
        "unit": p.unit,
        "gap_microstrain": _strain(p.gap, p.unit),
    }


def _cause(cause: Cause) -> dict[str, Any]:
    return {
        "effects": list(cause.effects),
        "probability": cause.probability,
        "certainty": str(cause.certainty),
        "parameters": [_parameter(p) for p in cause.parameters],
        "cannot_be_told_from": [list(c.effects[1:]) for c in cause.confounded],
        "is_prior_sensitive": cause.is_prior_sensitive,
    }


def _parameter(p: Parameter) -> dict[str, Any]:
    return {
        "effect": p.effect,
        "place": p.place,
        "size": p.size,
        "low": p.low,
        "high": p.high,
        "unit": p.unit,
        "words": p.words,
        "name": p.named.name,
    }


def _confounded(found: ConfoundedEffects) -> dict[str, Any]:
    return {
        "effects": list(found.effects),
        "places": list(found.places),
        "d_prime": list(found.d_prime),
        "shares": list(found.shares),
        "names": list(found.words),
        "reason": found.reason,
        "separated_by": list(found.separated_by),
    }


def _noise(diagnosis: Diagnosis) -> dict[str, Any]:
    noise, sds = diagnosis.noise, noise_sds(diagnosis)
    unit = next(iter(sds)) if len(sds) == 1 else MIXED
    return {
        "sd": sds,
        "sd_microstrain": sds.get(MICROSTRAIN),
        "variance": sds[MICROSTRAIN] ** 2 if MICROSTRAIN in sds else None,
        "lag1": noise.lag1,
        "inflation": noise.inflation,
        "kurtosis": noise.kurtosis,
        "step": noise.step,
        "step_microstrain": _strain(noise.step, unit),
        "variance_ratio_by_load": {f"{load:g}": ratio for load, ratio in noise.scale.items()},
        "stuck": list(noise.stuck),
        "clipped": dict(noise.clipped),
        "findings": list(noise.findings),
    }


def _shrinkage(s: Shrinkage) -> dict[str, Any]:
    return {
        "before": s.before,
        "after": s.after,
        "floor": s.floor,
        "unit": s.unit,
        "before_microstrain": _strain(s.before, s.unit),
        "after_microstrain": _strain(s.after, s.unit),
        "floor_microstrain": _strain(s.floor, s.unit),
        "closed": s.closed,
        "low": s.low,
        "high": s.high,
        "chi2_before": s.chi2_before,
        "chi2_after": s.chi2_after,
        "p_after": s.p_after,
        "held_out": [{"name": h.name, "before": h.before, "after": h.after, "closed": h.closed} for h in s.held_out],
    }


def _proposal(p: Proposal) -> dict[str, Any]:
    return {
        "name": p.name,
        "words": p.words,
        "information_nats": p.information,
        "cost": p.cost,
        "is_strain_test": p.is_strain_test,
    }


def _strain(value: float, unit: str) -> float | None:
    return value if unit == MICROSTRAIN else None


def _finite(value: Any) -> Any:
    """Return the value with NaN and infinity replaced by None, which JSON can say."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
