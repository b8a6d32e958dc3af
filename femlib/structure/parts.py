"""From a named mesh and a section for each element set to shells, beams, springs and masses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.spatial import cKDTree

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly.built_up import Beams, BuiltUp, Springs
from femlib.components import Component
from femlib.elements.beam2 import BeamSection
from femlib.errors import InputError, frozen_floats, is_number
from femlib.material import Laminate
from femlib.mesh import DOFS_PER_NODE, Mesh
from femlib.structure.named_mesh import NamedMesh, listed

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
"""Translations along and rotations about the global axes."""
HELD = {"clamped": DIRECTIONS, "pinned": DIRECTIONS[:3]}
"""Words for several of them."""

Section = Laminate | BeamSection
Kind = TypeVar("Kind", Laminate, BeamSection)
SLENDEREST = 5000.0
"""Length of the middle element over the thinnest shell's thickness, and beyond HUGE, where lengths are in two units."""
APART = 1e-3
"""Distance of two nodes over the shortest side, below which they lie at one place."""
MOST_CARRIED = 150_000_000
"""Degrees of freedom of a damage region times those at its border: a dense matrix of 1.2 GB."""
HUGE = 100.0
"""Size of a mesh [m] from which it is asked whether it is in millimetres."""


@dataclass(frozen=True, slots=True, eq=False)
class Spring:
    """A spring from each node of a set to the ground, or between two nodes.

    Attributes
    ----------
    name : str
        Name, as in a damage state.
    nodes : str
        A node set; one node where `to` is given.
    stiffness : float or sequence of float
        Along the line between two nodes apart [N/m]; else six along and about the global axes [N/m, N m/rad].
    to : str, optional
        The other node's set; the ground if not given.

    Examples
    --------
    >>> Spring("soil", nodes="foot", stiffness=[1e6, 1e6, 5e6, 0.0, 0.0, 0.0]).to is None
    True
    """

    name: str
    nodes: str
    stiffness: float | Sequence[float]
    to: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """What a structure is made of.

    Attributes
    ----------
    built : BuiltUp
        Shells, beams, springs, point masses.
    line_of_beam : IntArray
        Line of the named mesh that each beam is (n_beams,).
    spring_names : tuple of str
        Name of each spring, in their order.
    """

    built: BuiltUp
    line_of_beam: IntArray
    spring_names: tuple[str, ...]

    def of_elements(self, elements: BoolArray) -> BoolArray:
        """Return which parts (n_parts,) are among elements (n_elements,) of the named mesh."""
        n_shells = self.built.mesh.n_elements
        beams = elements[n_shells:][self.line_of_beam]
        return np.concatenate([elements[:n_shells], beams, np.zeros(len(self.spring_names), dtype=bool)])

    def of_spring(self, name: str) -> BoolArray:
        """Return which parts (n_parts,) are the springs of a name."""
        springs = np.array([own == name for own in self.spring_names], dtype=bool)
        return np.concatenate([np.zeros(self.built.n_elements - len(springs), dtype=bool), springs])


def parts_of(
    mesh: NamedMesh,
    sections: Mapping[str, Section],
    masses: Mapping[str, float],
    springs: Sequence[Spring],
    axis: FloatArray,
) -> Parts:
    """Return the parts of a structure; arguments as those of `Structure`.

    Raises
    ------
    InputError
        If a shell has no section or two, a section is of the wrong kind for its set, a line hangs free, a mass or a
        spring is none, or lengths are in two units.
    """
    kinds = tuple(sections.values())
    owner = _owners(mesh, sections)
    _check_units(mesh, [kind for kind in kinds if isinstance(kind, Laminate)])
    line_of_beam = np.flatnonzero(owner[mesh.n_shells :] >= 0)
    laminates, section = _chosen(kinds, owner[: mesh.n_shells], Laminate)
    beam_sections, beam_section = _chosen(kinds, owner[mesh.n_shells :][line_of_beam], BeamSection)
    names, joined = _springs(mesh, springs)
    built = BuiltUp(
        mesh=_shell_mesh(mesh),
        laminates=laminates,
        section=section,
        scale=np.ones(mesh.n_shells),
        axis=axis,
        beams=Beams(mesh.lines[line_of_beam], beam_sections, beam_section),
        springs=joined,
        point_masses=_masses(mesh, masses),
    )
    _check_lines(mesh, built)
    _check_merged(mesh, built)
    return Parts(built, line_of_beam, names)


