"""A structure as a CalculiX deck: quadratic shells (S8R, S6) by `femlib.export`, with B32 beams, masses, springs.

A beam has a node at its middle, that of the shells' edge where it lies along one. CalculiX makes a solid of it, so its
section must be a rectangle on the nodes' line. Strains are read at the integration points of the elements that a gauge
averages, in global axes: shells with isotropic plies only. The structure's sets go out under their names, so that the
same structure can be made of the mesh that `read(deck, corners_only=True)` returns.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.errors import InputError
from femlib.export import calculix
from femlib.export.calculix import Analysis, Deck
from femlib.export.calculix_results import element_points
from femlib.files import whole_file
from femlib.sensors import StrainGauge, element_weights
from femlib.structure.model import MICRO, Structure

LAYERS = {8: (4, np.sqrt(1.0 / 3.0)), 9: (3, np.sqrt(0.6))}
"""By the number of integration points, 8 of S8R and 9 of S6: points a layer, the lowest first, and the height of the
outer layers over half the thickness."""
OWN_NAMES = re.compile(r"ALL|CORNERS|PRINTED|(E|BEAM|MASS|SPRING)\d+", re.IGNORECASE)
"""Names of the deck's own sets."""
SET_NAME = re.compile(r"[A-Za-z][!#-)+\-./0-9:;<>-~]{0,79}")
"""A name that CalculiX takes, in capitals or not: ASCII without blanks, commas, quotes, stars and equals signs."""


def write_deck(
    structure: Structure,
    path: str | Path,
    state: Mapping[str, float],
    load: FloatArray,
    gauges: Sequence[StrainGauge] = (),
    analysis: Analysis = "linear",
    n_modes: int = 4,
) -> None:
    """Write the deck of one state, whole or not at all.

    Raises
    ------
    InputError
        If state or load is bad, a beam is no rectangle on its nodes' line, a spring joins two nodes, stacked plies
        stand beside other parts, or the file cannot be written.
    """
    target = Path(path)
    if target.suffix != ".inp":
        raise InputError(f"deck path {target} ends in {target.suffix!r}; expected .inp; rename it")
    built, factor = structure.built, structure.stiffness_left(state)
    _check_stacks(structure)
    deck = Deck(
        shells=built,
        supports=structure.damaged.supports,
        load=load,
        factor=factor[: built.mesh.n_elements],
        analysis=analysis,
        n_modes=n_modes,
        printed=np.array(sorted({e for own in weights_of(structure, gauges) for e in own})) if gauges else None,
    )
    lines = deck.lines()
    first = next(k for k, line in enumerate(lines) if line.startswith(("*INITIAL", "*STEP")))
    lines[first:first] = [*_others(structure, factor), *_sets(structure)]
    # without it strains are in axes of each shell's own
    lines = [line + ", GLOBAL=YES" if line.startswith("*EL PRINT") else line for line in lines]
    with whole_file(target) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii")


def _check_stacks(structure: Structure) -> None:
    """Refuse stacked plies beside other parts, at which CalculiX 2.20 stops (element type unknown, gen3dnor)."""
    built = structure.built
    stacked = [number for number, own in enumerate(built.laminates) if len(own.plies) > 1]
    others = {"beams": len(built.beams.ends), "masses": np.count_nonzero(built.point_masses)}
    others |= {"springs": len(built.springs.ends)}
    if stacked and any(others.values()):
        told = " and ".join(f"{n} {name}" for name, n in others.items() if n)
        raise InputError(
            f"laminate {stacked[0]} is a stack of plies beside {told}, where CalculiX 2.20 stops; expected shells "
            "alone or of one ply; leave the others out or write an equivalent ply"
        )


def weights_of(structure: Structure, gauges: Sequence[StrainGauge]) -> list[dict[int, float]]:
    """Return for each gauge the elements whose centre strains it averages, and their weights."""
    return element_weights(structure.built.mesh, [structure.on_patches(gauge) for gauge in gauges])


def read_gauges(structure: Structure, path: str | Path, gauges: Sequence[StrainGauge]) -> FloatArray:
    """Return the gauge strains (n_gauges,) [microstrain, tension positive] of a deck's result (.dat).

    Raises
    ------
    InputError
        If the file is missing or lacks an element that a gauge reads.
    """
    points = element_points(path)
    mesh, strains = structure.built.mesh, []
    for gauge, weights in zip(gauges, weights_of(structure, gauges), strict=True):
        total = 0.0
        for element, weight in weights.items():
            n_points = 8 if element < len(mesh.quads) else 9
            if len(points.get(element, ())) != n_points:
                raise InputError(
                    f"{path} has {len(points.get(element, ()))} strains of element {element + 1}, which gauge "
                    f"{gauge.name} reads; expected {n_points}; run the deck of these gauges"
                )
            normal = mesh.area_vectors()[element]
            along = gauge.direction - normal * (gauge.direction @ normal) / (normal @ normal)
            along = along / np.linalg.norm(along)
            values = np.einsum("i,pij,j->p", along, tensors(np.array(points[element])), along)
            n_layer, height = LAYERS[n_points]
            low, high = values[:n_layer].mean(), values[-n_layer:].mean()
            total += weight * float((low + high) / 2.0 + gauge.side / height * (high - low) / 2.0)
        strains.append(total)
    return MICRO * np.array(strains)


