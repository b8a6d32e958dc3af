"""The wing beside CalculiX: gauge strains, linear and with large deflection.

    python -m benchmarks.wing.calculix [--wing tapered_wing] [--refinement R] [--large]
    python -m benchmarks.wing.calculix [--wing tapered_wing] [--refinement R] --states 10
    python -m benchmarks.wing.calculix [--wing built_wing] [--refinement R] --plies

needs `ccx` (Debian package calculix-ccx). Prints Markdown: how far femlib's strains are from CalculiX's at load factor
3, with --states in so many random states of both regions, and with --large by how much large deflection changes the
strain of each gauge in either. --plies compares the largest principal strain, a mean over each element, where plies are
nearest to failure.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.ccx import need_ccx, run_deck
from benchmarks.cpu import Stopwatch
from benchmarks.main_program import run_main
from femlib.export.calculix import Deck
from femlib.export.calculix_results import element_points
from femlib.structure.calculix import tensors
from femlib.wing import Wing, bend, tapered_wing, uav_wing
from femlib.wing.built import built_wing
from femlib.wing.export.calculix import read_gauges, write_deck
from femlib.wing.strength import wing_stresses

LOAD_FACTOR = 3.0
WINGS = {"uav_wing": uav_wing, "built_wing": built_wing, "tapered_wing": tapered_wing}
Floats = NDArray[np.float64]


def main() -> None:
    """Run both codes and print the tables."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.calculix", description=__doc__)
    parser.add_argument("--refinement", type=float, default=1.0)
    parser.add_argument("--large", action="store_true", help="large deflection besides (CalculiX takes minutes)")
    parser.add_argument("--wing", choices=WINGS, default="uav_wing")
    parser.add_argument("--states", type=int, default=0, help="so many random states, up to 95 %% damaged, instead")
    parser.add_argument("--plies", action="store_true", help="strains of the plies nearest to failure instead")
    options = parser.parse_args()
    need_ccx()
    wing = WINGS[options.wing](refinement=options.refinement)
    if options.plies:
        print_plies(wing)
        return
    if options.states:
        print_states(wing, options.states)
        return
    ours, theirs = wing.strain_microstrain({}, LOAD_FACTOR), calculix(wing, {})
    usable = wing.gauges.is_usable
    error = np.sqrt(np.mean((ours / theirs - 1.0) ** 2)), np.abs(ours / theirs - 1.0).max()
    print(f"linear, 24 gauges: {100 * error[0]:.2f} % rms, {100 * error[1]:.2f} % at most")
    if options.large:
        watch = Stopwatch()
        bent = bend(wing, {}, LOAD_FACTOR)
        print(f"femlib: {bent.deflection.n_iterations} iterations, {watch.read()[0]:.0f} CPU s, tip {bent.tip} m")
        first = bent.strain_microstrain / ours - 1.0
        second = calculix(wing, {}, large=True) / theirs - 1.0
        print_changes(wing.gauges.names, first, second, usable)


def print_states(wing: Wing, n_states: int) -> None:
    """Print how far the gauge strains of random damage states are from CalculiX's, in per cent of each."""
    usable = wing.gauges.is_usable
    print("| mu1 | mu2 | 24 gauges, rms | 20 gauges, rms | 20 gauges, at most |\n|---|---|---|---|---|")
    for mu1, mu2 in np.random.default_rng(0).uniform(0.0, 0.95, (n_states, 2)):
        state = {"mu1": float(mu1), "mu2": float(mu2)}
        ours = wing.strain_microstrain(state, LOAD_FACTOR)
        error = 100.0 * (ours / calculix(wing, state) - 1.0)
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
        path = Path(folder) / "wing.inp"
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
        run_deck(path)
        points = element_points(path.with_suffix(".dat"))
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


def calculix(wing: Wing, state: dict[str, float], large: bool = False) -> Floats:
    """Return the gauge strains that CalculiX finds [microstrain]."""
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "wing.inp"
        write_deck(wing, deck, state, LOAD_FACTOR, large_deflection=large)
        run_deck(deck)
        return read_gauges(wing, deck.with_suffix(".dat"))


def print_changes(names: tuple[str, ...], ours: Floats, theirs: Floats, usable: NDArray[np.bool_]) -> None:
    """Print the change of each gauge's strain in per cent, and its difference."""
    print("| gauge | femlib | CalculiX | difference |\n|---|---|---|---|")
    for name, a, b in zip(names, 100 * ours, 100 * theirs, strict=True):
        print(f"| {name} | {a:.2f} % | {b:.2f} % | {a - b:+.2f} % |")
    gap = 100 * (ours - theirs)[usable]
    print(f"\n20 gauges: {np.sqrt(np.mean(gap**2)):.2f} % of strain rms, {np.abs(gap).max():.2f} % at most")


if __name__ == "__main__":
    run_main(main)
