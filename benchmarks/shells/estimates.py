"""What the estimates of error are worth: error, estimate and verdict of each case, worst meshes and good ones.

    python -m benchmarks.shells.estimates

prints a Markdown table. Buckling and frequencies: a cantilever blade under a force across its tip that buckles sideways
(A. G. M. Michell, Phil. Mag. 48 (1899) 298: 4.013 (E I G J)^1/2 / L^2), a simply supported cylinder under axial load
(R. Lorenz 1911: E t^2 / R / (3 (1 - nu^2))^1/2 per length) and its lowest frequency against a fine mesh.
"""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from benchmarks.main_program import run_main
from benchmarks.shells.case import DIAGONALS, Case, along_end, cut, hold, mapped
from benchmarks.shells.curved import pinched_cylinder, pinched_hemisphere, scordelis_lo_roof
from benchmarks.shells.plates import cook_membrane, morley_skew_plate, razzaque_skew_plate, square_plate
from benchmarks.shells.strips import curved_beam, raasch_hook, straight_beam, twisted_beam
from femlib.arrays import FloatArray
from femlib.assembly import MOST_ERROR, Shells, Supports, buckling_modes, natural_modes
from femlib.material import isotropic_plate

Measured = tuple[float, float]
"""Error of the answer, positive where it is too low, and its estimate."""
FIRST = DIAGONALS[0]
RADIUS, THIN, YOUNG, POISSON = 1.0, 0.01, 70e9, 0.3


def displacements(make: Callable[[], Case]) -> Measured:
    """Return error and estimate of a case's displacement."""
    ratio, quality = make().judged()
    return 1.0 - ratio, quality.displacement_error


def blade(n: int, n_across: int, diagonal: str | None) -> Measured:
    """Return those of the load at which a blade 1 x 0.05 x 0.002 m buckles sideways."""
    length, height, thick = 1.0, 0.05, 0.002
    shells, node = mapped(
        lambda u, v: np.stack([length * u, 0.0 * u, height * (v - 0.5)], axis=-1),
        n,
        n_across,
        isotropic_plate(YOUNG, POISSON, thick),
    )
    load = along_end(shells, node[-1], "w")
    shells = shells if diagonal is None else cut(shells, diagonal)
    supports = Supports.holding(shells.mesh, hold(node[0], "uvwxyz"))
    torsion = height * thick**3 / 3.0 * (1.0 - 0.63 * thick / height)
    bending, shear = YOUNG * height * thick**3 / 12.0, YOUNG / 2.0 / (1.0 + POISSON)
    exact = 4.013 * np.sqrt(bending * shear * torsion) / length**2
    mode = buckling_modes(shells, supports, load, limit=np.finfo(float).max)[0]
    return 1.0 - mode.factor / exact, mode.error


def cylinder(n: int, n_up: int) -> tuple[Shells, Supports, FloatArray]:
    """Return a quarter of a cylinder, radius and height 1 m, 10 mm thick, and an axial load of 1 N/m on its edge."""
    shells, node = mapped(
        lambda u, v: np.stack([np.cos(0.5 * np.pi * u), np.sin(0.5 * np.pi * u), v], axis=-1),
        n,
        n_up,
        isotropic_plate(YOUNG, POISSON, THIN, 2700.0),
    )
    held = [hold(node[:, 0], "uvwz"), hold(node[:, -1], "uvz"), hold(node[0], "vxz"), hold(node[-1], "uyz")]
    load = -0.5 * np.pi * RADIUS * along_end(shells, node[:, -1], "w")
    return shells, Supports.holding(shells.mesh, np.unique(np.concatenate(held))), load


def cylinder_load(n: int, n_up: int) -> Measured:
    """Return those of the axial load at which it buckles."""
    shells, supports, load = cylinder(n, n_up)
    exact = YOUNG * THIN**2 / RADIUS / np.sqrt(3.0 * (1.0 - POISSON**2))
    mode = buckling_modes(shells, supports, load, limit=np.finfo(float).max)[0]
    return 1.0 - mode.factor / exact, mode.error


