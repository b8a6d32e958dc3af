"""The linear Gaussian model of a campaign about one assignment of states.

    y = f(z) + phi d + S theta + J dz + e_damage + eps

stacked over averaged cells and gauges. Everything but theta is Gaussian with known covariance
C0 = V/N + phi K phi' + damage nugget + J D J', so all that hypotheses need is the Gram matrix of the whitened
signatures, their projections on the residual and the evidence of no effect:

    G = S' C0^-1 S,    b = S' C0^-1 r,    log p0 = -(r' C0^-1 r + log det 2 pi C0) / 2.

Source: Woodbury's identity applied to C0 + S P S'; Rasmussen and Williams (2006), "Gaussian Processes for Machine
Learning", eq. 2.43 (basis functions with Gaussian weights).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from octmip.gap.campaign.noise import Noise
from octmip.gap.inference.difference import Rows
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.rows import Means
from octmip.gap.inference.signatures import signatures_of
from octmip.twin import Load

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

OPEN_STATE = 0.5
"""Sd of an unknown damage about its point of linearisation: wide, so that the readings decide."""
ROUNDING = 1e-10
"""Share of the difference's variance below which what a run leaves of it is lost to rounding."""
STEP = 0.01
"""Step of the damage tangents."""


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
    means
        the rows.
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
    level
        of the difference of twin and asset.
    log_run
        log evidence of the commissioning run at that level.
    """

    inputs: Inputs
    states: Floats
    means: Means
    predicted: Floats
    residual: Floats
    noise: Floats
    covariance: Floats
    factor: Floats
    signatures: Floats
    tangents: Floats
    whitened: Whitened
    open_states: OpenStates
    level: float
    log_run: float

    def __post_init__(self) -> None:
        own = (self.states, self.predicted, self.residual, self.covariance, self.factor)
        kept = (self.whitened.signatures, self.whitened.residual, self.whitened.lengths, self.whitened.projection)
        for array in (*own, self.noise, self.signatures, self.tangents, *kept):
            array.flags.writeable = False

    @property
    def average(self) -> Ints:
        """(n,) averaged cell of every row."""
        return self.means.average

    @property
    def gauge(self) -> Ints:
        """(n,) gauge of the campaign of every row."""
        return self.means.gauge

    @property
    def n(self) -> int:
        """Number of averaged readings."""
        return len(self.residual)

    @property
    def log_none(self) -> float:
        """The log evidence of no effect, that of the commissioning run included."""
        return self.whitened.log_none + self.log_run

    @property
    def cells(self) -> NDArray[np.int64]:
        """(n,) index of the campaign's cell of every row."""
        return np.array([average.cell for average in self.inputs.averages])[self.average]

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


def linearise(inputs: Inputs, states: Floats, level: float = 1.0, like: LinearModel | None = None) -> LinearModel:
    """Return the linear model about states (n_cells, n_parameters) at a level of the difference.

    With `like` under the noise of that model, which no state changes, and at its level. Signatures go with what the run
    says at level 1.
    """
    states = np.array(states)
    _ask_together(inputs, states)
    means = inputs.frame.means(inputs.campaign, inputs.averages, states, 0)
    flat = means.average * len(inputs.order) + means.gauge
    expected = means.expected + _on_grid(_given_run(inputs, 1.0, means.rows).mean, means)
    signatures, tangents = signatures_of(inputs, states, expected)[:, flat].T, _tangents(inputs, states, flat)
    if like is not None:
        known = replace(inputs, noise=like.inputs.noise)
        return _assembled(known, states, means, signatures, tangents, like.noise, like.level)
    return _assembled(inputs, states, means, signatures, tangents, _noise_of(inputs, inputs.noise, means), level)


def under(model: LinearModel, noise: Noise, level: float) -> LinearModel:
    """Return the model under another noise, at a level of the difference."""
    own = _noise_of(model.inputs, noise, model.means)
    known = replace(model.inputs, noise=noise)
    return _assembled(known, model.states, model.means, model.signatures, model.tangents, own, level)


