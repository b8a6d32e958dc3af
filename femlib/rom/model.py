"""A reduced model of a damaged structure, with a guaranteed error bound, in microseconds a state.

Each component i (package components) lets its stiffness T_i = L_i L_i' go by mu_i. With y_i = mu_i L_i' u_b, its strain
measure, and K_0 u_0 = f,

    y_i / mu_i - sum_j H_ij y_j = g_i,   H_ij = L_i' K_0^-1 L_j,   g_i = L_i' u_0,
    output s = s_0 + sum_i p_i' y_i + sum_i mu_i / (1 - mu_i) q_i,   p_i = L_i' K_0^-1 c.

The system is symmetric positive definite, and since the regions' stiffness is part of K_0, H <= I. The reduced model
takes y_i = Q_i a_i and the Galerkin equations; only the damaged components enter a query.

Error bound. S = diag(1 / mu_i) - H >= diag((1 - mu_i) / mu_i), so for the residuals r (of the state) and d (of the
output's own dual problem) the error of an output is at most

    |s - s_N| <= |r|_* |d|_*,   |r|_*^2 = sum_i mu_i / (1 - mu_i) |r_i|^2,

with the parts of r_i outside the span of Q_i read from an orthogonal factor made once: no cancellation, no free
constant.

Source: the reduced basis and its dual-weighted bound, G. Rozza, D. B. P. Huynh, A. T. Patera, Arch. Comput. Methods
Engng 15 (2008) 229-275; components with ports, D. B. P. Huynh, D. J. Knezevic, A. T. Patera, ESAIM M2AN 47 (2013)
213-251.
"""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import scipy.linalg as linalg
from scipy.linalg.lapack import dposv

from femlib.arrays import FloatArray, IntArray
from femlib.components import checked_damage
from femlib.errors import InputError, SolveError, frozen_floats

ROUNDING = 1e-8
"""Relative rounding of the full solutions that the model is made of; part of the bound."""
CHUNK = 512
"""States solved together: bounds memory and stays in the cache."""
TOLERANCE = 1e-11
"""Residual of a batch's conjugate gradients over its load."""
MOST_STEPS = 500
TINY = 1e-300
"""Keeps the quotients of a state that is already solved finite."""


