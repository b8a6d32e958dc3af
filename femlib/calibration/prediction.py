"""Predictions of observations and their gradients, by one adjoint solve per output.

With K(p) u = f(p) and an output y = r(p)' u, K symmetric, a = K^-1 r,

    dy/dp = (dr/dp)' u + a' df/dp - sum_e d(s_e d_e)/dp a_e' K_e u_e,

whose products a_e' K_e u_e serve every parameter. A simple natural frequency f = sqrt(lambda) / (2 pi) with the mode
phi of modal mass 1 has d lambda/dp = phi' (dK/dp - lambda dM/dp) phi.

Sources: R. T. Haftka, Z. Guerdal, Elements of Structural Optimization (1992), section 7.2, for the adjoint; R. L. Fox,
M. P. Kapoor, AIAA Journal 6 (1968), eq (8), for the frequency.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.assembly import Mode, assemble, factorise, matrix_modes
from femlib.calibration.design import Design, element_masses
from femlib.calibration.observation import FrequencyReading, MassReading, Observation, OutputReading
from femlib.calibration.varying import Varying
from femlib.elements import quad4, tria3
from femlib.errors import InputError
from femlib.mesh import Mesh, dofs_of_nodes

MOST_MODES = 8
"""Modes among which the asked ones are looked for, beyond the asked number."""


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """Predicted readings and their gradient.

    Attributes
    ----------
    value : FloatArray
        Predictions (n_entries,), observation by observation.
    jacobian : FloatArray
        Derivatives (n_entries, n_parameters) by the parameters' values.
    """

    value: FloatArray
    jacobian: FloatArray


def predict(design: Design, observations: Sequence[Observation], parameters: Sequence[str]) -> Prediction:
    """Return what a design predicts for observations, with the derivatives by the named parameters.

    Raises
    ------
    InputError
        If an observation names a state, load or output that the design lacks, or has another number of entries.
    SolveError
        If the structure cannot be solved.
    """
    matrices = design.shells.element_stiffness
    solved = {name: _solve_state(design, name, observations, parameters, matrices) for name in _states(observations)}
    modes = _modes(design, observations)
    values, slopes = [], []
    for observation in observations:
        if isinstance(observation, OutputReading):
            value, slope = _output(observation, solved)
        elif isinstance(observation, MassReading):
            value, slope = _mass(design, parameters)
        else:
            value, slope = _frequency(design, observation, modes, parameters, matrices)
        if len(value) != observation.n_entries:
            raise InputError(
                f"{observation.group} has {observation.n_entries} readings but the design predicts {len(value)}; "
                "expected as many as the output has rows; complete them"
            )
        values.append(value)
        slopes.append(slope)
    return Prediction(np.concatenate(values), np.concatenate(slopes))


_Outputs = dict[tuple[str, str], tuple[FloatArray, FloatArray]]
_Matrices = tuple[FloatArray, FloatArray]


def _states(observations: Sequence[Observation]) -> list[str]:
    """Return the states that readings name, each once."""
    readings = [o for o in observations if isinstance(o, OutputReading)]
    return list(dict.fromkeys(n for o in readings for n in (o.state, o.reference) if n is not None))


def _solve_state(
    design: Design, state: str, observations: Sequence[Observation], parameters: Sequence[str], matrices: _Matrices
) -> _Outputs:
    """Return the outputs of a state with their gradients, by (load, output): one factorisation."""
    readings = [o for o in observations if isinstance(o, OutputReading) and state in (o.state, o.reference)]
    pairs = list(dict.fromkeys((o.load, o.output) for o in readings))
    for what, known, asked in (
        ("state", design.states, [state]),
        ("load", design.loads, [load for load, _ in pairs]),
        ("output", design.outputs, [output for _, output in pairs]),
    ):
        unknown = [name for name in asked if name not in known]
        if unknown:
            raise InputError(f"observations name the {what} {unknown[0]!r}; expected one of {list(known)}; correct it")
    supports, factor = design.supports, design.stiffness * design.states[state]
    factors = factorise(supports.reduce(_assembled(design.shells.mesh, matrices, factor.value)), supports.groups)
    loads, outputs = (list(dict.fromkeys(names)) for names in zip(*pairs, strict=True))
    forces = np.stack([design.loads[name].value for name in loads], axis=1)
    moved = dict(zip(loads, supports.expand(factors.solve(forces[supports.free])).T, strict=True))
    rows = {name: design.outputs[name].value for name in outputs}
    adjoint = {
        name: supports.expand(factors.solve(np.ascontiguousarray(r.toarray().T[supports.free])))
        for name, r in rows.items()
    }
    return {
        (load, output): (
            np.asarray(rows[output] @ moved[load]),
            _gradient(design, factor, moved[load], adjoint[output], (load, output), parameters, matrices),
        )
        for load, output in pairs
    }


def _assembled(mesh: Mesh, matrices: _Matrices, factor: FloatArray) -> sparse.csc_array:
    k = len(mesh.quads)
    return assemble(mesh, matrices[0] * factor[:k, None, None], matrices[1] * factor[k:, None, None])


def _gradient(
    design: Design,
    factor: Varying,
    moved: FloatArray,
    adjoint: FloatArray,
    pair: tuple[str, str],
    parameters: Sequence[str],
    matrices: _Matrices,
) -> FloatArray:
    """Return the derivatives (n_outputs, n_parameters) of an output under a load."""
    load, output = design.loads[pair[0]], design.outputs[pair[1]]
    shared = _element_products(design.shells.mesh, matrices, adjoint, moved)
    slopes = np.zeros((adjoint.shape[1], len(parameters)))
    for column, name in enumerate(parameters):
        if name in output.slopes:
            slopes[:, column] += output.slopes[name] @ moved
        if name in load.slopes:
            slopes[:, column] += load.slopes[name] @ adjoint
        if name in factor.slopes:
            slopes[:, column] -= shared @ factor.slopes[name]
    return slopes


def _element_products(mesh: Mesh, matrices: _Matrices, left: FloatArray, right: FloatArray) -> FloatArray:
    """Return a_e' K_e u_e (n_outputs, n_elements) for motions a (n_dofs, n_outputs) and u (n_dofs,)."""
    products = []
    for corners, matrix in zip((mesh.quads, mesh.trias), matrices, strict=True):
        dofs = dofs_of_nodes(corners).reshape(len(corners), matrix.shape[1])
        force = np.einsum("eij,ej->ei", matrix, right[dofs])
        products.append(np.einsum("eio,ei->oe", left[dofs], force))
    return np.concatenate(products, axis=1)