def again(model: LinearModel, like: LinearModel, level: float | None = None) -> LinearModel:
    """Return a model under the noise of another one, at that one's level or at the given one."""
    known, at = replace(model.inputs, noise=like.inputs.noise), like.level if level is None else level
    return _assembled(known, model.states, model.means, model.signatures, model.tangents, like.noise, at)


def _noise_of(inputs: Inputs, noise: Noise, means: Means) -> Floats:
    return noise.of_averages(inputs.averages, inputs.loads, means.average, means.gauge)


def _assembled(
    inputs: Inputs, states: Floats, means: Means, signatures: Floats, tangents: Floats, own: Floats, level: float
) -> LinearModel:
    given = _given_run(inputs, level, means.rows)
    covariance = given.covariance + own + OPEN_STATE**2 * tangents @ tangents.T
    factor = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
    predicted = means.predicted + given.mean
    residual = means.measured - predicted
    whitened, open_ = _whitened(factor, signatures, residual, tangents)
    return LinearModel(
        inputs=inputs,
        states=states,
        means=means,
        predicted=predicted,
        residual=residual,
        noise=own,
        covariance=covariance,
        factor=factor,
        signatures=signatures,
        tangents=tangents,
        whitened=whitened,
        open_states=open_states_of(open_, whitened),
        level=level,
        log_run=given.log_run,
    )


def with_signatures(model: LinearModel, members: Sequence[int], columns: Floats) -> LinearModel:
    """Return the model with other signatures (n, n_members) of some candidates."""
    signatures = model.signatures.copy()
    signatures[:, list(members)] = columns
    return _rewhitened(replace(model, signatures=signatures))


def with_covariance(model: LinearModel, added: Floats) -> LinearModel:
    """Return the model with a covariance (n, n) added to C0."""
    covariance = model.covariance + added
    factor = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
    return _rewhitened(replace(model, covariance=covariance, factor=factor))


def _rewhitened(model: LinearModel) -> LinearModel:
    whitened, open_ = _whitened(model.factor, model.signatures, model.residual, model.tangents)
    return replace(model, whitened=whitened, open_states=open_states_of(open_, whitened))


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """The difference at some rows (n,), given the run: mean, covariance, and the log evidence of the run."""

    mean: Floats
    covariance: Floats
    log_run: float


def _given_run(inputs: Inputs, level: float, rows: Rows) -> Given:
    """Return the difference at some rows given what the run measured of it."""
    difference, run = inputs.difference.at(level), inputs.run
    own = difference.covariance(rows, rows)
    if run is None:
        return Given(np.zeros(len(own)), own, 0.0)
    of_run = run.means.rows
    factor = linalg.cholesky(run.noise + difference.covariance(of_run, of_run), lower=True, check_finite=False)
    stacked = np.column_stack([difference.covariance(of_run, rows), run.residual])
    white = linalg.solve_triangular(factor, stacked, lower=True, check_finite=False)
    across, left = white[:, :-1], white[:, -1]
    covariance = own - across.T @ across + np.diag(ROUNDING * np.diag(own))  # what is left may be far below what it was
    return Given(across.T @ left, covariance, _log_density(factor, left))


def difference_at(inputs: Inputs, load: Load, state: Mapping[str, float], level: float = 1.0) -> tuple[Floats, Floats]:
    """Return mean (n_gauges,) and covariance of the difference at a load and a state, given the run."""
    given = _given_run(inputs, level, inputs.frame.row_of_each_gauge(load, dict(state)))
    return given.mean, given.covariance


def whole_difference(inputs: Inputs, level: float, state: Mapping[str, float], load: Load) -> Floats:
    """Return the mean of the difference for all of the twin's gauges (n,), 0 for those that the campaign lacks."""
    found = np.zeros(len(inputs.twin.gauges))
    found[list(inputs.order)] = difference_at(inputs, load, state, level)[0]
    return found


def _on_grid(values: Floats, means: Means) -> Floats:
    found = np.zeros(means.expected.shape)
    found[means.average, means.gauge] = values
    return found


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
