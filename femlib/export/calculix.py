"""Any shells as a CalculiX deck: quadratic shells (S8R, S6) on the same corners.

They have nodes added at the edges' middles, so that the deck is another discretisation, not the same
elements again. A middle is held where both ends of its edge are; nodal loads stay at the corners. Laminates go out as
their plies (`Laminate.plies`): an isotropic ply by modulus and Poisson's ratio, an orthotropic one with an orientation
of its own for each direction that its elements have; what the plies leave open is E_3 = E_2, nu_13 = nu_23 = nu_12.

CalculiX 2.20 leaves out the buckling factors below a half of the load that its deck has, so a deck of buckling has the
load times a factor that brings it a little below the lowest buckling load of the same shells here. A comment says that
factor, and `calculix_results.read_buckling_factors` takes it off again.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly import Shells, Supports, buckling_modes
from femlib.errors import InputError, frozen_floats, frozen_ints, is_number, is_whole
from femlib.export.calculix_sections import sections
from femlib.files import whole_file
from femlib.mesh import DOFS_PER_NODE, Mesh, shell_sides
from femlib.sensors import StrainGauge, element_weights

Analysis = Literal["linear", "large deflection", "frequencies", "buckling"]
OBLIQUE = 0.87
"""Cosine beyond which an axis counts as the normal."""
KINDS = ("S8R", "S6")
"""CalculiX's names of quadratic quadrilaterals and triangles."""
ANY = 1e9
"""Estimated error of the factor that scales a load, at most: half or twice the load would do."""
BELOW = 0.9
"""Load of a buckling deck over the one at which the same shells buckle here."""
SCALED = "** femlib: buckling load times"
"""What the comment on a buckling deck's load begins with."""


