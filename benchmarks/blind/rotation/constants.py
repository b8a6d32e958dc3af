"""What two honest models of the wing differ by, settled on some families of assets, to be judged on others.

`python -m benchmarks.blind.rotation.constants --family springs --family beam [--keys FILE]` prints them. Rules:

* common, and smooth and own in equal parts: the root mean square over the families of what the sound strains show;
* damage: the standard deviation of what a damage changes at a gauge, relatively, amounts beyond three robust ones
  (1.48 times the median amount) taken as three;
* the error of an effect's own trace: the sine of the angle between the family's trace and the twin's most alike one.
"""

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.blind.answers import Constants, twin
from benchmarks.blind.assets.asset import HOUR, PARAMETERS, Asset
from benchmarks.blind.assets.changes import change
from benchmarks.blind.assets.families import FAMILIES, made
from benchmarks.blind.assets.moment import Moment
from benchmarks.blind.limit.candidates import singles
from benchmarks.main_program import run_main
from femlib.arrays import FloatArray
from octmip.gap import Differences
from octmip.gap.twins.cached import CachedTwin

LOAD = 2.0
"""At which traces are compared."""
LEAST = 0.002
"""Relative standard deviation below which none is settled: two runs of one code differ by as much."""
LEAST_TRACE = 0.01
SEEN = 0.05
"""Share of the greatest change by a damage below which a gauge says nothing of its relative error."""
ROBUST = 1.4826
"""Standard deviation of a normal number over the median of its amount."""
FAR = 3.0
"""Robust standard deviations beyond which a gauge counts no more."""


def main() -> None:
    """Print the constants of some families."""
    parser = argparse.ArgumentParser(prog="benchmarks.blind.rotation.constants", description=__doc__)
    parser.add_argument("--family", action="append", choices=FAMILIES, required=True)
    parser.add_argument("--keys", type=Path, default=None, help="of a set whose runs may serve again")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--twin-mesh", type=float, default=1.0, help="refinement of the twin")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        keys = options.keys or Path(scratch) / "set.keys.json"
        found = settled([made(name, options.seed, keys) for name in options.family], twin(options.twin_mesh))
    print(found.differences)
    print(", ".join(f"{name} {error:.3g}" for name, error in found.trace_errors.items()))


def settled(assets: Sequence[Asset], model: CachedTwin) -> Constants:
    """Return the constants that some assets show beside the twin."""
    healthy = [_healthy(asset, model) for asset in assets]
    common = _rms([float(ratio.mean()) - 1.0 for ratio in healthy])
    own = float(_rms([float(ratio.std()) for ratio in healthy]) / np.sqrt(2.0))
    damage = np.concatenate([_damage(asset, ratio, model) for asset, ratio in zip(assets, healthy, strict=True)])
    most = FAR * ROBUST * float(np.median(np.abs(damage)))
    differences = Differences(
        common=max(common, LEAST),
        smooth=max(own, LEAST),
        own=max(own, LEAST),
        damage=max(_rms(np.clip(damage, -most, most).tolist()), LEAST),
    )
    errors = [_trace_errors(asset, model) for asset in assets]
    names = sorted({name for found in errors for name in found})
    by_name = {name: _rms([e for found in errors for e in found.get(name, [])]) for name in names}
    return Constants(differences, {name: max(error, LEAST_TRACE) for name, error in by_name.items()})


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _columns(asset: Asset, model: CachedTwin) -> list[int]:
    return [model.gauges.index(name) for name in asset.gauges]


def _healthy(asset: Asset, model: CachedTwin) -> FloatArray:
    """Return the sound asset's strains over the twin's (n_gauges,)."""
    return np.asarray(asset.strain(asset.states[0]) / model.predict({}, 1.0)[_columns(asset, model)])


def _damage(asset: Asset, ratio: FloatArray, model: CachedTwin) -> FloatArray:
    """Return the relative errors (n,) of what damages change, calibrated by the sound strains."""
    columns, sound = _columns(asset, model), asset.states[0]
    found = []
    for state in asset.states[1:]:
        named = dict(zip(PARAMETERS, state, strict=True))
        theirs = (model.predict(named, 1.0) - model.predict({}, 1.0))[columns]
        ours = (asset.strain(state) - asset.strain(sound)) / ratio
        seen = np.abs(theirs) > SEEN * np.abs(theirs).max()
        found.append(ours[seen] / theirs[seen] - 1.0)
    return np.concatenate(found)


def _trace_errors(asset: Asset, model: CachedTwin) -> dict[str, list[float]]:
    """Return by effect, for each place of the asset, the sine of the angle to the most alike trace of the twin."""
    columns, sound = _columns(asset, model), asset.states[0]
    moment = Moment(sound, LOAD, np.array([HOUR]), ((LOAD, 0.0),))
    before = LOAD * asset.strain(sound)[None, :]
    found: dict[str, list[float]] = {}
    for candidate in singles(asset):
        effect = model.effects.get(candidate.truth.name)
        if effect is None or getattr(effect, "signature_error", 0.0) == 0.0:
            continue
        ours = change(candidate.truth, asset, moment, before)[0]
        theirs = [effect.signature(model, {}, LOAD, place, HOUR)[columns] for place in effect.places(model)]
        alike = max(abs(float(ours @ t)) / max(float(np.linalg.norm(ours) * np.linalg.norm(t)), 1e-300) for t in theirs)
        found.setdefault(candidate.truth.name, []).append(float(np.sqrt(max(0.0, 1.0 - alike**2))))
    return found


if __name__ == "__main__":
    run_main(main)
