"""The wing beside CalculiX: gauge strains, linear and with large deflection.

    python -m benchmarks.wing.calculix [--refinement R] [--calculix-refinement R] [--mu 0.8] [--lattice] [--large]
    python -m benchmarks.wing.calculix [--wing tapered_wing] [--refinement R] --states 10
    python -m benchmarks.wing.calculix [--refinement R] --frequencies
    python -m benchmarks.wing.calculix [--wing built_wing] [--refinement R] --plies

needs `ccx` (Debian package calculix-ccx). Prints Markdown: how far femlib's strains are from CalculiX's at load factor
3, with --states in so many random states of both regions, and with --large by how much large deflection changes the
strain of each gauge in either. --plies compares the largest principal strain, a mean over each element, where plies are
nearest to failure.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.cpu import Stopwatch
from benchmarks.main_program import run_main
from femlib.assembly import matrix_modes
from femlib.export.calculix import Deck
from femlib.export.calculix_results import element_points
from femlib.structure.calculix import tensors
from femlib.wing import Wing, bend, inertial_load, tapered_wing, uav_wing, vortex_lattice
from femlib.wing.built import built_wing
from femlib.wing.export.calculix import read_gauges, write_deck
from femlib.wing.strength import wing_stresses

LOAD_FACTOR = 3.0
N_MODES = 4
WINGS = {"uav_wing": uav_wing, "built_wing": built_wing, "tapered_wing": tapered_wing}
Floats = NDArray[np.float64]


def main() -> None:
    """Run both codes and print the tables."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.calculix", description=__doc__)
    parser.add_argument("--refinement", type=float, default=1.0)
    parser.add_argument("--calculix-refinement", type=float, default=None, help="default: the same")
    parser.add_argument("--mu", type=float, default=0.0, help="damage of both regions")
    parser.add_argument("--lattice", action="store_true", help="vortex lattice and the wing's inertia, not the ellipse")
    parser.add_argument("--large", action="store_true", help="large deflection besides (CalculiX takes minutes)")
    parser.add_argument("--wing", choices=WINGS, default="uav_wing")
    parser.add_argument("--states", type=int, default=0, help="so many random states, up to 95 %% damaged, instead")
    parser.add_argument("--frequencies", action="store_true", help="the lowest natural frequencies instead")
    parser.add_argument("--plies", action="store_true", help="strains of the plies nearest to failure instead")
    options = parser.parse_args()
    if shutil.which("ccx") is None:
        sys.exit("ccx is not on the path; install CalculiX (Debian package calculix-ccx)")
    make = WINGS[options.wing]
    wing = make(refinement=options.refinement)
    other = options.calculix_refinement
    deck_wing = wing if other in (None, options.refinement) else make(refinement=other)
    if options.frequencies:
        print_frequencies(wing, deck_wing)
        return
    if options.plies:
        print_plies(wing)
        return
    if options.states:
        print_states(wing, deck_wing, options.states)
        return
    state = {"mu1": options.mu, "mu2": options.mu}
    ours = wing.strain_microstrain(state, LOAD_FACTOR, lift_of(wing, options.lattice))
    theirs = calculix(deck_wing, state, options.lattice, large=False)
    usable = wing.gauges.is_usable
    error = np.sqrt(np.mean((ours / theirs - 1.0) ** 2)), np.abs(ours / theirs - 1.0).max()
    print(f"linear, 24 gauges: {100 * error[0]:.2f} % rms, {100 * error[1]:.2f} % at most")
    if options.large:
        watch = Stopwatch()
        bent = bend(wing, state, LOAD_FACTOR, lift=lift_of(wing, options.lattice))
        print(f"femlib: {bent.deflection.n_iterations} iterations, {watch.read()[0]:.0f} CPU s, tip {bent.tip} m")
        first = bent.strain_microstrain / ours - 1.0
        second = calculix(deck_wing, state, options.lattice, large=True) / theirs - 1.0
        print_changes(wing.gauges.names, first, second, usable)


def print_states(wing: Wing, deck_wing: Wing, n_states: int) -> None:
    """Print how far the gauge strains of random damage states are from CalculiX's, in per cent of each."""
    usable = wing.gauges.is_usable
    print("| mu1 | mu2 | 24 gauges, rms | 20 gauges, rms | 20 gauges, at most |\n|---|---|---|---|---|")
    for mu1, mu2 in np.random.default_rng(0).uniform(0.0, 0.95, (n_states, 2)):
        state = {"mu1": float(mu1), "mu2": float(mu2)}
        ours = wing.strain_microstrain(state, LOAD_FACTOR)
        error = 100.0 * (ours / calculix(deck_wing, state, lattice=False, large=False) - 1.0)
        rms, own = np.sqrt(np.mean(error**2)), np.sqrt(np.mean(error[usable] ** 2))
        print(
            f"| {mu1:.2f} | {mu2:.2f} | {rms:.2f} % | {own:.2f} % | {np.abs(error[usable]).max():.2f} % |", flush=True
        )


