"""The linear Gaussian model of a campaign about one assignment of states.

    y = f(z) + phi d + S theta + J dz + e_damage + eps

stacked over averaged cells and gauges. Everything but theta is Gaussian with known covariance
C0 = V/N + phi K phi' + damage nugget + J D J', so all that hypotheses need is the Gram matrix of the whitened
signatures, their projections on the residual and the evidence of no effect:

    G = S' C0^-1 S,    b = S' C0^-1 r,    log p0 = -(r' C0^-1 r + log det 2 pi C0) / 2.

Source: Woodbury's identity applied to C0 + S P S'; Rasmussen and Williams (2006), "Gaussian Processes for Machine
Learning", eq. 2.43 (basis functions with Gaussian weights).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.signatures import signatures_of
from octmip.twin import Load

Floats = NDArray[np.float64]

OPEN_STATE = 0.5
"""Sd of an unknown damage about its point of linearisation: wide, so that the readings decide."""
STEP = 0.01
"""Step of the damage tangents."""
OWN_STATE = 0.7
"""Share of the damage nugget's sd that is common to all states of one gauge; the rest is each state's own."""
ALL_GAUGES = 0.3
"""Share of the damage nugget's variance that is common to all gauges: a damage that acts more, or less, as a whole."""


@dataclass(frozen=True, slots=True, eq=False)
class Whitened:
    """Signatures and residual in units of C0's Cholesky factor.

    Attributes
    ----------
    signatures
        (n, n_candidates) factor^-1 S.
    residual
        (n,) factor^-1 r.
    log_none
        log p0.
    Derived:
        lengths: (n_candidates,) diagonal of G.
        projection: (n_candidates,) b.
    """

    signatures: Floats
    residual: Floats
    log_none: float
    lengths: Floats = field(init=False)
    projection: Floats = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "lengths", np.einsum("ij,ij->j", self.signatures, self.signatures))
        object.__setattr__(self, "projection", self.signatures.T @ self.residual)

    @property
    def gram(self) -> Floats:
        """The whole of G (n_candidates, n_candidates): expensive, `gram_rows` gives the rows that are needed."""
        return self.gram_rows(range(self.signatures.shape[1]))

    def gram_rows(self, members: Sequence[int]) -> Floats:
        """Return the rows (n_members, n_candidates) of G."""
        return np.asarray(self.signatures[:, list(members)].T @ self.signatures)


@dataclass(frozen=True, slots=True, eq=False)
class OpenStates:
    """Posterior of the unknown states, about the point of linearisation.

    Attributes
    ----------
    sensitivity
        (n_open, n_candidates) how far they move per unit of each candidate's size, sign turned.
    shift
        (n_open,) how far they move when no candidate acts.
    covariance
        (n_open, n_open) when no candidate acts.
    """

    sensitivity: Floats
    shift: Floats
    covariance: Floats

    def moved_by(self, members: Sequence[int], size: Floats) -> Floats:
        """Return how far the open states move (n_open,) when the candidates `members` have these sizes."""
        return np.asarray(self.shift - self.sensitivity[:, list(members)] @ size)


@dataclass(frozen=True, slots=True, eq=False)
class LinearModel:
    """The model about one assignment of states; all its arrays are read only.

    Attributes
    ----------
    inputs
        what it was made of.
    states
        (n_cells, n_parameters), all known.
    average, gauge
        (n,) indices of every row: averaged cell and gauge of the campaign.
    predicted
        (n,) twin and discrepancy [microstrain].
    residual
        (n,) readings less `predicted` [microstrain].
    noise
        (n, n) covariance of the noise alone, whatever the state.
    covariance
        (n, n) C0 [microstrain^2].
    factor
        (n, n) lower Cholesky factor of C0.
    signatures
        (n, n_candidates) S.
    tangents
        (n, n_open) J of all groups' parameters.
    whitened
        signatures and residual in units of `factor`.
    open_states
        what the readings say of the unknown states.
    share, change
        (n,) size of the healthy prediction relative to the reference load's, and what damage changes in the prediction.
    """

    inputs: Inputs
    states: Floats
    average: NDArray[np.int64]
    gauge: NDArray[np.int64]
    predicted: Floats
    residual: Floats
    noise: Floats
    covariance: Floats
    factor: Floats
    signatures: Floats
    tangents: Floats
    whitened: Whitened
    open_states: OpenStates
    share: Floats
    change: Floats

    def __post_init__(self) -> None:
        own = (self.states, self.average, self.gauge, self.predicted, self.residual, self.covariance, self.factor)
        kept = (self.whitened.signatures, self.whitened.residual, self.whitened.lengths, self.whitened.projection)
        for array in (*own, self.noise, self.signatures, self.tangents, *kept):
            array.flags.writeable = False

    @property
    def n(self) -> int:
        """Number of averaged readings."""
        return len(self.residual)

    @property
    def log_none(self) -> float:
        """The log evidence of no effect."""
        return self.whitened.log_none

    @property
    def cells(self) -> NDArray[np.int64]:
        """(n,) index of the campaign's cell of every row."""
        return np.array([average.cell for average in self.inputs.averages])[self.average]

    @property
    def load_factors(self) -> Floats:
        """(n,) the one load of every row, where the campaign has one."""
        cells = self.inputs.campaign.cells
        return np.array([cells[k].load_factor for k in self.cells.tolist()])

    @property
    def loads(self) -> tuple[Load, ...]:
        """(n,) load of every row."""
        of_average = self.inputs.loads
        return tuple(of_average[k] for k in self.average.tolist())

    def whiten(self, columns: Floats) -> Floats:
        """Return factor^-1 columns."""
        return np.asarray(linalg.solve_triangular(self.factor, columns, lower=True, check_finite=False))

    def rest(self, members: Sequence[int], size: Floats) -> Floats:
        """Return what the candidates `members` of these sizes leave of the whitened residual (n,)."""
        return np.asarray(self.whitened.residual - self.whitened.signatures[:, list(members)] @ size)


