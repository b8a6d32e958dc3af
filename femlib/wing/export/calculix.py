"""The wing as a CalculiX deck: any state, load factor, temperature, with or without large deflection.

The shells go out by `femlib.export.calculix` as quadratic ones. The deck prints the strains at the integration points
of the elements that the gauges read.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError, frozen_floats
from femlib.export import calculix
from femlib.export.calculix import Deck
from femlib.export.calculix_results import gauge_strains
from femlib.wing.model import MICRO, Wing


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
    expansion, temperature = _temperature(wing, warming, gradient)
    deck = Deck(
        shells=wing.structure.shells,
        supports=wing.structure.supports,
        load=wing.load(load_factor, lift),
        factor=wing.structure.left_in(state),
        temperature=temperature,
        expansion_factor=expansion,
        analysis="large deflection" if large_deflection else "linear",
        printed=calculix.read_elements(wing.structure.shells.mesh, wing.strain_gauges),
    )
    calculix.write_deck(deck, path)


def read_gauges(wing: Wing, path: str | Path) -> FloatArray:
    """Return the gauge strains (n_gauges,) [microstrain, compressive positive] from a deck's result (.dat).

    Raises
    ------
    InputError
        If the file is missing or lacks an element that a gauge reads.
    """
    return -MICRO * gauge_strains(path, wing.structure.shells.mesh, wing.strain_gauges)


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