def _owners(mesh: NamedMesh, sections: Mapping[str, Section]) -> IntArray:
    """Return the number of each element's section (n_elements,), -1 for lines that have none."""
    owner = np.full(mesh.n_elements, -1)
    names = list(sections)
    is_shell = np.arange(mesh.n_elements) < mesh.n_shells
    for number, (name, kind) in enumerate(sections.items()):
        if not isinstance(kind, Laminate | BeamSection):
            raise InputError(
                f"section of {name!r} is a {type(kind).__name__}; expected a Laminate or a BeamSection; make it with "
                "isotropic_plate, laminate or rectangular_beam"
            )
        members = mesh.elements_of(name)
        fits = members & (is_shell if isinstance(kind, Laminate) else ~is_shell)
        if not fits.any():
            got, wanted = ("lines", "shells") if isinstance(kind, Laminate) else ("shells", "lines")
            raise InputError(
                f"section of {name!r} is a {type(kind).__name__} but the set holds {got} alone; expected {wanted}; "
                "name another set or give it the other kind of section"
            )
        twice = np.flatnonzero(fits & (owner >= 0))
        if twice.size:
            raise InputError(
                f"element {twice[0]} is in {names[owner[twice[0]]]!r} and in {name!r}, which both have a section; "
                "expected one for each element; take one of them out"
            )
        owner[fits] = number
    bare = np.flatnonzero((owner < 0) & is_shell)
    if bare.size:
        own = [name for name, members in mesh.element_sets.items() if members[bare[0]]]
        raise InputError(
            f"{bare.size} shells have no section, the first is element {bare[0]} of the sets {listed(own)}; expected "
            f"a laminate for each, got sections for {names}; add one"
        )
    return owner


def _chosen(kinds: Sequence[Section], owner: IntArray, wanted: type[Kind]) -> tuple[tuple[Kind, ...], IntArray]:
    """Return the sections of one kind and each element's index among them."""
    of_kind = {k: kind for k, kind in enumerate(kinds) if isinstance(kind, wanted)}
    return tuple(of_kind.values()), np.searchsorted(list(of_kind), owner)


def _shell_mesh(mesh: NamedMesh) -> Mesh:
    """Return the shells, a patch for each combination of element sets, across whose borders strains may jump."""
    if not mesh.n_shells:
        raise InputError("the mesh has no shell; expected at least one, lines alone are no structure of this program")
    sets = {name: members[: mesh.n_shells] for name, members in mesh.element_sets.items()}
    cutting = {name: members for name, members in sets.items() if members.any() and not members.all()}
    table = np.array([*cutting.values(), np.zeros(mesh.n_shells, dtype=bool)]).T
    _, first, patch = np.unique(np.packbits(table, axis=1), axis=0, return_index=True, return_inverse=True)
    names = tuple("+".join(n for n, in_it in zip(cutting, table[k], strict=False) if in_it) or "rest" for k in first)
    return Mesh(mesh.nodes, mesh.quads, mesh.trias, names, patch.ravel())


def _masses(mesh: NamedMesh, masses: Mapping[str, float]) -> FloatArray:
    """Return the mass at each node (n_nodes,), each set's shared by its nodes."""
    at_nodes = np.zeros(len(mesh.nodes))
    for name, mass in masses.items():
        if not is_number(mass) or mass < 0.0:
            raise InputError(f"mass at {name!r} is {mass!r} kg; expected 0 or more; correct it")
        nodes = mesh.nodes_of(name)
        at_nodes[nodes] += mass / len(nodes)
    return at_nodes


def _springs(mesh: NamedMesh, springs: Sequence[Spring]) -> tuple[tuple[str, ...], Springs]:
    names: list[str] = []
    ends: list[tuple[int, int]] = []
    stiffness: list[FloatArray] = []
    for spring in springs:
        own = _spring_ends(mesh, spring)
        is_apart = own[0][1] >= 0 and bool((mesh.nodes[own[0][0]] != mesh.nodes[own[0][1]]).any())
        if is_apart != is_number(spring.stiffness):
            expected = "one number along the line" if is_apart else "six, along and about the axes"
            raise InputError(
                f"spring {spring.name!r} has the stiffness {spring.stiffness!r}; expected {expected}; correct it"
            )
        six = np.zeros(DOFS_PER_NODE)
        six[: 1 if is_apart else DOFS_PER_NODE] = frozen_floats(
            np.atleast_1d(spring.stiffness), f"spring {spring.name!r} stiffness", (1 if is_apart else DOFS_PER_NODE,)
        )
        names += [spring.name] * len(own)
        ends += own
        stiffness += [six] * len(own)
    if not ends:
        return (), Springs.none()
    return tuple(names), Springs(np.array(ends), np.array(stiffness))


def _spring_ends(mesh: NamedMesh, spring: Spring) -> list[tuple[int, int]]:
    first = mesh.nodes_of(spring.nodes)
    if spring.to is None:
        return [(int(node), -1) for node in first]
    second = mesh.nodes_of(spring.to)
    if len(first) != 1 or len(second) != 1 or first[0] == second[0]:
        raise InputError(
            f"spring {spring.name!r} joins {len(first)} and {len(second)} nodes; expected one and another; name "
            "sets of one node"
        )
    return [(int(first[0]), int(second[0]))]


