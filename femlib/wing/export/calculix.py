"""The wing as a CalculiX deck: any state, load factor, temperature, with or without large deflection.

Every shell becomes a quadratic one (S8R, S6) on the same corners with nodes added at the edges' middles, so that the
deck is another discretisation, not the same elements again. The deck prints the strains at the integration points of
the elements that the gauges read; two points through the thickness lie at +-t / (2 sqrt 3), which is +-1.10 mm for the
skin: the height of the carbon face that a gauge reads.
"""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from femlib import sensors
from femlib.arrays import FloatArray, IntArray
from femlib.checked import shown
from femlib.components import checked_damage, damage_row
from femlib.errors import InputError, frozen_floats
from femlib.files import read_bytes, whole_file
from femlib.mesh import DOFS_PER_NODE, Mesh
from femlib.wing.model import MICRO, Wing

N_POINTS = 8
"""Integration points of a quadratic shell."""
MOST_STRAIN = 1e6
"""Beyond it no material is left."""
MOST_DIGITS = 9
"""Digits of an element's number."""


def write_deck(
    wing: Wing,
    path: str | Path,
    state: Mapping[str, float],
    load_factor: float,
    warming: float | FloatArray = 0.0,
    large_deflection: bool = False,
    lift: FloatArray | None = None,
    gradient: float = 0.0,
) -> None:
    """Write the deck, whole or not at all.

    Parameters
    ----------
    wing : Wing
        The wing.
    path : str or Path
        File to write (.inp).
    state : mapping
        Damage fractions by parameter.
    load_factor : float
        Factor on the forces.
    warming : float or FloatArray
        Temperature above the stress-free state [K], uniform or of each element (n_elements,), as that of one warm skin.
    large_deflection : bool
        Let CalculiX follow the deformed shape.
    lift : FloatArray, optional
        Nodal forces and moments (n_dofs,) at load factor 1 [N, N m], as an aerodynamic load or the pull of masses; the
        elliptic lift if not given.
    gradient : float
        Temperature per height toward each shell's top side [K/m], with a uniform warming only.

    Raises
    ------
    InputError
        If state, load factor, temperature or forces are bad, the ending is not .inp, or the folder cannot be written
        to.
    """
    target = Path(path)
    if target.suffix != ".inp":
        raise InputError(f"deck path {target} ends in {target.suffix!r}; expected .inp; rename it")
    damage = checked_damage(damage_row(state, wing.parameters)[None, :], wing.parameters)[0]
    load = wing.load(load_factor, lift)
    expansion, field = _temperature(wing, warming, gradient)
    lines = [*_geometry(wing), *_sections(wing, damage, expansion), *_step(field, load, large_deflection)]
    with whole_file(target) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii")


def read_gauges(wing: Wing, path: str | Path) -> FloatArray:
    """Return the gauge strains (n_gauges,) [microstrain, compressive positive] from a deck's result (.dat).

    Raises
    ------
    InputError
        If the file is missing or lacks an element that a gauge reads.
    """
    centre = _centre_strains(Path(path))
    strains = []
    for name, weights in zip(wing.gauges.names, _gauge_elements(wing), strict=True):
        missing = [element for element in weights if element not in centre]
        if missing:
            raise InputError(
                f"{path} has no strains of element {missing[0] + 1}, which gauge {name} reads; run the deck"
            )
        strains.append(sum(weight * centre[element] for element, weight in weights.items()))
    return -MICRO * np.array(strains)


def _centre_strains(path: Path) -> dict[int, float]:
    """Return the spanwise strain at the upper face's middle of each printed element."""
    content = read_bytes(path, "CalculiX's .dat file; run the deck")
    text = content.decode(encoding="ascii", errors="replace")  # of another file nothing is found below
    points: dict[int, list[float]] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if line.lstrip().startswith("strains"):
            points.clear()  # a new increment: the last one counts
        words = line.split()
        if len(words) >= 8 and words[0].isdigit() and words[1].isdigit() and len(words[0]) <= MOST_DIGITS:
            points.setdefault(int(words[0]) - 1, []).append(_strain(words[3], path, number))
    short = [element for element, values in points.items() if len(values) < N_POINTS]
    if short:
        got = len(points[short[0]])
        raise InputError(f"{path} has {got} points of element {short[0] + 1}; expected {N_POINTS}; run the deck again")
    # points 1 to 4 lie in the lower half, 5 to 8 in the upper
    return {element: float(np.mean(values[4:8])) for element, values in points.items()}


def _strain(word: str, path: Path, number: int) -> float:
    try:
        strain = float(word)
    except ValueError:
        strain = math.nan
    if not abs(strain) <= MOST_STRAIN:
        raise InputError(
            f"{path}, line {number}: strain is {shown(word)}; expected a number up to {MOST_STRAIN:g}; run the deck"
        )
    return strain


def _gauge_elements(wing: Wing) -> list[dict[int, float]]:
    mesh = wing.structure.shells.mesh
    return sensors.element_weights(mesh, wing.gauges.strain_gauges(("top",), 1.0))


