"""Problems whose quadrilaterals are warped, each solved to what warp costs it by the elements' corotation.

Corotation takes an element's rigid motion out before it strains, so the same mesh with the stiffness P' K P (P the
projection of `femlib.elements.corotational`) is the reference: the loss is that of warp alone.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.oracles import shell_problems
from benchmarks.oracles.shell_problems import force, hold, mapped
from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Quality, Shells, Supports, assemble, factorise, solution_quality, surface_load
from femlib.elements import corotational
from femlib.material import isotropic_plate
from femlib.mesh import DOFS_PER_NODE, Mesh, QualityLimits

LIFTED = QualityLimits(aspect=1e4, warp=1.0, warp_loss=float("inf"))


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """A problem and its solution."""

    shells: Shells
    supports: Supports
    load: FloatArray
    moved: FloatArray

    @classmethod
    def of(cls, shells: Shells, held: IntArray, load: FloatArray) -> "Solved":
        """Solve it."""
        supports = Supports.holding(shells.mesh, held)
        factors = factorise(supports.reduce(shells.stiffness()), supports.groups)
        return cls(shells, supports, load, supports.expand(factors.solve(load[supports.free])))

    def loss(self) -> float:
        """Return the share of load' u that warp costs."""
        points = self.shells.mesh.nodes[self.shells.mesh.quads]
        still, alone = np.zeros_like(points), np.broadcast_to(np.eye(3), (*points.shape[:2], 3, 3))
        motion = corotational.motion(points, still, alone)
        matrices = corotational.tangent(motion, self.shells.element_stiffness[0], np.zeros((len(points), 24)))
        stiffness = self.supports.reduce(assemble(self.shells.mesh, matrices, np.zeros((0, 18, 18))))
        right = self.load[self.supports.free]
        moved = self.supports.expand(factorise(stiffness, self.supports.groups).solve(right))
        return 1.0 - float(self.load @ self.moved) / float(self.load @ moved)

    def quality(self) -> Quality:
        """Return the estimate."""
        return solution_quality(self.shells, self.moved)


def twisted_strip(
    n: int, n_across: int, thickness: float, direction: str, twist: float = 90.0, limits: QualityLimits = LIFTED
) -> Solved:
    """MacNeal and Harder's twisted beam, 12 x 1.1, under a unit tip force along "v" or "w"."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        angle, across = np.radians(twist) * u, 1.1 * (v - 0.5)
        return np.stack([12.0 * u, across * np.cos(angle), across * np.sin(angle)], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(29e6, 0.22, thickness), limits)
    return Solved.of(shells, hold(node[0], "uvwxyz"), force(shells, int(node[-1, n_across // 2]), direction, 1.0))


def slanted_roof(n: int, slant: float) -> Solved:
    """The Scordelis-Lo roof with mesh lines that lean across it by `slant` of its width in its middle."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        angle = np.radians(40.0) * (u + slant * np.sin(np.pi * u) * (v - 0.5))
        return np.stack([25.0 * np.sin(angle), 25.0 * v, 25.0 * np.cos(angle)], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(4.32e8, 0.0, 0.25), LIFTED)
    held = np.concatenate([hold(node[:, -1], "uw"), hold(node[:, 0], "vxz"), hold(node[0], "uyz")])
    weight = np.tile([0.0, 0.0, -90.0], (shells.mesh.n_elements, 1))
    return Solved.of(shells, held, surface_load(shells.mesh, weight))


def saddle(n: int, rise: float, thickness: float) -> Solved:
    """A hyperbolic paraboloid z = rise x y on the unit square, held along its edge, under its weight."""
    shells, node = mapped(
        lambda u, v: np.stack([u, v, rise * u * v], axis=-1), n, n, isotropic_plate(7e10, 0.3, thickness), LIFTED
    )
    edge = np.unique(np.concatenate([node[0], node[-1], node[:, 0], node[:, -1]]))
    weight = np.tile([0.0, 0.0, -100.0], (shells.mesh.n_elements, 1))
    return Solved.of(shells, hold(edge, "uvw"), surface_load(shells.mesh, weight))