def _check_lines(mesh: NamedMesh, built: BuiltUp) -> None:
    """Refuse a line without a section that ends where nothing else is: it was meant as a beam."""
    held = np.zeros(len(mesh.nodes), dtype=bool)
    for corners in (mesh.quads, mesh.trias, built.links):
        held[corners.ravel()] = True
    free = np.flatnonzero(~held[mesh.lines].all(axis=1))
    if free.size:
        own = [name for name, members in mesh.element_sets.items() if members[mesh.n_shells + free[0]]]
        raise InputError(
            f"{free.size} lines end at nodes of no shell and have no section, the first is of the sets {listed(own)}; "
            "expected a BeamSection for them; add one, or take them out of the mesh"
        )


def _check_merged(mesh: NamedMesh, built: BuiltUp) -> None:
    """Refuse two nodes at one place that no spring joins: the mesh is open there."""
    sides = [
        np.linalg.norm(np.roll(p, -1, axis=1) - p, axis=2) for p in (mesh.nodes[mesh.quads], mesh.nodes[mesh.trias])
    ]
    shortest = min(float(own.min()) for own in sides if own.size)
    pairs = cKDTree(mesh.nodes).query_pairs(APART * shortest, output_type="ndarray")
    joined = np.sort(built.links, axis=1) @ [len(mesh.nodes), 1]
    pairs = np.sort(pairs, axis=1)
    open_pairs = pairs[~np.isin(pairs @ [len(mesh.nodes), 1], joined)]
    if len(open_pairs):
        first, second = open_pairs[np.lexsort(open_pairs.T[::-1])[0]].tolist()
        raise InputError(
            f"nodes {first} and {second} lie at one place, {mesh.nodes[first].round(6).tolist()} m, and are not joined "
            f"({len(open_pairs)} pairs); expected one node there; merge them in the mesh program, or put "
            "springs between them"
        )


def _check_units(mesh: NamedMesh, laminates: Sequence[Laminate]) -> None:
    size = float(np.linalg.norm(np.ptp(mesh.nodes, axis=0)))
    if not laminates or size < HUGE or not mesh.n_shells:
        return
    sides = [np.linalg.norm(mesh.nodes[c[:, 1]] - mesh.nodes[c[:, 0]], axis=1) for c in (mesh.quads, mesh.trias)]
    length, thinnest = float(np.median(np.concatenate(sides))), min(own.thickness for own in laminates)
    if length > SLENDEREST * thinnest:
        raise InputError(
            f"the mesh is {size:.4g} m across with elements of {length:.3g} m on shells {thinnest:.3g} m thick; "
            f"expected at most {SLENDEREST:g} thicknesses; if the mesh is in millimetres, read(..., unit='mm')"
        )


def component_of(mesh: NamedMesh, parts: Parts, name: str) -> Component:
    """Return the damage region of an element set or of the springs of a name."""
    if name in parts.spring_names:
        return Component(name, name, parts.of_spring(name))
    if name not in mesh.element_sets and parts.spring_names:
        names = [*mesh.element_sets, *parts.spring_names]
        raise InputError(
            f"damage is on {name!r}; expected an element set or a spring, one of {listed(names)}; correct it"
        )
    own = parts.of_elements(mesh.elements_of(name))
    if not own.any():
        raise InputError(
            f"damage is on {name!r}, whose lines have no section and so no stiffness; expected shells or beams; give "
            "it a BeamSection or name another"
        )
    inside, outside = parts.built.touched(own), parts.built.touched(~own)
    n_dofs, n_ports = int(inside.sum()), int((inside & outside).sum())
    if n_dofs * n_ports > MOST_CARRIED:
        raise InputError(
            f"damage region {name!r} has {n_dofs} degrees of freedom and {n_ports} at its border, held as one dense "
            f"matrix; expected at most {MOST_CARRIED:g} numbers in it; divide it into several sets"
        )
    return Component(name, name, own)


def held_dofs(mesh: NamedMesh, supports: Mapping[str, str]) -> IntArray:
    """Return the degrees of freedom that are held."""
    held = [np.zeros(0, dtype=np.int64)]
    for name, words in supports.items():
        nodes = mesh.nodes_of(name)
        own = words.split() if isinstance(words, str) else []
        every = [direction for word in own for direction in HELD.get(word, (word,))]
        if not every or not set(every) <= set(DIRECTIONS):
            raise InputError(
                f"support of {name!r} is {words!r}; expected 'clamped', 'pinned' or some of {' '.join(DIRECTIONS)}; "
                "correct it"
            )
        axes = np.array([DIRECTIONS.index(direction) for direction in every])
        held.append((DOFS_PER_NODE * nodes[:, None] + axes).ravel())
    return np.unique(np.concatenate(held))