def _output(reading: OutputReading, solved: dict[str, _Outputs]) -> tuple[FloatArray, FloatArray]:
    """Return an output's value and gradient, less those of its reference."""
    pair = (reading.load, reading.output)
    value, slope = solved[reading.state][pair]
    if reading.reference is None:
        return value, slope
    before, slope_before = solved[reading.reference][pair]
    return value - before, slope - slope_before


def _mass(design: Design, parameters: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Return the mass of the shells (1,) and its gradient (1, n_parameters)."""
    own = element_masses(design.shells)
    slopes = [float(own @ design.mass.slopes[name]) if name in design.mass.slopes else 0.0 for name in parameters]
    return np.array([own @ design.mass.value]), np.array([slopes])


def _modes(design: Design, observations: Sequence[Observation]) -> list[Mode]:
    """Return the lowest modes of the undamaged structure, as many as readings can ask for."""
    asked = [o.number for o in observations if isinstance(o, FrequencyReading)]
    if not asked:
        return []
    mesh = design.shells.mesh
    stiffness = _assembled(mesh, design.shells.element_stiffness, design.stiffness.value)
    heavy = _assembled(mesh, _mass_matrices(design), design.mass.value)
    if design.point_mass is not None:
        heavy = heavy + design.point_mass
    n_modes = min(max(asked) + MOST_MODES, len(design.supports.free) - 2)
    return matrix_modes(stiffness, heavy, design.supports, n_modes)


def _mass_matrices(design: Design) -> _Matrices:
    shells, k = design.shells, len(design.shells.mesh.quads)
    mesh = shells.mesh
    quads = quad4.mass(mesh.nodes[mesh.quads], shells.laminates, shells.section[:k])
    return quads, tria3.mass(mesh.nodes[mesh.trias], shells.laminates, shells.section[k:])


def _frequency(
    design: Design, reading: FrequencyReading, modes: Sequence[Mode], parameters: Sequence[str], matrices: _Matrices
) -> tuple[FloatArray, FloatArray]:
    """Return a frequency (1,) and its gradient (1, n_parameters)."""
    counted = [mode for mode in modes if _counts(design, reading, mode)]
    if reading.number >= len(counted):
        raise InputError(
            f"{reading.group} asks for mode {reading.number} that moves {reading.moves!r} more than {reading.still!r}; "
            f"expected 0 to {len(counted) - 1} of the {len(modes)} lowest modes; ask for a lower one"
        )
    mode = counted[reading.number]
    mesh, omega = design.shells.mesh, 2.0 * np.pi * mode.frequency
    bent = _element_products(mesh, matrices, mode.shape[:, None], mode.shape)[0]
    moving = _element_products(mesh, _mass_matrices(design), mode.shape[:, None], mode.shape)[0]
    slopes = np.zeros((1, len(parameters)))
    for column, name in enumerate(parameters):
        for products, factor, weight in ((bent, design.stiffness, 1.0), (moving, design.mass, -(omega**2))):
            if name in factor.slopes:
                slopes[0, column] += weight * float(products @ factor.slopes[name])
    return np.array([mode.frequency]), slopes / (2.0 * omega) / (2.0 * np.pi)


def _counts(design: Design, reading: FrequencyReading, mode: Mode) -> bool:
    """Return whether a mode is among those that a reading counts."""
    if not reading.moves:
        return True
    for name in (reading.moves, reading.still):
        if name not in design.outputs:
            raise InputError(
                f"{reading.group} names the output {name!r}; expected one of {list(design.outputs)}; correct it"
            )
    up, across = (abs(float((design.outputs[n].value @ mode.shape)[0])) for n in (reading.moves, reading.still))
    return up > across
