"""The standard shell problems: mesh, supports and load of each, solved to the ratio of its published answer.

Sources: R. H. MacNeal, R. L. Harder, Finite Elements in Analysis and Design 1 (1985) 3-20 (beams, Scordelis-Lo roof,
pinched hemisphere); T. Belytschko et al., Comput. Methods Appl. Mech. Engng 51 (1985) 221-258 (pinched cylinder); L.
S. D. Morley, Skew Plates and Structures (1963); R. D. Cook, J. Struct. Div. ASCE 100 (1974) 1851-1863, limit 23.96; S.
Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells (1959), tables 8 and 35; N. F. Knight, AIAA Journal 35
(1997) 1048-1052 (Raasch's hook; 5.02 is what solid elements give).
"""

from collections.abc import Callable

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Quality, Shells, Supports, factorise, line_load, solution_quality, surface_load
from femlib.material import Laminate, isotropic_plate
from femlib.mesh import DOFS_PER_NODE, Mesh, QualityLimits

Place = Callable[[FloatArray, FloatArray], FloatArray]


SLENDER = QualityLimits(aspect=1e3)


def mapped(
    place: Place, n_u: int, n_v: int, laminate: Laminate, limits: QualityLimits = SLENDER
) -> tuple[Shells, IntArray]:
    """Return shells on the image of the unit square under `place`, and the nodes (n_u + 1, n_v + 1)."""
    u, v = np.meshgrid(np.linspace(0, 1, n_u + 1), np.linspace(0, 1, n_v + 1), indexing="ij")
    number = np.arange(u.size).reshape(u.shape)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    nodes = place(u, v).reshape(-1, 3)
    zeros = np.zeros(len(quads), dtype=np.int64)
    mesh = Mesh(nodes, quads, np.zeros((0, 3), dtype=np.int64), ("shell",), zeros, limits)
    return Shells(mesh, (laminate,), zeros, np.ones(len(quads)), np.zeros(3)), number


def hold(nodes: IntArray, directions: str) -> IntArray:
    """Return degrees of freedom of nodes: u, v, w translations, x, y, z rotations, in the order of "uvwxyz"."""
    numbers = np.array(["uvwxyz".index(d) for d in directions], dtype=np.int64)
    return np.asarray(DOFS_PER_NODE * nodes.ravel()[:, None] + numbers).ravel()


def solved(shells: Shells, held: list[IntArray], load: FloatArray) -> FloatArray:
    """Return displacements (n_nodes, 6)."""
    supports = Supports.holding(shells.mesh, np.concatenate(held))
    factors = factorise(supports.reduce(shells.stiffness()), supports.groups)
    return supports.expand(factors.solve(load[supports.free])).reshape(-1, DOFS_PER_NODE)


def force(shells: Shells, node: int, direction: str, size: float) -> FloatArray:
    """Return the load (n_dofs,) of one nodal force."""
    load = np.zeros(shells.mesh.n_dofs)
    load[hold(np.array([node]), direction)] = size
    return load


def scordelis_lo_roof(n: int, slant: float = 0.0) -> float:
    """Quarter of a roof under its weight: deflection of the free edge's middle over 0.3024.

    Mesh lines lean across it by `slant` of its width in its middle, so that its elements are warped.
    """

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        angle = np.radians(40.0) * (u + slant * np.sin(np.pi * u) * (v - 0.5))
        return np.stack([25.0 * np.sin(angle), 25.0 * v, 25.0 * np.cos(angle)], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(4.32e8, 0.0, 0.25))
    weight = np.tile([0.0, 0.0, -90.0], (shells.mesh.n_elements, 1))
    # y = 0 is the middle, y = 25 the diaphragm; x = 0 the crown
    held = [hold(node[:, -1], "uw"), hold(node[:, 0], "vxz"), hold(node[0], "uyz")]
    moved = solved(shells, held, surface_load(shells.mesh, weight))
    return float(-moved[node[-1, 0], 2] / 0.3024)


def pinched_cylinder(n: int) -> float:
    """Eighth of a cylinder with end diaphragms under two opposite forces: deflection under one over 1.8248e-5."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        angle = 0.5 * np.pi * u
        return np.stack([300.0 * np.sin(angle), 300.0 * v, 300.0 * np.cos(angle)], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(3e6, 0.3, 3.0))
    held = [hold(node[:, -1], "uw"), hold(node[:, 0], "vxz"), hold(node[0], "uyz"), hold(node[-1], "wxy")]
    moved = solved(shells, held, force(shells, int(node[0, 0]), "w", -0.25))
    return float(-moved[node[0, 0], 2] / 1.8248e-5)


def pinched_hemisphere(n: int) -> float:
    """Quarter of a hemisphere with a hole of 18 degrees under four forces of 2: deflection under one over 0.093."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        around, up = 0.5 * np.pi * u, np.radians(72.0) * v
        return 10.0 * np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(6.825e7, 0.3, 0.04))
    load = force(shells, int(node[0, 0]), "u", 1.0) + force(shells, int(node[-1, 0]), "v", -1.0)
    held = [hold(node[0], "vxz"), hold(node[-1], "uyz"), hold(node[:1, :1], "w")]
    return float(solved(shells, held, load)[node[0, 0], 0] / 0.093)