def twisted_tube(n: int, n_around: int, thickness: float, twist: float, limits: QualityLimits = LIFTED) -> Solved:
    """A tube of elliptic section, 4 m long, 0.6 x 0.2 m, twisted as a wing is, under a tip force."""
    u, v = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n_around, endpoint=False), indexing="ij")
    angle, y, z = np.radians(twist) * u, 0.3 * np.cos(2 * np.pi * v), 0.1 * np.sin(2 * np.pi * v)
    nodes = np.stack(
        [4.0 * u, y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)], axis=-1
    ).reshape(-1, 3)
    number = np.arange(u.size).reshape(u.shape)
    beside = np.roll(number, -1, axis=1)
    quads = np.stack([number[:-1], number[1:], beside[1:], beside[:-1]], axis=-1).reshape(-1, 4)
    zeros = np.zeros(len(quads), dtype=np.int64)
    mesh = Mesh(nodes, quads, np.zeros((0, 3), dtype=np.int64), ("tube",), zeros, limits)
    shells = Shells(mesh, (isotropic_plate(7e10, 0.3, thickness),), zeros, np.ones(len(quads)), np.zeros(3))
    load = np.zeros((len(nodes), DOFS_PER_NODE))
    load[number[-1], 2] = 100.0 / n_around
    return Solved.of(shells, hold(number[0], "uvwxyz"), load.ravel())


CALIBRATED = {
    f"strip twisted by {twist} degrees, t {t:g}, {n} x {m}, {way}": (twist, t, n, m, way)
    for twist, t in ((90, 0.32), (90, 0.0032), (22.5, 0.32), (22.5, 0.032), (22.5, 0.0032))
    for n, m in ((24, 2), (96, 12))
    for way in "vw"
}


def main() -> None:
    """Print the tables of docs/wing.md."""
    for name, (twist, t, n, m, way) in CALIBRATED.items():
        _print(name, twisted_strip(n, m, t, way, twist))
    for n, slant in ((8, 0.1), (8, 0.3), (16, 0.1), (16, 0.3), (32, 0.3)):
        _print(f"Scordelis-Lo roof, lines slanted by {slant:g}, {n} x {n}", slanted_roof(n, slant))
    for n, rise, t in ((8, 0.05, 0.002), (24, 0.05, 0.002), (8, 0.2, 0.01), (24, 0.2, 0.01)):
        _print(f"saddle, rise {rise:g}, t {t:g}, {n} x {n}", saddle(n, rise, t))
    for n, m, t, twist in ((20, 16, 0.001, 3.0), (20, 16, 0.001, 10.0), (40, 32, 0.004, 10.0)):
        _print(f"tube twisted by {twist:g} degrees, t {t:g}, {n} x {m}", twisted_tube(n, m, t, twist))
    for name, ratio, quality in _judged():
        total = quality.displacement_error
        print(f"| {name} | {1.0 - ratio:.4f} | {total:.4f} | {'refused' if total > 0.03 else 'accepted'} |")


def _print(name: str, solved: Solved) -> None:
    error = solved.quality().warp_error
    print(f"| {name} | {solved.loss():.4f} | {error:.4f} | {'refused' if error > 0.03 else 'accepted'} |", flush=True)


def _judged() -> Iterator[tuple[str, float, Quality]]:
    """Yield the standard problems' ratios and estimates."""
    found: list[Quality] = []
    plain = shell_problems.solved

    def solved(shells: Shells, held: list[IntArray], load: FloatArray) -> FloatArray:
        moved = plain(shells, held, load)
        found.append(solution_quality(shells, moved.ravel()))
        return moved

    shell_problems.solved = solved
    for name, problem in shell_problems.CONVERGING.items():
        for n in (4, 8, 16, 32):
            yield f"{name}, {n}", problem(n), found[-1]
    for shape in shell_problems.BEAM_SHAPES:
        for direction in "uvwx":
            yield (
                f"straight beam, {shape}, {direction}",
                shell_problems.straight_beam(shape, direction),
                found[-1],
            )
    for direction in "uw":
        for n, m in ((6, 1), (24, 1), (24, 4)):
            yield f"curved beam, {direction}, {n} x {m}", shell_problems.curved_beam(direction, n, m), found[-1]


if __name__ == "__main__":
    main()