def linearise(inputs: Inputs, states: Floats) -> LinearModel:
    """Return the linear model about states (n_cells, n_parameters)."""
    states = np.array(states)
    _ask_together(inputs, states)
    average, gauge = _recorded(inputs)
    flat = average * len(inputs.order) + gauge
    strain, healthy = _predictions(inputs, states)
    share = _healthy_shares(inputs, healthy)
    expected = strain + share[:, None] * inputs.discrepancy.mean
    predicted = expected.ravel()[flat]
    residual = np.array([part.mean for part in inputs.averages]).ravel()[flat] - predicted
    tangents = _tangents(inputs, states, flat)
    rows, change = (average, gauge), (strain - healthy).ravel()[flat]
    noise = inputs.noise.of_averages(inputs.averages, inputs.loads, average, gauge)
    covariance = _covariance(inputs, states, rows, share[average], change, tangents, noise)
    factor = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
    signatures = signatures_of(inputs, states, expected)[:, flat].T
    whitened, open_ = _whitened(factor, signatures, residual, tangents)
    return LinearModel(
        inputs=inputs,
        states=states,
        average=average,
        gauge=gauge,
        predicted=predicted,
        residual=residual,
        noise=noise,
        covariance=covariance,
        factor=factor,
        signatures=signatures,
        tangents=tangents,
        whitened=whitened,
        open_states=open_states_of(open_, whitened),
        share=share[average],
        change=change,
    )


def at_level(model: LinearModel, level: float, wide: tuple[int, ...] = ()) -> LinearModel:
    """Return the model at another level of differences between models, some gauges wide: another covariance."""
    inputs = replace(model.inputs, discrepancy=model.inputs.discrepancy.at(level, wide))
    rows = (model.average, model.gauge)
    covariance = _covariance(inputs, model.states, rows, model.share, model.change, model.tangents, model.noise)
    if np.array_equal(covariance, model.covariance):
        return replace(model, inputs=inputs)
    factor = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
    whitened, open_ = _whitened(factor, model.signatures, model.residual, model.tangents)
    return replace(
        model,
        inputs=inputs,
        covariance=covariance,
        factor=factor,
        whitened=whitened,
        open_states=open_states_of(open_, whitened),
    )


def log_none_at(model: LinearModel, level: float) -> float:
    """Return the log evidence of no effect at another level: a small part of what `at_level` makes."""
    discrepancy = model.inputs.discrepancy.at(level, ())
    rows = (model.average, model.gauge)
    own = replace(model.inputs, discrepancy=discrepancy)
    covariance = _covariance(own, model.states, rows, model.share, model.change, model.tangents, model.noise)
    factor = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
    return _log_density(factor, linalg.solve_triangular(factor, model.residual, lower=True, check_finite=False))


def tail_of(model: LinearModel, gauge: int) -> Floats:
    """Return a whitened root (n, r) of what the covariance gains where a gauge is wide, or nearly so: one state's."""
    known = model.inputs.discrepancy
    here = model.gauge == gauge
    columns = [np.where(here, known.usual.wide_damage * known.level * model.change, 0.0)]
    if not known.is_calibrated:
        columns.append(np.where(here, known.usual.wide_own * known.healthy[gauge] * model.share, 0.0))
    return model.whiten(np.column_stack(columns))


def open_states_of(open_: Floats, whitened: Whitened) -> OpenStates:
    """Return what readings say of the open states whose whitened tangents, times their variance, are (n, n_open)."""
    covariance = OPEN_STATE**2 * np.eye(open_.shape[1]) - open_.T @ open_
    return OpenStates(open_.T @ whitened.signatures, open_.T @ whitened.residual, covariance)


def _whitened(factor: Floats, signatures: Floats, residual: Floats, tangents: Floats) -> tuple[Whitened, Floats]:
    """Return signatures and residual whitened, and the open states' tangents whitened, times their variance."""
    stacked = np.column_stack([signatures, residual, OPEN_STATE**2 * tangents])
    stacked = linalg.solve_triangular(factor, stacked, lower=True, overwrite_b=True, check_finite=False)
    white, last, open_ = np.split(stacked, [signatures.shape[1], signatures.shape[1] + 1], axis=1)
    left = last[:, 0]
    return Whitened(white, left, _log_density(factor, left)), open_