def tensors(rows: FloatArray) -> FloatArray:
    """Return strains (n, 3, 3) of rows (xx, yy, zz, xy, xz, yz)."""
    xx, yy, zz, xy, xz, yz = rows.T
    return np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), 2, 0)


def _sets(structure: Structure) -> list[str]:
    """Return the structure's sets by name, those of lines without a section as their nodes."""
    mesh, parts = structure.mesh, structure.parts
    written = {name: np.flatnonzero(parts.of_elements(own)) for name, own in mesh.element_sets.items()}
    lines: list[str] = []
    for card, members in (
        ("ELSET", {name: own for name, own in written.items() if own.size}),
        ("NSET", {n: mesh.nodes_at(mesh.element_sets[n]) for n, own in written.items() if not own.size}),
        ("NSET", mesh.node_sets),
    ):
        for name, own in members.items():
            if not SET_NAME.fullmatch(name) or OWN_NAMES.fullmatch(name) or _is_taken(name, members):
                lines.append(f"** the set {name!a} has a name that the deck cannot bear: it is left out")
            elif own.size:
                lines += [f"*{card}, {card}={name}", *(f"{number + 1}," for number in own.tolist())]
    return lines


def _is_taken(name: str, members: Mapping[str, object]) -> bool:
    """Whether a set before it has the name in other capitals."""
    return next(own for own in members if own.upper() == name.upper()) != name


def _others(structure: Structure, factor: FloatArray) -> list[str]:
    """Return what the shells' deck lacks: beams, masses, springs."""
    built = structure.built
    ends, _, _ = calculix.edges(built.mesh)
    first = built.mesh.n_elements + 1
    lines = _beams(structure, factor, ends, first) if len(built.beams.ends) else []
    first += len(built.beams.ends)
    for node in np.flatnonzero(built.point_masses):
        lines += [f"*ELEMENT, TYPE=MASS, ELSET=MASS{node + 1}", f"{first}, {node + 1}"]
        lines += [f"*MASS, ELSET=MASS{node + 1}", f"{built.point_masses[node]:.9e}"]
        first += 1
    scale = factor[len(factor) - len(built.springs.ends) :]
    for (node, other), six, left in zip(built.springs.ends.tolist(), built.springs.stiffness, scale, strict=True):
        if other >= 0:
            raise InputError(f"spring between nodes {node} and {other}; expected one to the ground; leave it out")
        for axis in np.flatnonzero(six):
            lines += [f"*ELEMENT, TYPE=SPRING1, ELSET=SPRING{first}", f"{first}, {node + 1}"]
            lines += [f"*SPRING, ELSET=SPRING{first}", f"{axis + 1}", f"{left * six[axis]:.9e}"]
            first += 1
    return lines


def _beams(structure: Structure, factor: FloatArray, edges: IntArray, first: int) -> list[str]:
    built = structure.built
    mesh, beams = built.mesh, built.beams
    n_nodes = len(mesh.nodes)
    middle = {(int(a), int(b)): n_nodes + k for k, (a, b) in enumerate(edges)}
    lines, extra = ["*NODE"], n_nodes + len(edges)
    for ends in np.sort(beams.ends, axis=1).tolist():
        if tuple(ends) not in middle:
            middle[ends[0], ends[1]] = extra
            x, y, z = mesh.nodes[ends].mean(axis=0)
            lines.append(f"{extra + 1}, {x:.11e}, {y:.11e}, {z:.11e}")
            extra += 1
    left = factor[mesh.n_elements :][: len(beams.ends)]
    for k, (a, b) in enumerate(beams.ends.tolist()):
        section = beams.sections[beams.section[k]]
        if not section.sides or section.offset.any():
            raise InputError(
                f"beam {k} is no rectangle on its nodes' line; expected one; make it with rectangular_beam"
            )
        along = mesh.nodes[b] - mesh.nodes[a]
        across = section.y_axis - along * (section.y_axis @ along) / (along @ along)
        poisson = section.young / (2.0 * section.shear) - 1.0
        lines += [f"*ELEMENT, TYPE=B32, ELSET=BEAM{k}"]
        lines += [f"{first + k}, {a + 1}, {middle[min(a, b), max(a, b)] + 1}, {b + 1}", f"*MATERIAL, NAME=BEAM{k}"]
        lines += ["*ELASTIC", f"{section.young * left[k]:.9e}, {poisson:.9f}", "*DENSITY", f"{section.density:.9e}"]
        lines += [f"*BEAM SECTION, ELSET=BEAM{k}, MATERIAL=BEAM{k}, SECTION=RECT"]
        lines += [
            "{:.9e}, {:.9e}".format(*section.sides),
            ", ".join(f"{v:.9f}" for v in across / np.linalg.norm(across)),
        ]
    return lines