@dataclass(frozen=True, slots=True, eq=False)
class Deck:
    """What a deck says.

    Attributes
    ----------
    shells : Shells
        Mesh, laminates with their plies, factors on the stiffness.
    supports : Supports
        What is held.
    load : FloatArray
        Nodal forces and moments (n_dofs,) [N, N m].
    factor : FloatArray, optional
        Factor on each element's stiffness (n_elements,) besides that of the shells, for damage.
    temperature : tuple of float
        Warming of all nodes [K] and its growth toward each shell's top side [K/m].
    expansion_factor : FloatArray, optional
        Factor on each element's thermal expansion (n_elements,), for warming by element.
    analysis : str
        "linear", "large deflection", "frequencies" or "buckling".
    n_modes : int
        Frequencies or buckling factors wanted.
    printed : IntArray, optional
        Elements whose strains at the integration points are printed, in global axes.

    Raises
    ------
    InputError
        If an array has the wrong shape, the analysis has no such name, or shells that shall buckle are one element
        wide: CalculiX has factors near 1 there that are no answer.
    """

    shells: Shells
    supports: Supports
    load: FloatArray
    factor: FloatArray | None = None
    temperature: tuple[float, float] = (0.0, 0.0)
    expansion_factor: FloatArray | None = None
    analysis: Analysis = "linear"
    n_modes: int = 4
    printed: IntArray | None = None

    def __post_init__(self) -> None:
        mesh = self.shells.mesh
        object.__setattr__(self, "load", frozen_floats(self.load, "load", (mesh.n_dofs,)))
        for name in ("factor", "expansion_factor"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen_floats(getattr(self, name), name, (mesh.n_elements,)))
        self._check()

    def _check(self) -> None:
        if self.analysis not in Analysis.__args__:  # type: ignore[attr-defined]
            raise InputError(f"analysis is {self.analysis!r}; expected one of {list(Analysis.__args__)}; correct it")  # type: ignore[attr-defined]
        if self.supports.n_dofs != self.shells.mesh.n_dofs:
            raise InputError(
                f"supports have {self.supports.n_dofs} degrees of freedom; expected the mesh's "
                f"{self.shells.mesh.n_dofs}; hold the same mesh"
            )
        if not is_whole(self.n_modes) or self.n_modes < 1:
            raise InputError(f"n_modes is {self.n_modes!r}; expected a whole number from 1; correct it")
        if len(self.temperature) != 2 or not all(is_number(value) for value in self.temperature):
            raise InputError(f"temperature is {self.temperature!r}; expected [K] and [K/m]; give two numbers")
        if self.printed is not None:
            frozen_ints(self.printed, "printed elements", (-1,))
        if self.analysis == "buckling":
            self._check_buckling()

    def _check_buckling(self) -> None:
        if any(self.temperature):
            raise InputError(
                f"temperature is {self.temperature!r} in a buckling analysis; expected 0, as CalculiX has none there; "
                "leave it out"
            )
        n_others = self.shells.n_elements - self.shells.mesh.n_elements
        if n_others:
            raise InputError(
                f"a buckling deck has {n_others} beams and springs; expected shells alone, whose lowest factor "
                "scales the load, as CalculiX leaves out what lies far below it; make the beams of shells"
            )
        _check_wide(self.shells.mesh)

    def lines(self) -> list[str]:
        """Return the deck line by line."""
        shells, n = self.shells, self.shells.mesh.n_elements
        factor = shells.scale if self.factor is None else shells.scale * self.factor
        warm = np.ones(n) if self.expansion_factor is None else self.expansion_factor
        return [*self._geometry(), *sections(shells, factor, warm), *self._step()]

    def _geometry(self) -> list[str]:
        mesh = self.shells.mesh
        ends, quads, trias = edges(mesh)
        nodes = np.concatenate([mesh.nodes, mesh.nodes[ends].mean(axis=1)])
        lines = ["** femlib; SI units (N, m, kg, K)", "*NODE, NSET=ALL"]
        lines += [f"{k + 1}, {x:.11e}, {y:.11e}, {z:.11e}" for k, (x, y, z) in enumerate(nodes)]
        first = 1
        for kind, corners, middle in zip(KINDS, (mesh.quads, mesh.trias), (quads, trias), strict=True):
            joined = np.concatenate([corners, len(mesh.nodes) + middle], axis=1)
            lines += _rows(f"*ELEMENT, TYPE={kind}", first, joined + 1)
            first += len(joined)
        lines += [*_listed("*NSET, NSET=CORNERS", np.arange(len(mesh.nodes))), *self._held(ends)]
        return lines + ([] if self.printed is None else _listed("*ELSET, ELSET=PRINTED", self.printed))

    def _held(self, ends: IntArray) -> list[str]:
        held = np.ones(self.supports.n_dofs, dtype=bool)
        held[self.supports.free] = False
        at_nodes, normals = held.reshape(-1, DOFS_PER_NODE), _normals(self.shells.mesh)
        at_nodes = np.concatenate([at_nodes, at_nodes[ends].all(axis=1)])
        normals = np.concatenate([normals, normals[ends].sum(axis=1)])
        at_nodes = np.column_stack([at_nodes[:, :3], _without_drilling(at_nodes[:, 3:], normals)])
        return ["*BOUNDARY", *(f"{node + 1}, {axis + 1}, {axis + 1}" for node, axis in np.argwhere(at_nodes))]

    def _buckling_scale(self) -> float:
        """Return the factor on the load that brings it to `BELOW` of the lowest buckling load of the same shells."""
        modes = buckling_modes(self.shells, self.supports, self.load, 1, self.factor, limit=ANY, is_refined=False)
        if not modes:
            raise InputError(
                "the load of a buckling deck buckles nothing at any factor; expected one that pushes; turn it"
            )
        return BELOW * modes[0].factor

    def _step(self) -> list[str]:
        if self.analysis == "frequencies":
            return ["*STEP", "*FREQUENCY", f"{self.n_modes}", "*END STEP"]
        is_warm = self.analysis != "buckling"
        lines = ["*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, 0."] if is_warm else []
        lines += ["*STEP" + (", NLGEOM" if self.analysis == "large deflection" else "")]
        lines += ["*BUCKLE", f"{self.n_modes}"] if self.analysis == "buckling" else ["*STATIC"]
        if self.analysis == "large deflection":
            lines.append("1., 1.")  # the whole load at once: CalculiX halves it by itself where it must
        lines += ["*TEMPERATURE", "ALL, {}, {}".format(*self.temperature)] if is_warm else []
        forces = self.load.reshape(-1, DOFS_PER_NODE)
        if self.analysis == "buckling":
            scale = float(f"{self._buckling_scale():.9e}")
            forces = scale * forces
            lines.append(f"{SCALED} {scale:.9e}")
        lines.append("*CLOAD")
        lines += [f"{n + 1}, {axis + 1}, {forces[n, axis]:.9e}" for n, axis in np.argwhere(forces != 0.0)]
        printed = [] if self.printed is None else ["*EL PRINT, ELSET=PRINTED, GLOBAL=YES", "E"]
        return [*lines, *printed, "*NODE FILE, OUTPUT=2D", "U", "*END STEP"]


