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
from femlib.export.calculix_results import gauge_strains
from femlib.sensors import StrainGauge
from femlib.structure.model import MICRO, Structure

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
    built, factor = structure.built, structure.stiffness_left(state)
    _check_stacks(structure)
    deck = Deck(
        shells=built,
        supports=structure.damaged.supports,
        load=load,
        factor=factor[: built.mesh.n_elements],
        analysis=analysis,
        n_modes=n_modes,
        printed=calculix.read_elements(built.mesh, [structure.on_patches(g) for g in gauges]) if gauges else None,
    )
    calculix.write_deck(deck, path, [*_others(structure, factor), *_sets(structure)])


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


def read_gauges(structure: Structure, path: str | Path, gauges: Sequence[StrainGauge]) -> FloatArray:
    """Return the gauge strains (n_gauges,) [microstrain, tension positive] of a deck's result (.dat).

    Raises
    ------
    InputError
        If the file is missing or lacks an element that a gauge reads.
    """
    return MICRO * gauge_strains(path, structure.built.mesh, [structure.on_patches(gauge) for gauge in gauges])


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