def morley_skew_plate(n: int) -> float:
    """Simply supported 30 degree plate, side / thickness 100, uniform load: deflection of the middle over 4.455."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
        return 100.0 * np.stack([u + c * v, s * v, 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(1e5, 0.3, 1.0))
    edge = np.unique(np.concatenate([node[0], node[-1], node[:, 0], node[:, -1]]))
    held = [hold(edge, "w"), hold(node[:1, :1], "uv"), hold(node[-1:, :1], "v")]
    load = surface_load(shells.mesh, np.tile([0.0, 0.0, 1.0], (shells.mesh.n_elements, 1)))
    return float(solved(shells, held, load)[node[n // 2, n // 2], 2] / 4.455)


def cook_membrane(n: int) -> float:
    """Tapered panel in shear: deflection of the loaded edge's middle over 23.96."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        return np.stack([48.0 * u, 44.0 * u + v * (44.0 - 28.0 * u), 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(1.0, 1.0 / 3.0, 1.0))
    load = line_load(shells.mesh, node[-1], np.array([0.0, 1.0 / 16.0, 0.0]))
    held = [hold(node[0], "uvz"), hold(node, "wxy")]
    moved = solved(shells, held, load)
    return float(moved[node[-1, n // 2], 1] / 23.96)


def square_plate(n: int, clamped: bool) -> float:
    """Quarter of a thin square plate under uniform load: deflection of the middle over the series' value."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        return 0.5 * np.stack([u, v, 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(10.92e9, 0.3, 1e-3))
    held = [hold(node[0], "uyz"), hold(node[:, 0], "vxz")]  # the middle lies at the first node
    for edge, along in ((node[-1], "x"), (node[:, -1], "y")):
        held.append(hold(edge, "wxy" if clamped else "w" + along))
    load = surface_load(shells.mesh, np.tile([0.0, 0.0, 1.0], (shells.mesh.n_elements, 1)))
    series = (0.00126532 if clamped else 0.00406235) / (10.92e9 * 1e-9 / 12.0 / 0.91)
    return float(solved(shells, held, load)[node[0, 0], 2] / series)


BEAM_SHAPES = ("rectangular", "trapezoidal", "parallelogram")


def straight_beam(shape: str, direction: str, n: int = 6, n_across: int = 1) -> float:
    """Cantilever 6 x 0.2 x 0.1 of n elements under unit tip forces: deflection over beam theory's.

    `direction`: "u" extension, "v" in-plane shear, "w" out-of-plane shear, "x" twist.
    """
    slant = {"rectangular": (0.0, 0.0), "trapezoidal": (1.0, -1.0), "parallelogram": (1.0, 1.0)}[shape]

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        station = np.round(u * n)
        inner = (station > 0) & (station < n)
        sign = np.where(station % 2 == 1, 1.0, -1.0) if shape == "trapezoidal" else 1.0
        shift = 0.1 * sign * np.where(v > 0.5, slant[0], -1.0 if shape == "parallelogram" else slant[1]) * inner
        return np.stack([6.0 * u + shift, 0.2 * (v - 0.5), 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(1e7, 0.3, 0.1))
    tip = node[-1, [0, -1]]
    if direction == "x":
        load = force(shells, int(tip[1]), "w", 2.5) + force(shells, int(tip[0]), "w", -2.5)  # a couple of 0.5
    else:
        load = np.sum([force(shells, int(k), direction, 0.5) for k in tip], axis=0)
    moved = solved(shells, [hold(node[0], "uvwxyz")], load)
    exact = {"u": 3e-5, "v": 0.1081, "w": 0.4321, "x": 0.03208 * 0.5}[direction]
    if direction == "x":
        return float((moved[tip[1], 2] - moved[tip[0], 2]) / 0.2 / exact)
    return float(moved[tip, "uvw".index(direction)].mean() / exact)


def curved_beam(direction: str, n: int = 6, n_across: int = 1) -> float:
    """Quarter ring 4.12 to 4.32, 0.1 thick, under a unit tip force: "u" in-plane over 0.08734, "w" over 0.5022."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        radius, angle = 4.12 + 0.2 * v, 0.5 * np.pi * (1.0 - u)
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(1e7, 0.25, 0.1))
    load = np.sum([force(shells, int(k), direction, 0.5) for k in node[-1, [0, -1]]], axis=0)
    moved = solved(shells, [hold(node[0], "uvwxyz")], load)
    exact = {"u": 0.08734, "w": 0.5022}[direction]
    return float(moved[node[-1], "uvw".index(direction)].mean() / exact)


def twisted_beam(thickness: float, direction: str, n: int = 12, n_across: int = 2) -> float:
    """Strip 12 x 1.1 twisted by 90 degrees under a unit tip force: "v" or "w" over the published deflection."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        angle, across = 0.5 * np.pi * u, 1.1 * (v - 0.5)
        return np.stack([12.0 * u, across * np.cos(angle), across * np.sin(angle)], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(29e6, 0.22, thickness))
    exact = {(0.32, "v"): 1.754e-3, (0.32, "w"): 5.424e-3, (0.0032, "v"): 1296.0, (0.0032, "w"): 5256.0}
    return _tip(shells, node, direction) / exact[thickness, direction]


def raasch_hook(n: int = 36, n_across: int = 5) -> float:
    """Strip of two arcs, radii 14 and 46, 20 wide, under a unit shear force across its end: over 5.02."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        first, second = 14.0 * np.pi / 3.0, 46.0 * np.radians(150.0)
        along = u * (first + second)
        one, other = along / 14.0, np.pi / 3.0 + np.pi - (along - first) / 46.0
        middle = 60.0 * np.array([np.sin(np.pi / 3.0), np.cos(np.pi / 3.0)])
        x = np.where(along < first, 14.0 * np.sin(one), middle[0] + 46.0 * np.sin(other))
        y = np.where(along < first, 14.0 * np.cos(one), middle[1] + 46.0 * np.cos(other))
        return np.stack([x, y, 20.0 * v], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(3300.0, 0.35, 2.0))
    return _tip(shells, node, "w") / 5.02


RandomShape = Callable[[int, np.random.Generator | None], tuple[float, Quality]]


def random_shape(rng: np.random.Generator) -> RandomShape:
    """Return a curved panel clamped at one end under a tip force or its weight: its work on n x n, and the estimate.

    It is arched and twisted, rises like a saddle, tapers and is swept, is from 1 to 6 times as long as wide and from 20
    to 500 times as thick. With a generator its inner nodes are moved along the surface by up to a fifth of an element.
    """
    length, arch, twist, rise = rng.uniform([1.0, 0.0, 0.0, 0.0], [6.0, 0.3, 0.7, 0.2])
    sweep, taper, thickness = rng.uniform(0.0, 0.7), rng.uniform(0.4, 1.0), 1.0 / rng.uniform(20.0, 500.0)
    by_weight = bool(rng.integers(2))

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        width, angle = 1.0 - (1.0 - taper) * u, twist * u
        across, up = width * (v - 0.5), arch * (1.0 - 4.0 * (v - 0.5) ** 2) + rise * u * (v - 0.5)
        y, z = across * np.cos(angle) - up * np.sin(angle), across * np.sin(angle) + up * np.cos(angle)
        return np.stack([length * u + sweep * across, y, z], axis=-1)

    def work(n: int, moved: np.random.Generator | None) -> tuple[float, Quality]:
        shift = np.zeros((2, n + 1, n + 1))
        if moved is not None:
            shift[:, 1:-1, 1:-1] = moved.uniform(-0.2 / n, 0.2 / n, (2, n - 1, n - 1))
        shells, node = mapped(
            lambda u, v: place(u + shift[0], v + shift[1]), n, n, isotropic_plate(7e10, 0.3, thickness)
        )
        if by_weight:
            load = surface_load(shells.mesh, np.tile([0.0, 0.0, -100.0], (shells.mesh.n_elements, 1)))
        else:
            load = line_load(shells.mesh, node[-1], np.array([0.0, 0.0, 1.0]))
        found = solved(shells, [hold(node[0], "uvwxyz")], load).ravel()
        return float(load @ found), solution_quality(shells, found)

    return work


def _tip(shells: Shells, node: IntArray, direction: str) -> float:
    """Return the mean deflection of the last row of nodes under a unit force spread over it, the first row clamped."""
    shares = np.ones(node.shape[1])
    shares[[0, -1]] = 0.5
    shares /= shares.sum()
    load = np.sum([f * force(shells, int(k), direction, 1.0) for k, f in zip(node[-1], shares, strict=True)], axis=0)
    moved = solved(shells, [hold(node[0], "uvwxyz")], load)
    return float(shares @ moved[node[-1], "uvw".index(direction)])


CONVERGING: dict[str, Callable[[int], float]] = {
    "Scordelis-Lo roof": scordelis_lo_roof,
    "the same on a slanted mesh": lambda n: scordelis_lo_roof(n, 0.3),
    "pinched cylinder": pinched_cylinder,
    "pinched hemisphere": pinched_hemisphere,
    "Morley skew plate": morley_skew_plate,
    "Cook's membrane": cook_membrane,
    "square plate, simply supported": lambda n: square_plate(n, False),
    "square plate, clamped": lambda n: square_plate(n, True),
}