@dataclass(frozen=True, slots=True, eq=False)
class ReducedModel:
    """Outputs of damage states from the modes of their components.

    Attributes
    ----------
    parameters, outputs : tuple of str
        Names of the damage parameters (n_parameters,) and of the outputs (n_outputs,).
    pristine : FloatArray
        Outputs of the undamaged structure at unit load (n_outputs,).
    owner : IntArray
        Component of each mode (N,).
    load : FloatArray
        g on the modes (N,).
    coupling : FloatArray
        H on the modes (N, N), diagonal within each component.
    readout : FloatArray
        p on the modes (n_outputs, N).
    interior : FloatArray
        q of the module's docstring (n_outputs, n_parameters).
    residual : tuple of FloatArray
        For each component the triangular factor (k, 1 + n_outputs + N) of what its modes cannot hold of the load, of
        the outputs' duals and of the coupling.
    provenance : dict
        What the model was made from and with what settings.
    """

    parameters: tuple[str, ...]
    outputs: tuple[str, ...]
    pristine: FloatArray
    owner: IntArray
    load: FloatArray
    coupling: FloatArray
    readout: FloatArray
    interior: FloatArray
    residual: tuple[FloatArray, ...]
    provenance: dict[str, str]
    _own: FloatArray = field(init=False, repr=False)
    _across: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        n_outputs, n_modes = len(self.outputs), len(self.owner)
        shapes = {
            "pristine": (n_outputs,),
            "load": (n_modes,),
            "coupling": (n_modes, n_modes),
            "readout": (n_outputs, n_modes),
            "interior": (n_outputs, len(self.parameters)),
        }
        for name, shape in shapes.items():
            object.__setattr__(self, name, frozen_floats(getattr(self, name), f"reduced model {name}", shape))
        object.__setattr__(self, "_own", np.diag(self.coupling).copy())
        across = np.where(self.owner[:, None] == self.owner, 0.0, self.coupling)
        object.__setattr__(self, "_across", across)

    @property
    def n_modes(self) -> int:
        """Number of modes of all components."""
        return len(self.owner)

    def solve(self, states: FloatArray) -> FloatArray:
        """Return the outputs (n_states, n_outputs) at unit load of damage states (n_states, n_parameters).

        Raises
        ------
        InputError
            If a damage is outside [0, 1).
        """
        damage = checked_damage(states, self.parameters)
        outputs = self.pristine + (damage / (1.0 - damage)) @ self.interior.T
        for first in range(0, len(damage), CHUNK):
            chunk = slice(first, first + CHUNK)
            outputs[chunk] += self._amplitudes(damage[chunk][:, self.owner]) @ self.readout.T
        return np.asarray(outputs)

    def query(self, damage: FloatArray) -> FloatArray:
        """Return the outputs (n_outputs,) at unit load of one state (n_parameters,), unchecked: for inner loops."""
        modes = damage[self.owner].nonzero()[0]
        if modes.size == 0:
            return self.pristine
        everywhere = len(modes) == self.n_modes
        matrix = -self.coupling if everywhere else -self.coupling[modes[:, None], modes]
        matrix.flat[:: len(modes) + 1] += 1.0 / damage[self.owner[modes]]
        amplitudes = dposv(matrix, self.load[modes], lower=1)[1]
        readout = self.readout if everywhere else self.readout[:, modes]
        return np.asarray(self.pristine + readout @ amplitudes + self.interior @ (damage / (1.0 - damage)))

    def error_bound(self, states: FloatArray) -> FloatArray:
        """Return an upper bound (n_states, n_outputs) of the error of `solve` against the full model, at unit load."""
        damage = checked_damage(states, self.parameters)
        return np.stack([self._bound(mu) for mu in damage]).reshape(len(damage), len(self.outputs))

    def save(self, path: str | Path) -> None:
        """Write the model to one .npz file."""
        target = Path(path)
        if target.suffix != ".npz":
            raise InputError(f"reduced model path {target} ends in {target.suffix!r}; expected .npz; rename it")
        words = {"parameters": self.parameters, "outputs": self.outputs, "provenance": self.provenance}
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {f"residual_{k}": factor for k, factor in enumerate(self.residual)}
        try:
            np.savez(target, words=np.array(json.dumps(words)), **arrays)
        except OSError as error:
            raise InputError(f"{target} cannot be written ({error.strerror}); expected a writable folder") from error

    @classmethod
    def load_file(cls, path: str | Path) -> "ReducedModel":
        """Read a model that `save` wrote."""
        try:
            with np.load(Path(path), allow_pickle=False) as held:
                words = json.loads(str(held["words"]))
                arrays = {name: held[name] for name in _ARRAYS}
                residual = tuple(held[f"residual_{k}"] for k in range(len(words["parameters"])))
        except (OSError, KeyError, ValueError) as error:
            raise InputError(f"{path} is not a reduced model ({error}); expected a file that save wrote") from error
        return cls(
            tuple(words["parameters"]),
            tuple(words["outputs"]),
            **arrays,
            residual=residual,
            provenance=words["provenance"],
        )

    def _amplitudes(self, damage: FloatArray) -> FloatArray:
        """Return the mode amplitudes (n_states, N) for the damage of each mode (n_states, N).

        Conjugate gradients on all states at once, scaled by the components' own solutions: with w = mu / (1 - mu H_ii)
        the system is (I - w^1/2 H_ij w^1/2) x = w^1/2 g. Undamaged components have w = 0 and drop out by themselves.
        """
        root = np.sqrt(damage / (1.0 - damage * self._own))
        remainder = root * self.load
        solution, direction = np.zeros_like(root), remainder
        square = np.einsum("sn,sn->s", remainder, remainder)
        target = TOLERANCE**2 * square
        for _ in range(MOST_STEPS):
            if (square <= target).all():
                return np.asarray(root * solution)
            image = direction - root * ((root * direction) @ self._across)
            step = square / np.maximum(np.einsum("sn,sn->s", direction, image), TINY)
            solution = solution + step[:, None] * direction
            remainder = remainder - step[:, None] * image
            next_square = np.einsum("sn,sn->s", remainder, remainder)
            direction = remainder + (next_square / np.maximum(square, TINY))[:, None] * direction
            square = next_square
        raise SolveError(
            f"reduced model did not converge to {TOLERANCE} in {MOST_STEPS} steps (left: {np.sqrt(square.max()):.2g}); "
            "expected damages away from 1; lower them"
        )

    def _bound(self, mu: FloatArray) -> FloatArray:
        active = np.flatnonzero(mu)
        scale = ROUNDING * np.abs(self.pristine).max(initial=0.0)
        if active.size == 0:
            return np.full(len(self.outputs), scale)
        modes = np.flatnonzero(mu[self.owner])
        matrix = np.diag(1.0 / mu[self.owner[modes]]) - self.coupling[np.ix_(modes, modes)]
        # the state's own amplitudes, then those of each output's dual
        right = np.concatenate([self.load[modes, None], self.readout[:, modes].T], axis=1)
        amplitudes = linalg.solve(matrix, right, assume_a="pos")
        squares = np.zeros(right.shape[1])
        first = right.shape[1]
        for k in active:
            factor = self.residual[k]
            part = factor[:, :first] + factor[:, first + modes] @ amplitudes
            squares += mu[k] / (1.0 - mu[k]) * np.square(part).sum(axis=0)
        return np.asarray(np.sqrt(squares[0] * squares[1:]) + scale / (1.0 - mu.max()))


_ARRAYS = ("pristine", "owner", "load", "coupling", "readout", "interior")
