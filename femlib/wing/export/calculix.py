"""The wing as a CalculiX deck: any state, load factor, temperature, with or without large deflection.

The shells go out by `femlib.export.calculix` as quadratic ones. The deck prints the strains at the integration points
of the elements that the gauges read; two points through the thickness lie at +-t / (2 sqrt 3), which is +-1.10 mm for
the skin: the height of the carbon face that a gauge reads.
"""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from femlib import sensors
from femlib.arrays import FloatArray
from femlib.checked import shown
from femlib.components import checked_damage, damage_row
from femlib.errors import InputError, frozen_floats
from femlib.export import calculix
from femlib.export.calculix import Deck
from femlib.files import read_bytes
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
    damage = checked_damage(damage_row(state, wing.parameters)[None, :], wing.parameters)[0]
    factor = np.ones(wing.structure.shells.mesh.n_elements)
    for mu, component in zip(damage, wing.structure.components, strict=True):
        factor = np.where(component.elements, (1.0 - mu) * factor, factor)
    expansion, temperature = _temperature(wing, warming, gradient)
    deck = Deck(
        shells=wing.structure.shells,
        supports=wing.structure.supports,
        load=wing.load(load_factor, lift),
        factor=factor,
        temperature=temperature,
        expansion_factor=expansion,
        analysis="large deflection" if large_deflection else "linear",
        printed=np.array(sorted({element for weights in _gauge_elements(wing) for element in weights})),
    )
    calculix.write_deck(deck, path)


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


def _temperature(wing: Wing, warming: float | FloatArray, gradient: float) -> tuple[FloatArray, tuple[float, float]]:
    """Return a factor on each element's expansion (n_elements,) and the temperature of all nodes with its gradient.

    A node that two warm and cold shells share has one temperature, so a field by element enters by the expansion: each
    shell's own times its temperature, under one kelvin everywhere.
    """
    n = wing.structure.shells.mesh.n_elements
    if np.ndim(warming) == 0:
        uniform, steep = frozen_floats([float(np.asarray(warming)), gradient], "warming, gradient", (2,)).tolist()
        return np.ones(n), (uniform, steep)
    if gradient != 0.0:
        raise InputError(
            f"gradient is {gradient} K/m beside a warming by element; expected 0; write two decks and add their strains"
        )
    return frozen_floats(warming, "warming", (n,)), (1.0, 0.0)