def _log_density(factor: Floats, white: Floats) -> float:
    """Return the log density of a normal residual, whitened (n,) by the Cholesky factor of its covariance."""
    log_det = float(np.log(np.diag(factor)).sum())
    return -0.5 * float(white @ white) - log_det - 0.5 * len(white) * float(np.log(2 * np.pi))


def _ask_together(inputs: Inputs, states: Floats) -> None:
    """Ask the twin once for open states and their tangents' ends: a batch costs little more than one state."""
    for group in inputs.groups:
        state = states[group[0]]
        ahead = state + STEP * np.eye(len(state))
        for load in dict.fromkeys(inputs.campaign.cells[k].load for k in group):
            inputs.twin.predict_states(np.vstack([state, ahead]), load)


def _recorded(inputs: Inputs) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return averaged cell and gauge (n,) of every mean that was recorded."""
    average, gauge = np.nonzero(np.array([part.count > 0 for part in inputs.averages]))
    return average.astype(np.int64), gauge.astype(np.int64)


def _predictions(inputs: Inputs, states: Floats) -> tuple[Floats, Floats]:
    """Return the twin's strains (n_averages, n_gauges) in the given states and in the healthy state."""
    order, twin = list(inputs.order), inputs.twin
    parts = [(part.cell, inputs.cell_of(part).load) for part in inputs.averages]
    now = [twin.predict(inputs.named(states[cell]), load) for cell, load in parts]
    healthy = [twin.predict({}, load) for _, load in parts]
    return np.array(now)[:, order], np.array(healthy)[:, order]


def _healthy_shares(inputs: Inputs, healthy: Floats) -> Floats:
    """Return phi (n_averages,): the healthy strains relative to those at the reference load."""
    reference = inputs.twin.predict({}, inputs.reference)[list(inputs.order)]
    return np.array([inputs.discrepancy.share(row, reference) for row in healthy])


def _covariance(
    inputs: Inputs,
    states: Floats,
    rows: tuple[NDArray[np.int64], NDArray[np.int64]],
    share: Floats,
    change: Floats,
    tangents: Floats,
    noise: Floats,
) -> Floats:
    """Return C0 (n, n); `rows` are averaged cell and gauge, the others as in the model."""
    average, gauge = rows
    covariance = noise + np.outer(share, share) * inputs.discrepancy.covariance[np.ix_(gauge, gauge)]
    cell = np.array([part.cell for part in inputs.averages])[average]
    tails = inputs.discrepancy.damage_tails(gauge)
    covariance += _damage_nugget(inputs.discrepancy.damage * change, tails * change, gauge, states, cell)
    covariance += OPEN_STATE**2 * tangents @ tangents.T
    return covariance


def _damage_nugget(
    sd: Floats, tails: Floats, gauge: NDArray[np.int64], states: Floats, cell: NDArray[np.int64]
) -> Floats:
    """Return the covariance of errors of these sd (n,) in what damage changes: in common, per gauge, partly per state.

    The states (n_cells, n_parameters) are those of the cells, `cell` (n,) is that of each row; a `sd` has the sign of
    the change. `tails` (n,) are the sd of wide gauges' own part.
    """
    same_state = (states[:, None, :] == states[None, :, :]).all(axis=2)
    shared = OWN_STATE**2 + (1.0 - OWN_STATE**2) * same_state
    nugget = np.outer(sd, sd) * alike_gauges(gauge)
    if tails.any():
        nugget += np.outer(tails, tails) * (gauge[:, None] == gauge[None, :])
    return np.asarray(nugget * shared[np.ix_(cell, cell)])


def alike_gauges(gauge: NDArray[np.int64]) -> Floats:
    """Return the correlation (n, n) of errors of what damage changes at the gauges of some rows, in one state."""
    return np.asarray(np.where(gauge[:, None] == gauge[None, :], 1.0, ALL_GAUGES))


def _tangents(inputs: Inputs, states: Floats, flat: NDArray[np.int64]) -> Floats:
    """Return J (n, n_open): what the parameters of each group change in its own rows."""
    columns = []
    for group in inputs.groups:
        for p in range(len(inputs.names)):
            rows = np.zeros((len(inputs.averages), len(inputs.order)))
            for k, part in enumerate(inputs.averages):
                if part.cell in group:
                    rows[k] = _tangent(inputs, states[part.cell], p, inputs.cell_of(part).load)
            columns.append(rows.ravel()[flat])
    return np.array(columns).reshape(len(columns), len(flat)).T


def _tangent(inputs: Inputs, state: Floats, parameter: int, load: Load) -> Floats:
    """Return the change (n_gauges,) of the twin's strains per unit of one state parameter."""
    ahead = state.copy()
    ahead[parameter] += STEP
    after = inputs.twin.predict(inputs.named(ahead), load)
    return np.asarray((after - inputs.twin.predict(inputs.named(state), load)) / STEP)[list(inputs.order)]
