"""A reduced model of a damaged structure, with a guaranteed error bound, in microseconds per state.

In the words of femlib.components.flexibility and femlib.rom.modes, with y_i = Phi_i a_i and tests Psi_i,

    (diag(1 / mu) - C) a = b,   C = Psi' H Phi,   b = Psi' g,   output s = s_0 + P a + sum_i mu_i / (1 - mu_i) q_i.

Modes are ordered by what they do to the outputs. The leading ones are solved together. Where more are at work, the rest
follow from them, each alone, and send back, in turns until little changes: solving all together takes ten times as
long. The bound is of the solution as it is returned.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg.lapack import dgesv, dgetrs

from femlib.arrays import FloatArray, IntArray
from femlib.components.regions import checked_damage
from femlib.errors import InputError, SolveError, frozen_floats
from femlib.kept import ReadOnly
from femlib.rom.bound import ErrorBound
from femlib.rom.file import read_model, write_model
from femlib.rom.sweeps import Sweeps

MOST_TURNS = 12
SETTLED = 1e-4
"""Change of the leading amplitudes in the last turn over the largest amplitude."""
ROUNDING = 1e-8
"""Relative rounding of the full solutions that the model is made of; part of the bound."""
CHUNK = 1024
"""States solved together: bounds memory and stays in the cache."""


@dataclass(frozen=True, slots=True, eq=False)
class ReducedModel:
    """Outputs of damage states from the modes of their regions.

    Attributes
    ----------
    parameters, outputs : tuple of str
        Names of the damage parameters (n_parameters,) and of the outputs (n_outputs,).
    pristine : FloatArray
        Outputs of the undamaged structure at unit load (n_outputs,).
    owner : IntArray
        Region of each mode (N,).
    load : FloatArray
        b (N,).
    coupling : FloatArray
        C (N, N).
    readout : FloatArray
        P (n_outputs, N).
    interior : FloatArray
        q (n_outputs, n_parameters).
    bound : ErrorBound
        What the residuals are made of.
    provenance : mapping
        What the model was made from and with what settings.
    n_leading : int
        Modes solved together; those after them are turned to eigenvectors within their region. With 0 they also
        follow one another region by region, so that batches are solved by the regions in turns.
    motion : FloatArray, optional
        Displacements (n_dofs, N + n_parameters + 1) of the amplitudes, of mu / (1 - mu) and of 1 [m, rad].

    Examples
    --------
    >>> import scipy
    >>> from femlib.rom import reduce_structure
    >>> from femlib.structure.example import clamped_strip
    >>> full = clamped_strip()
    >>> load, rows = full.point_load("tip", (0.0, 0.0, 100.0)), scipy.sparse.csr_array(np.eye(1, 60, 56))  # z of a tip
    >>> model = reduce_structure(full.damaged, load, rows, ["tip"])
    >>> model.parameters, model.outputs, bool(model.error_bound([[0.5]]).max() < 1e-6)
    (('root',), ('tip',), True)
    """

    parameters: tuple[str, ...]
    outputs: tuple[str, ...]
    pristine: FloatArray
    owner: IntArray
    load: FloatArray
    coupling: FloatArray
    readout: FloatArray
    interior: FloatArray
    bound: ErrorBound
    provenance: Mapping[str, str]
    n_leading: int
    motion: FloatArray | None = None
    _lead: FloatArray = field(init=False, repr=False)  # the leading modes' coupling, by columns as LAPACK wants it
    _send: FloatArray = field(init=False, repr=False)  # from all modes to the rest, but for the rest's own
    _back: FloatArray = field(init=False, repr=False)  # from the rest to the leading
    _own: FloatArray = field(init=False, repr=False)  # diagonal of the rest
    _map: FloatArray = field(init=False, repr=False)  # outputs of (amplitudes, mu / (1 - mu), 1)
    _sweeps: Sweeps | None = field(init=False, repr=False)

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
        object.__setattr__(self, "provenance", ReadOnly(self.provenance))
        first = self.n_leading
        object.__setattr__(self, "_lead", np.asfortranarray(self.coupling[:first, :first]))
        object.__setattr__(self, "_back", self.coupling[:first, first:].copy())
        object.__setattr__(self, "_own", self.coupling.diagonal()[first:].copy())
        send = self.coupling[first:] - np.eye(n_modes)[first:] * self.coupling.diagonal()
        object.__setattr__(self, "_send", send)
        object.__setattr__(self, "_map", np.column_stack([self.readout, self.interior, self.pristine]))
        sweeps = Sweeps.of(self.owner, self.load, self.coupling, len(self.parameters)) if first == 0 else None
        object.__setattr__(self, "_sweeps", sweeps)

    @property
    def n_modes(self) -> int:
        """Number of modes of all regions."""
        return len(self.owner)

    def solve(self, states: FloatArray) -> FloatArray:
        """Return the outputs (n_states, n_outputs) at unit load of damage states (n_states, n_parameters).

        Raises
        ------
        InputError
            If a damage is outside [0, 1).
        """
        damage = checked_damage(states, self.parameters)
        if len(damage) == 1:
            return self.query(damage[0])[None, :]
        outputs = np.empty((len(damage), len(self.outputs)))
        for first in range(0, len(damage), CHUNK):
            mu = damage[first : first + CHUNK]
            np.matmul(self.parts(mu), self._map.T, out=outputs[first : first + CHUNK])
        return outputs

    def displacements(self, states: FloatArray) -> FloatArray:
        """Return the displacements (n_states, n_dofs) at unit load of damage states (n_states, n_parameters).

        Raises
        ------
        InputError
            If a damage is outside [0, 1) or the model was made without its motion.
        """
        if self.motion is None:
            raise InputError("this reduced model holds no displacements; reduce the structure with with_motion=True")
        return np.asarray(self.parts(checked_damage(states, self.parameters)) @ self.motion.T)

    def parts(self, mu: FloatArray) -> FloatArray:
        """Return (amplitudes, mu / (1 - mu), 1) (n_states, N + n_parameters + 1) of checked damages.

        Whatever is linear in the displacements is linear in them: `motion` are those of each.
        """
        return np.concatenate([self.amplitudes(mu).T, (mu / (1.0 - mu)).T, np.ones((1, len(mu)))]).T

    def query(self, damage: FloatArray) -> FloatArray:
        """Return the outputs (n_outputs,) at unit load of one state (n_parameters,), unchecked: for inner loops."""
        mu = damage[self.owner]
        outputs = self.pristine + self.interior @ (damage / (1.0 - damage))
        modes = mu.nonzero()[0]
        if 0 < self.n_leading < len(modes):
            return np.asarray(outputs + self.readout @ self._in_turns(mu))
        if len(modes) == self.n_modes:
            return np.asarray(outputs + self.readout @ _together(mu, self.coupling, self.load))
        block = self.coupling[modes[:, None], modes]
        return np.asarray(outputs + self.readout[:, modes] @ _together(mu[modes], block, self.load[modes]))

    def amplitudes(self, damage: FloatArray) -> FloatArray:
        """Return a (n_states, N) of checked states (n_states, n_parameters); 0 for modes of undamaged regions."""
        turned = self._sweeps.amplitudes(np.ascontiguousarray(damage.T)) if self._sweeps else None
        if turned is not None:
            return turned.T
        amplitudes = np.zeros((len(damage), self.n_modes))
        for mu, row in zip(damage[:, self.owner], amplitudes, strict=True):
            modes = mu.nonzero()[0]
            if 0 < self.n_leading < len(modes):
                row[:] = self._in_turns(mu)
            else:
                row[modes] = _together(mu[modes], self.coupling[modes[:, None], modes], self.load[modes])
        return amplitudes

    def error_bound(self, states: ArrayLike) -> FloatArray:
        """Return an upper bound (n_states, n_outputs) of the error of `solve` against the full model, at unit load."""
        damage = checked_damage(states, self.parameters)
        bounds = [self._bound(mu, row) for mu, row in zip(damage, self.amplitudes(damage), strict=True)]
        return np.array(bounds).reshape(len(damage), len(self.outputs))

    def save(self, path: str | Path) -> None:
        """Write the model to one .npz file.

        Raises
        ------
        InputError
            If the path does not end in .npz or cannot be written.
        """
        write_model(path, {name: getattr(self, name) for name in _SAVED}, self.bound)

    @classmethod
    def load_file(cls, path: str | Path) -> "ReducedModel":
        """Read a model that `save` wrote.

        Raises
        ------
        InputError
            If the file is not such a model.
        """
        return cls(**read_model(path, _SAVED))

    def _in_turns(self, mu: FloatArray) -> FloatArray:
        """Return the amplitudes (N,) for the damage of each mode (N,), the rest following the leading."""
        first = self.n_leading
        lead_load, rest_load, damage = self.load[:first], self.load[first:], mu[:first]
        rest_alone = mu[first:] / (1.0 - mu[first:] * self._own)
        lu, pivots, lead, _ = dgesv(_matrix(damage, self._lead), damage * lead_load, overwrite_a=1)
        amplitudes = np.zeros_like(mu)
        amplitudes[:first] = lead
        amplitudes[first:] = rest_alone * (rest_load + self._send[:, :first] @ lead)
        for _ in range(MOST_TURNS):
            new = dgetrs(lu, pivots, damage * (lead_load + self._back @ amplitudes[first:]))[0]
            change = np.abs(new - lead).max()
            amplitudes[:first] = lead = new
            amplitudes[first:] = rest_alone * (rest_load + self._send @ amplitudes)
            if change <= SETTLED * np.abs(new).max():
                break
        return amplitudes

    def _bound(self, mu: FloatArray, amplitudes: FloatArray) -> FloatArray:
        modes = mu[self.owner].nonzero()[0]
        inverse = 1.0 / mu[self.owner[modes]]
        matrix = np.diag(inverse) - self.coupling[modes[:, None], modes]
        try:
            duals = np.asarray(np.linalg.solve(matrix.T, self.readout[:, modes].T), dtype=np.float64)
        except np.linalg.LinAlgError as error:
            raise SolveError(
                f"the reduced equations of the damages {mu.tolist()} are singular; expected a coupling below 1 / mu, "
                "as reduce_structure makes it; reduce the structure again"
            ) from error
        left = duals.T @ (self.load[modes] - matrix @ amplitudes[modes])
        bound = self.bound.bound(mu, self.owner, modes, amplitudes[modes], duals, left)
        rounding = ROUNDING * np.abs(self.pristine).max(initial=0.0) / (1.0 - mu.max(initial=0.0))
        return np.asarray(bound + rounding)


def _matrix(mu: FloatArray, coupling: FloatArray) -> FloatArray:
    """Return 1 - mu C (n, n) for modes of damages mu (n,), laid out as `coupling` is."""
    matrix = -mu[:, None] * coupling
    matrix.ravel(order="K")[:: len(mu) + 1] += 1.0
    return np.asarray(matrix)


def _together(mu: FloatArray, coupling: FloatArray, load: FloatArray) -> FloatArray:
    """Return a of (1 - mu C) a = mu b for modes of damages mu (n,)."""
    if len(mu) == 0:
        return mu
    return np.asarray(dgesv(_matrix(mu, coupling), mu * load, overwrite_a=1, overwrite_b=1)[2])


_SAVED = (
    "parameters",
    "outputs",
    "pristine",
    "owner",
    "load",
    "coupling",
    "readout",
    "interior",
    "provenance",
    "n_leading",
    "motion",
)
