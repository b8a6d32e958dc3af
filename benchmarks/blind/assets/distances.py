"""How far a family stands from the twin: `python -m benchmarks.blind.assets.distances [--family NAME] [--keys FILE]`.

Prints Markdown: strains of the sound wing over the twin's, in common and per gauge, and what is left of the change
that damage makes once a commissioning run has calibrated every gauge. Expensive runs are kept beside --keys.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.blind.assets.asset import PARAMETERS, Asset
from benchmarks.blind.assets.families import FAMILIES, available, made
from benchmarks.main_program import run_main
from femlib.wing import Wing, tapered_wing


def main() -> None:
    """Print a row for each family."""
    parser = argparse.ArgumentParser(prog="benchmarks.blind.assets.distances", description=__doc__)
    parser.add_argument("--family", action="append", choices=FAMILIES)
    parser.add_argument("--keys", type=Path, default=None, help="of a set whose runs may serve again")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    wing = tapered_wing()
    print("| family | in common | per gauge, sd | per gauge, most | damage: size | damage: left over |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as scratch:
        for name in options.family or available():
            asset = made(name, options.seed, options.keys or Path(scratch) / "set.keys.json")
            common, own, most, size, left = distance(asset, wing)
            print(f"| {name} | {common:+.1%} | {own:.1%} | {most:.1%} | {size:.2f} | {left:.1%} |")


def distance(asset: Asset, wing: Wing) -> tuple[float, float, float, float, float]:
    """Return how far an asset is from a wing.

    These are the mean ratio of the sound strains less one; standard deviation and largest amount of the rest; the size
    of the changes that the asset's damaged states make over the wing's; and what that size leaves, as a share.
    """

    def strain(state: tuple[float, ...]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        found = wing.strain_microstrain(dict(zip(PARAMETERS, state, strict=True)), 1.0)
        return np.asarray(found[wing.gauges.is_usable])

    sound = asset.states[0]
    ratio = asset.strain(sound) / strain(sound)
    ours = np.concatenate([(asset.strain(state) - asset.strain(sound)) / ratio for state in asset.states[1:]])
    theirs = np.concatenate([strain(state) - strain(sound) for state in asset.states[1:]])
    size = float(ours @ theirs / (theirs @ theirs))
    left = float(np.linalg.norm(ours - theirs) / np.linalg.norm(theirs))
    rest = ratio - ratio.mean()
    return float(ratio.mean() - 1.0), float(rest.std()), float(np.abs(rest).max()), size, left


if __name__ == "__main__":
    run_main(main)