def print_plies(wing: Wing) -> None:
    """Print the strains of the elements whose plies are nearest to failure, of each patch the nearest one."""
    mesh, found = wing.structure.shells.mesh, wing_stresses(wing, {}, LOAD_FACTOR)
    order = np.argsort(found.failure_factors("max strain"), kind="stable")
    quads = [int(e) for e in found.element[order] if e < len(mesh.quads)]
    nearest = {mesh.patch_of_element[e]: e for e in reversed(quads)}
    elements = np.sort(list(nearest.values()))
    deck = Deck(wing.structure.shells, wing.structure.supports, LOAD_FACTOR * wing.lift, printed=elements)
    with tempfile.TemporaryDirectory() as folder:
        lines = [own + ", GLOBAL=YES" if own.startswith("*EL PRINT") else own for own in deck.lines()]
        (Path(folder) / "wing.inp").write_text("\n".join(lines) + "\n", encoding="ascii")
        run_deck(folder)
        points = element_points(Path(folder) / "wing.dat")
    print("| part | span | plies fail at | femlib, microstrain | CalculiX | difference |\n|---|---|---|---|---|---|")
    for element in elements.tolist():
        own = found.element == element
        xx, yy, xy = found.strain[own].mean(axis=0)
        ours = _principal(np.array([[xx, xy / 2], [xy / 2, yy]]))
        normal = mesh.area_vectors()[element]
        flat = np.linalg.svd(normal[None])[2][1:]
        theirs = _principal(flat @ tensors(np.array(points[element])).mean(axis=0) @ flat.T)
        part, eta = mesh.patches[mesh.patch_of_element[element]], mesh.centroids()[element, 1] / wing.span
        fails = LOAD_FACTOR * found.failure_factors("max strain")[own].min()
        print(
            f"| {part} | {eta:.3f} | {fails:.2f} g | {ours:.0f} | {theirs:.0f} | {100 * (ours / theirs - 1):+.1f} % |"
        )


def _principal(strain: Floats) -> float:
    """Return the principal strain of largest size [microstrain] of a tensor (2, 2)."""
    both = np.linalg.eigvalsh(strain)
    return float(1e6 * both[np.abs(both).argmax()])


def print_frequencies(wing: Wing, deck_wing: Wing) -> None:
    """Print the lowest frequencies of both codes [Hz], without point masses."""
    shells = wing.structure.shells
    modes = matrix_modes(shells.stiffness(), shells.mass(), wing.structure.supports, N_MODES)
    print("| mode | femlib | CalculiX | difference |\n|---|---|---|---|")
    for number, (mode, theirs) in enumerate(zip(modes, calculix_frequencies(deck_wing), strict=True), start=1):
        print(f"| {number} | {mode.frequency:.3f} | {theirs:.3f} | {100 * (mode.frequency / theirs - 1.0):+.2f} % |")


def calculix_frequencies(wing: Wing) -> list[float]:
    """Return the lowest natural frequencies [Hz] of the deck's structure."""
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "wing.inp"
        write_deck(wing, deck, {}, 1.0)
        structure = deck.read_text(encoding="ascii").partition("*INITIAL CONDITIONS")[0]
        deck.write_text(f"{structure}*STEP\n*FREQUENCY\n{N_MODES}\n*END STEP\n", encoding="ascii")
        run_deck(folder)
        text = (Path(folder) / "wing.dat").read_text(encoding="ascii")
    rows = [line.split() for line in text.partition("P A R T I C I P A T I O N")[0].splitlines()]
    # columns: mode, eigenvalue, omega [rad/s], frequency [Hz], imaginary part
    return [float(row[3]) for row in rows if len(row) == 5 and row[0].isdigit()]


def run_deck(folder: str) -> None:
    """Solve the deck wing.inp of a folder on one thread."""
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run(["ccx", "wing"], cwd=folder, check=True, capture_output=True, env=one_thread)


def lift_of(wing: Wing, lattice: bool) -> Floats | None:
    """Return the nodal forces at load factor 1 that the strains at load factor 3 are those of."""
    if not lattice:
        return None
    return vortex_lattice(wing, LOAD_FACTOR).forces / LOAD_FACTOR + inertial_load(wing)


def calculix(wing: Wing, state: dict[str, float], lattice: bool, large: bool) -> Floats:
    """Return the gauge strains that CalculiX finds [microstrain]."""
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "wing.inp"
        write_deck(wing, deck, state, LOAD_FACTOR, large_deflection=large, lift=lift_of(wing, lattice))
        run_deck(folder)
        return read_gauges(wing, Path(folder) / "wing.dat")


def print_changes(names: tuple[str, ...], ours: Floats, theirs: Floats, usable: NDArray[np.bool_]) -> None:
    """Print the change of each gauge's strain in per cent, and its difference."""
    print("| gauge | femlib | CalculiX | difference |\n|---|---|---|---|")
    for name, a, b in zip(names, 100 * ours, 100 * theirs, strict=True):
        print(f"| {name} | {a:.2f} % | {b:.2f} % | {a - b:+.2f} % |")
    gap = 100 * (ours - theirs)[usable]
    print(f"\n20 gauges: {np.sqrt(np.mean(gap**2)):.2f} % of strain rms, {np.abs(gap).max():.2f} % at most")


if __name__ == "__main__":
    run_main(main)