def _geometry(wing: Wing) -> list[str]:
    mesh = wing.structure.shells.mesh
    middles, quads, trias = _edge_middles(mesh)
    nodes = np.concatenate([mesh.nodes, middles])
    lines = ["** femlib wing; SI units (N, m, kg, K)", "*NODE, NSET=ALL"]
    lines += [f"{k + 1}, {x:.9e}, {y:.9e}, {z:.9e}" for k, (x, y, z) in enumerate(nodes)]
    first = 1
    for kind, corners, extra in (("S8R", mesh.quads, quads), ("S6", mesh.trias, trias)):
        lines.append(f"*ELEMENT, TYPE={kind}")
        joined = np.concatenate([corners, extra], axis=1) + 1
        lines += [f"{first + k}, " + ", ".join(map(str, row)) for k, row in enumerate(joined)]
        first += len(joined)
    root = np.flatnonzero(nodes[:, 1] == 0.0)
    lines += ["*NSET, NSET=ROOT", *(f"{k + 1}," for k in root), "*BOUNDARY", "ROOT, 1, 6"]
    read = sorted({element for weights in _gauge_elements(wing) for element in weights})
    return [*lines, "*ELSET, ELSET=GAUGES", *(f"{element + 1}," for element in read)]


def _edge_middles(mesh: Mesh) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the middles of all edges (n_edges, 3) and the numbers of each element's (n_quads, 4), (n_trias, 3)."""
    ends = [np.stack([c, np.roll(c, -1, axis=1)], axis=-1).reshape(-1, 2) for c in (mesh.quads, mesh.trias)]
    edges, place = np.unique(np.sort(np.concatenate(ends), axis=1), axis=0, return_inverse=True)
    numbers = len(mesh.nodes) + place.ravel()
    split = mesh.quads.size
    return mesh.nodes[edges].mean(axis=1), numbers[:split].reshape(-1, 4), numbers[split:].reshape(-1, 3)


def _temperature(wing: Wing, warming: float | FloatArray, gradient: float) -> tuple[FloatArray, str]:
    """Return a factor on each element's expansion (n_elements,) and the temperature field of all nodes.

    A node that two warm and cold shells share has one temperature, so a field by element enters by the expansion: each
    shell's own times its temperature, under one kelvin everywhere.
    """
    n = wing.structure.shells.mesh.n_elements
    if np.ndim(warming) == 0:
        uniform, steep = frozen_floats([float(np.asarray(warming)), gradient], "warming, gradient", (2,)).tolist()
        return np.ones(n), f"ALL, {uniform}, {steep}"
    if gradient != 0.0:
        raise InputError(
            f"gradient is {gradient} K/m beside a warming by element; expected 0; write two decks and add their strains"
        )
    return frozen_floats(warming, "warming", (n,)), "ALL, 1.0, 0.0"


def _sections(wing: Wing, damage: FloatArray, expansion_factor: FloatArray) -> list[str]:
    """Return materials and shell sections: one for each section, stiffness and expansion that occurs."""
    shells, cards = wing.structure.shells, wing.materials
    factor = cards.modulus_scale * shells.scale
    for mu, component in zip(damage, wing.structure.components, strict=True):
        factor = np.where(component.elements, (1.0 - mu) * factor, factor)
    columns = np.column_stack([shells.section, np.round(factor, 9), expansion_factor])
    kinds, member = np.unique(columns, axis=0, return_inverse=True)
    skin = (cards.skin_young, cards.skin_poisson, cards.skin_thickness, cards.skin_density, cards.skin_expansion)
    wood = (cards.wood_young, cards.wood_poisson, cards.wood_thickness, cards.wood_density, cards.wood_expansion)
    lines: list[str] = []
    for number, (section, amount, warmth) in enumerate(kinds):
        young, poisson, thickness, density, expansion = (skin, wood)[int(section)]
        lines += [f"*ELSET, ELSET=E{number}", *(f"{e + 1}," for e in np.flatnonzero(member.ravel() == number))]
        lines += [
            f"*MATERIAL, NAME=M{number}",
            "*ELASTIC",
            f"{young * amount:.9e}, {poisson}",
            "*DENSITY",
            f"{density}",
        ]
        lines += ["*EXPANSION, ZERO=0", f"{expansion * warmth:.9e}"]
        lines += [f"*SHELL SECTION, ELSET=E{number}, MATERIAL=M{number}", f"{thickness}"]
    return lines


def _step(temperature: str, load: FloatArray, large_deflection: bool) -> list[str]:
    lines = ["*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, 0."]
    lines += ["*STEP" + (", NLGEOM" if large_deflection else ""), "*STATIC"]
    if large_deflection:
        lines.append("1., 1.")  # the whole load at once: CalculiX halves it by itself where it must
    lines += ["*TEMPERATURE", temperature, "*CLOAD"]
    forces = load.reshape(-1, DOFS_PER_NODE)
    lines += [f"{n + 1}, {axis + 1}, {forces[n, axis]:.9e}" for n, axis in np.argwhere(forces != 0.0)]
    printed = ["*EL PRINT, ELSET=GAUGES", "E", "*NODE FILE, OUTPUT=2D", "U", "*END STEP"]
    return lines + printed