def cylinder_frequency(n: int, n_up: int) -> Measured:
    """Return those of its lowest frequency, against a mesh of 48 x 48."""
    found = []
    for mesh, is_refined in (((n, n_up), True), ((48, 48), False)):
        shells, supports, _ = cylinder(*mesh)
        found.append(natural_modes(shells, supports, 1, limit=np.finfo(float).max, is_refined=is_refined)[0])
    return 1.0 - found[0].frequency / found[1].frequency, found[0].error


def _ring_of_triangles(k: int) -> Case:
    return curved_beam("w", 6 * k, k).in_triangles(FIRST)


def _static() -> dict[str, Callable[[], Case]]:
    cases: dict[str, Callable[[], Case]] = {}
    for name, problem, meshes in (
        ("Scordelis-Lo roof", scordelis_lo_roof, (4, 8)),
        ("pinched cylinder", pinched_cylinder, (8, 16, 32)),
        ("pinched hemisphere", pinched_hemisphere, (8, 16)),
        ("Morley skew plate", morley_skew_plate, (8, 16)),
        ("Razzaque skew plate", razzaque_skew_plate, (8, 16)),
        ("Cook's membrane", cook_membrane, (4, 8)),
        ("square plate, clamped", partial(square_plate, clamped=True), (4, 8)),
    ):
        cases |= {f"{name}, {n}": partial(problem, n) for n in meshes}
    for shape in ("rectangular", "trapezoidal", "parallelogram"):
        cases |= {f"straight beam 6 x 1, {shape}, {way}": partial(straight_beam, shape, way) for way in "vwx"}
    for k in (2, 3, 4, 8):
        cases[f"straight beam {6 * k} x {k}, rectangular, x"] = partial(straight_beam, "rectangular", "x", 6 * k, k)
    cases["straight beam 24 x 4, parallelogram, w"] = partial(straight_beam, "parallelogram", "w", 24, 4)
    for k in (1, 2, 4):
        cases[f"curved beam {6 * k} x {k}, w"] = partial(curved_beam, "w", 6 * k, k)
    for k in (2, 4):
        cases[f"curved beam {6 * k} x {k}, w, triangles"] = partial(_ring_of_triangles, k)
    cases["twisted beam 12 x 2, t 0.0032, v"] = partial(twisted_beam, 0.0032, "v")
    for n, across in ((9, 1), (21, 2), (36, 4)):
        cases[f"Raasch's hook, {n} x {across}"] = partial(raasch_hook, n, across)
    return cases


def _modes() -> dict[str, Callable[[], Measured]]:
    cases: dict[str, Callable[[], Measured]] = {}
    for n, across in ((48, 1), (96, 2), (192, 4)):
        cases[f"blade, sideways, triangles {n} x {across}"] = partial(blade, n, across, FIRST)
    cases["blade, sideways, 48 x 4"] = partial(blade, 48, 4, None)
    for n in (8, 16, 24):
        cases[f"cylinder, axial load, {n} x {n}"] = partial(cylinder_load, n, n)
    for n in (4, 8, 16):
        cases[f"cylinder, frequency, {n} x {n}"] = partial(cylinder_frequency, n, n)
    return cases


STATIC: Mapping[str, Callable[[], Case]] = _static()
MODES: Mapping[str, Callable[[], Measured]] = _modes()


def main() -> None:
    """Print the table."""
    print("| case | error | estimate | |\n|---|---|---|---|")
    measure = {name: partial(displacements, make) for name, make in STATIC.items()} | dict(MODES)
    for name, take in measure.items():
        error, estimate = take()
        print(
            f"| {name} | {error:.4f} | {estimate:.4f} | {'refused' if estimate > MOST_ERROR else 'accepted'} |",
            flush=True,
        )


if __name__ == "__main__":
    run_main(main)
