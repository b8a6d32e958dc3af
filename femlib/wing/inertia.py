"""Inertial relief: the wing's own mass and what it carries pull down with the load factor, against the lift."""

from collections.abc import Mapping

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly import surface_load
from femlib.errors import InputError, is_number
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.loads import GRAVITY
from femlib.wing.model import Wing


def inertial_load(wing: Wing, payload: Mapping[float, float] | None = None) -> FloatArray:
    """Return the nodal forces (n_dofs,) [N] of structure and payload at load factor 1; add them to a lift.

    Parameters
    ----------
    wing : Wing
        The wing; its structure's mass is that of its laminates.
    payload : mapping
        Masses [kg] by span fraction, on the spar.

    Raises
    ------
    InputError
        If a payload lies outside the wing or its mass is negative or not finite.
    """
    shells = wing.structure.shells
    areal = np.array([laminate.mass for laminate in shells.laminates])[shells.section]
    down = np.zeros((shells.mesh.n_elements, 3))
    down[:, 2] = -GRAVITY * areal
    load = surface_load(shells.mesh, down)
    for node, mass in payload_masses(wing, payload).items():
        load[DOFS_PER_NODE * node + 2] -= GRAVITY * mass
    return load


def payload_masses(wing: Wing, payload: Mapping[float, float] | None) -> dict[int, float]:
    """Return the masses [kg] by node of masses [kg] by span fraction, on the spar.

    Each is shared by the two stations about it so that its moment is kept, half to each skin.

    Raises
    ------
    InputError
        If a mass lies outside the wing, is negative or not finite.
    """
    if payload is not None and not isinstance(payload, Mapping):
        raise InputError(f"payload is {payload!r}; expected masses by span fraction; write {{0.5: 0.17}}")
    grid, carried = wing.grid, dict[int, float]()
    for eta, mass in ({} if payload is None else payload).items():
        if not (is_number(eta) and is_number(mass) and 0.0 <= eta <= 1.0 and mass >= 0.0):
            raise InputError(f"payload of {mass!r} kg at eta {eta!r}; expected 0 kg or more at 0 to 1; correct it")
        row = int(np.clip(np.searchsorted(grid.eta, eta) - 1, 0, len(grid.eta) - 2))
        outer = (eta - grid.eta[row]) / (grid.eta[row + 1] - grid.eta[row])
        for station, share in ((row, 1.0 - outer), (row + 1, outer)):
            for skin in (grid.upper, grid.lower):
                node = int(skin[station, grid.spar_column])
                carried[node] = carried.get(node, 0.0) + 0.5 * share * mass
    return carried


def unit_weight(wing: Wing, eta: float) -> FloatArray:
    """Return the nodal forces (n_dofs,) [N] of 1 kg on the spar at a span fraction, at load factor 1."""
    pull = np.zeros((wing.grid.n_nodes, DOFS_PER_NODE))
    for node, mass in payload_masses(wing, {eta: 1.0}).items():
        pull[node, 2] = -GRAVITY * mass
    return pull.ravel()
