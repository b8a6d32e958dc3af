"""The diagnosis as one JSON object for machines: the keys are stable, numbers that do not exist are null.

Numbers in the readings' unit stand beside their "unit"; keys that end in _microstrain are null where it is another.
"""

import math
from collections.abc import Mapping
from typing import Any

from octmip.gap.causes import Cause
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.location import Place, Where
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
        "ambiguity": [_taken(c, CONFOUNDED, names=c.words) for c in diagnosis.ambiguity],
        "parameters": [_parameter(p) for p in diagnosis.which[0].parameters],
        "unknown_probability": diagnosis.unknown_probability,
        "detectable": diagnosis.detectable,
        "refused": diagnosis.refused,
        "ties": [list(group) for group in diagnosis.ties],
        "noise": _noise(diagnosis),
        "units": dict(zip(inputs.campaign.gauges, inputs.units, strict=True)),
        "shrinkage": None if diagnosis.shrinkage is None else _shrinkage(diagnosis.shrinkage),
        "next_test": [_taken(p, PROPOSAL, information_nats=p.information) for p in diagnosis.next_test],
        "states": [{"tests": list(e.tests), "mean": e.mean, "sd": e.sd} for e in diagnosis.states],
        "constants": [_taken(one, CONSTANT, interval=list(one.interval)) for one in diagnosis.constants],
        "notes": list(diagnosis.notes),
        "doubts": list(diagnosis.doubts),
        "nothing_acts": diagnosis.nothing_acts,
    }
    finite: dict[str, Any] = _finite(content)
    return finite


PLACE = ("name", "z", "p_value", "is_significant", "share", "gap", "unit")
PARAMETER = ("effect", "place", "size", "low", "high", "unit", "words")
CONFOUNDED = ("effects", "places", "d_prime", "shares", "reason", "separated_by")
CLOSING = ("before", "after", "floor", "unit", "closed", "low", "high", "chi2_before", "chi2_after", "p_after")
HELD_OUT = ("name", "before", "after", "closed")
CONSTANT = ("name", "unit", "drawn", "sound", "mean", "sd", "correlation")
PROPOSAL = ("name", "words", "cost", "is_strain_test")
"""Attributes that are keys."""


def _taken(value: Any, attributes: tuple[str, ...], /, **more: Any) -> dict[str, Any]:
    return {name: getattr(value, name) for name in attributes} | more


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
        "nodes": [_taken(f, ("path", "simulated", "real", "share"), split=f.words) for f in where.nodes],
    }


def _place(p: Place) -> dict[str, Any]:
    return _taken(p, PLACE, gap_microstrain=_strain(p.gap, p.unit))


def _cause(cause: Cause) -> dict[str, Any]:
    return {
        "effects": list(cause.effects),
        "probability": cause.probability,
        "certainty": str(cause.certainty),
        "parameters": [_parameter(p) for p in cause.parameters],
        "cannot_be_told_from": [list(c.effects[1:]) for c in cause.confounded],
    }


def _parameter(p: Parameter) -> dict[str, Any]:
    return _taken(p, PARAMETER, name=p.named.name)


def _noise(diagnosis: Diagnosis) -> dict[str, Any]:
    noise, sds = diagnosis.noise, noise_sds(diagnosis)
    unit = next(iter(sds)) if len(sds) == 1 else MIXED
    return {
        "sd": sds,
        "sd_microstrain": sds.get(MICROSTRAIN),
        "variance": sds[MICROSTRAIN] ** 2 if MICROSTRAIN in sds else None,
        "step_microstrain": _strain(noise.step, unit),
        "variance_ratio_by_load": {f"{load:g}": ratio for load, ratio in noise.scale.items()},
        **_taken(noise, ("lag1", "inflation", "kurtosis", "step", "stuck", "clipped", "findings")),
    }


def _shrinkage(s: Shrinkage) -> dict[str, Any]:
    strains = {f"{name}_microstrain": _strain(getattr(s, name), s.unit) for name in ("before", "after", "floor")}
    return _taken(s, CLOSING, **strains, held_out=[_taken(h, HELD_OUT) for h in s.held_out])


def _strain(value: float, unit: str) -> float | None:
    return value if unit == MICROSTRAIN else None


def _finite(value: Any) -> Any:
    """Return the value as JSON can say it: NaN and infinity are null, sequences are lists."""
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
