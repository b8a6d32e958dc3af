"""Loads of the wing beside the ellipse: `python -m benchmarks.wing.loads [--refinement 1]`.

Prints Markdown: bending moments and strains of the vortex lattice and of the inertia over the ellipse's. The lattice
needs AeroSandbox: pip install 'octmip[aero]'.
"""

import argparse

import numpy as np
from numpy.typing import NDArray

from benchmarks.main_program import run_main
from femlib.wing import Wing, inertial_load, uav_wing, vortex_lattice

STATIONS = (0.0, 0.25, 0.5, 0.75)
LOAD_FACTORS = (-1.0, 1.0, 3.0, 4.0)
Floats = NDArray[np.float64]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.loads", description=__doc__)
    parser.add_argument("--refinement", type=float, default=1.0)
    wing = uav_wing(refinement=parser.parse_args().refinement)
    loads(wing)


def loads(wing: Wing) -> None:
    """Print moments about four stations and strains, each over the ellipse's at the same load factor."""
    usable, ellipse = wing.gauges.is_usable, wing.strain_microstrain({}, 1.0)
    print("| load | angle of attack | moment at eta " + ", ".join(map(str, STATIONS)) + " | strain of 20 gauges |")
    print("|---|---|---|---|")
    rows = []
    for factor in LOAD_FACTORS:
        found = vortex_lattice(wing, factor)
        angle = f"{np.degrees(found.angle_of_attack):.1f} degrees"
        rows.append((f"vortex lattice, load factor {factor:g}", angle, found.forces / factor))
    rows.append(("ellipse and the wing's own mass", "", wing.lift + inertial_load(wing)))
    for name, angle, force in rows:
        ratio = ", ".join(f"{moment(wing, force, s) / moment(wing, wing.lift, s):.2f}" for s in STATIONS)
        change = 100 * (wing.strain_microstrain({}, 1.0, force) / ellipse - 1.0)[usable]
        print(f"| {name} | {angle} | {ratio} | {change.min():+.0f} to {change.max():+.0f} % |")


def moment(wing: Wing, force: Floats, eta: float) -> float:
    """Return the bending moment of vertical forces outboard of a span fraction [N m]."""
    y = wing.structure.shells.mesh.nodes[:, 1]
    return float(np.maximum(y - eta * wing.span, 0.0) @ force.reshape(-1, 6)[:, 2])


if __name__ == "__main__":
    run_main(main)