def write_deck(deck: Deck, path: str | Path, others: Sequence[str] = ()) -> None:
    """Write a deck, whole or not at all, with the lines `others` before its step.

    Raises
    ------
    InputError
        If the ending is not .inp, the folder cannot be written to, or a laminate does not say what its plies are.
    """
    target = Path(path)
    if target.suffix != ".inp":
        raise InputError(f"deck path {target} ends in {target.suffix!r}; expected .inp; rename it")
    lines = deck.lines()
    first = next(k for k, line in enumerate(lines) if line.startswith(("*INITIAL", "*STEP")))
    lines[first:first] = others
    with whole_file(target) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii")


def read_elements(mesh: Mesh, gauges: Sequence[StrainGauge]) -> IntArray:
    """Return the elements (n,) whose centre strains gauges average: those to print."""
    return np.array(sorted({element for weights in element_weights(mesh, gauges) for element in weights}))


def edges(mesh: Mesh) -> tuple[IntArray, IntArray, IntArray]:
    """Return the ends of all edges (n_edges, 2) and the edges of each element, (n_quads, 4) and (n_trias, 3)."""
    ends, place = np.unique(np.sort(shell_sides(mesh.quads, mesh.trias)[0], axis=1), axis=0, return_inverse=True)
    split = mesh.quads.size
    return ends, place.ravel()[:split].reshape(-1, 4), place.ravel()[split:].reshape(-1, 3)


def _check_wide(mesh: Mesh) -> None:
    """Refuse a quadrilateral of which two opposite edges belong to no other element."""
    _, quads, trias = edges(mesh)
    count = np.bincount(np.concatenate([quads.ravel(), trias.ravel()]))
    is_bare = count[quads] == 1
    narrow = np.flatnonzero((is_bare[:, :2] & is_bare[:, 2:]).any(axis=1))
    if narrow.size:
        raise InputError(
            f"a buckling deck has a strip one element wide at element {narrow[0]} ({narrow.size} such elements), where "
            "CalculiX's S8R buckles at factors near 1 that are no answer; expected two elements across; refine the mesh"
        )


def _normals(mesh: Mesh) -> FloatArray:
    """Return the mean normals of the elements at each node (n_nodes, 3), of any length."""
    normals, area = np.zeros_like(mesh.nodes), mesh.area_vectors()
    for corners, own in ((mesh.quads, area[: len(mesh.quads)]), (mesh.trias, area[len(mesh.quads) :])):
        for nodes in corners.T:
            np.add.at(normals, nodes, own)
    return normals


def _without_drilling(held: BoolArray, normals: FloatArray) -> BoolArray:
    """Return which rotations (n, 3) CalculiX is to hold of those that are held, with normals (n, 3) of any length.

    Its shells have no rotation about their normal: held together with another on a curved shell it stops both (a roof
    of Scordelis and Lo then has .13 of its deflection). Of two held rotations whose plane has the normal in it the one
    nearer the surface is left; three are a clamp and stay.
    """
    along = np.abs(normals) / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    count, kept = held.sum(axis=1), held.copy()
    kept[(count == 1) & (np.where(held, along, 0.0).max(axis=1) > OBLIQUE)] = False
    free = np.where(held, 0.0, along).max(axis=1)  # of two held rotations: the normal's part out of their plane
    oblique = np.flatnonzero((count == 2) & (free > 0.5) & (free < OBLIQUE))
    if oblique.size:
        raise InputError(
            f"node {oblique[0]} holds two rotations that are oblique to the shell there (normal "
            f"{np.round(along[oblique[0]], 2).tolist()}); expected a plane of symmetry, or all three held; turn the "
            "structure so that the plane is one of coordinates"
        )
    pair = (count == 2) & (free <= 0.5)
    worst = np.where(held, along, -1.0).argmax(axis=1)
    kept[pair, worst[pair]] = False
    return kept


def _rows(card: str, first: int, rows: IntArray) -> list[str]:
    """Return a card and numbered rows, nothing for none: CalculiX refuses an empty block."""
    numbered = [f"{first + k}, " + ", ".join(map(str, row)) for k, row in enumerate(rows)]
    return [card, *numbered] if numbered else []


def _listed(card: str, numbers: Sequence[int] | IntArray) -> list[str]:
    return [card, *(f"{number + 1}," for number in numbers)]
