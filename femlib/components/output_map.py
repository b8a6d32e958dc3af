"""Outputs of damage states under one load, as a map that costs small dense products per state.

With the ports' condensation S_0, each component's T_i, the pristine solution u_0 and the outputs' adjoint a = K_0^-1 c,

    c' u(mu) = c' u_0 + a_b' [sum_i mu_i T_i] S(mu)^-1 S_0 u_0,b + sum_i mu_i / (1 - mu_i) a' w_i

in the words of the package's docstring. The map holds dense arrays alone: it goes to other processes as it is.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.components.ports import Ports
from femlib.components.regions import checked_damage


@dataclass(frozen=True, slots=True, eq=False)
class OutputMap:
    """Outputs of damage states under one load.

    Attributes
    ----------
    parameters : tuple of str
        Names of all damage parameters of the structure (n_parameters,).
    active : tuple of int
        Parameters whose ports the map holds; the others must be zero.
    pristine : FloatArray
        Outputs of the undamaged structure (n_outputs,).
    ports : Ports
        The ports of the active components.
    load : FloatArray
        Condensed load S_0 u_0,b (n_ports,).
    adjoint : FloatArray
        What a unit force at a port does to each output (n_ports, n_outputs).
    interior : FloatArray
        What the interior loads of each active component do at mu / (1 - mu) = 1 (n_active, n_outputs).
    """

    parameters: tuple[str, ...]
    active: tuple[int, ...]
    pristine: FloatArray
    ports: Ports
    load: FloatArray
    adjoint: FloatArray
    interior: FloatArray

    def solve(self, states: FloatArray) -> FloatArray:
        """Return the outputs (n_states, n_outputs) of damage states (n_states, n_parameters).

        Raises
        ------
        InputError
            If a damage is outside [0, 1).
        """
        damage = checked_damage(states, self.parameters)[:, list(self.active)]
        forces = self.ports.forces(damage, self.load)
        return np.asarray(self.pristine + forces @ self.adjoint + (damage / (1.0 - damage)) @ self.interior)
