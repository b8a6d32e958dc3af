"""The linear Gaussian model of a campaign about one assignment of states.

    y = f(z) + delta + S theta + J dz + eps

stacked over averaged cells and gauges. Everything but theta is Gaussian with known covariance
C0 = V / N + (delta given the run) + J D J', so all that hypotheses need is the Gram matrix of the whitened
signatures, their projections on the residual and the evidence of no effect:

    G = S' C0^-1 S,    b = S' C0^-1 r,    log p0 = -(r' C0^-1 r + log det 2 pi C0) / 2.

Source: Woodbury's identity applied to C0 + S P S'; Rasmussen and Williams (2006), "Gaussian Processes for Machine
Learning", eq. 2.43 (basis functions with Gaussian weights).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from octmip.gap.inference.inputs import Inputs, NoiseOfMeans
from octmip.gap.inference.rows import Rows
from octmip.gap.inference.signatures import signatures_of
from octmip.gap.inference.whitening import Whitening
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
class Given:
    """The difference at some rows (n,), given the run of m rows.

    Attributes
    ----------
    level
        of the difference of twin and asset.
    mean, covariance
        (n,) and (n, n).
    log_run
        log evidence of the run; 0 without one.
    """

    level: float
    mean: Floats
    covariance: Floats
    log_run: float = 0.0


@dataclass(frozen=True, eq=False)
class LinearModel:
    """The model about one assignment of states; its arrays are read only, and what is derived is made when asked for.

    Attributes
    ----------
    inputs
        what it was made of.
    states
        (n_cells, n_parameters), all known.
    rows
        the means.
    signatures
        (n, n_candidates) S.
    tangents
        (n, n_open) J of all groups' parameters.
    given
        the difference given the run.
    added
        (n, n) covariance of what is allowed for beside that, or 0.
    chords
        size at which the signature of a nonlinear candidate is its chord, by candidate.
    """

    inputs: Inputs
    states: Floats
    rows: Rows
    signatures: Floats
    tangents: Floats
    given: Given
    added: Floats | float = 0.0
    chords: Mapping[int, float] = field(default_factory=dict)

    @cached_property
    def residual(self) -> Floats:
        """(n,) readings less twin and difference, in the unit of each."""
        return _fixed(self.rows.measured - self.predicted)

    @cached_property
    def covariance(self) -> Floats:
        """(n, n) C0."""
        open_ = OPEN_STATE**2 * self.tangents @ self.tangents.T
        return _fixed(self.given.covariance + self.noise + open_ + self.added)

    @cached_property
    def whitening(self) -> Whitening:
        """C0 = L L'."""
        return Whitening.of(self.covariance)

    @cached_property
    def left(self) -> Floats:
        """(n,) L^-1 r."""
        return _fixed(self.whiten(self.residual))

    @cached_property
    def white(self) -> Floats:
        """(n, n_candidates) L^-1 S; of all that is derived this takes the most time."""
        return _fixed(self.whiten(self.signatures))

    @cached_property
    def lengths(self) -> Floats:
        """(n_candidates,) diagonal of G."""
        return _fixed(np.einsum("ij,ij->j", self.white, self.white))

    @cached_property
    def projection(self) -> Floats:
        """(n_candidates,) b."""
        return _fixed(self.white.T @ self.left)

    @cached_property
    def open(self) -> Floats:
        """(n, n_open) L^-1 J times the variance of an open state."""
        return _fixed(self.whiten(OPEN_STATE**2 * self.tangents))

    @cached_property
    def log_none(self) -> float:
        """Log p0, that of the commissioning run included."""
        return self.whitening.log_density(self.left) + self.given.log_run

    @property
    def noise(self) -> Floats:
        """(n, n) covariance of the noise alone, whatever the state."""
        return self.inputs.noise_of_means.covariance

    @property
    def scatter(self) -> Floats:
        """(n, n) the same without the unknown offsets of gauges that jumped."""
        return self.inputs.noise_of_means.scatter

    @property
    def level(self) -> float:
        """Level of the difference of twin and asset."""
        return self.given.level

    @property
    def predicted(self) -> Floats:
        """(n,) twin and difference."""
        return self.rows.predicted + self.given.mean

    @property
    def average(self) -> Ints:
        """(n,) averaged cell of every row."""
        return self.rows.average

    @property
    def gauge(self) -> Ints:
        """(n,) gauge of the campaign of every row."""
        return self.rows.gauge

    @property
    def n(self) -> int:
        """Number of averaged readings."""
        return len(self.residual)

    @property
    def cells(self) -> NDArray[np.int64]:
        """(n,) index of the campaign's cell of every row."""
        return np.array([average.number for average in self.inputs.averages])[self.average]

    @property
    def loads(self) -> tuple[Load, ...]:
        """(n,) load of every row."""
        return tuple(self.inputs.averages[k].load for k in self.average.tolist())

    def gram_rows(self, members: Sequence[int]) -> Floats:
        """Return the rows (n_members, n_candidates) of G."""
        return np.asarray(self.white[:, list(members)].T @ self.white)

    def whiten(self, columns: Floats) -> Floats:
        """Return L^-1 columns."""
        return self.whitening.of_columns(columns)

    def rest(self, members: Sequence[int], size: Floats) -> Floats:
        """Return what the candidates `members` of these sizes leave of the whitened residual (n,)."""
        return np.asarray(self.left - self.white[:, list(members)] @ size)

    @property
    def open_covariance(self) -> Floats:
        """(n_open, n_open) posterior covariance of the open states when no candidate acts."""
        return np.asarray(OPEN_STATE**2 * np.eye(self.open.shape[1]) - self.open.T @ self.open)

    def sensitivity(self, members: Sequence[int]) -> Floats:
        """Return how far open states move (n_open, n_members) per unit of each candidate's size, sign turned."""
        return np.asarray(self.open.T @ self.white[:, list(members)])

    def moved_by(self, members: Sequence[int], size: Floats) -> Floats:
        """Return how far the open states move (n_open,) when the candidates `members` have these sizes."""
        return np.asarray(self.open.T @ self.rest(members, size))

    def under(self, level: float, noise: NoiseOfMeans | None = None) -> "LinearModel":
        """Return the model at a level of the difference, under another noise if one is given; nothing is added."""
        inputs = replace(self.inputs, noise_of_means=noise or self.inputs.noise_of_means)
        return replace(self, inputs=inputs, given=_given_run(inputs, level, self.rows), added=0.0)

    def with_covariance(self, added: Floats) -> "LinearModel":
        """Return the model with a covariance (n, n) added to C0."""
        return replace(self, added=self.added + added)


def _fixed(array: Floats) -> Floats:
    """Return an array that nobody can write: models share theirs."""
    array.flags.writeable = False
    return array


def linearise(inputs: Inputs, states: Floats, level: float = 1.0) -> LinearModel:
    """Return the linear model about states (n_cells, n_parameters) at a level of the difference.

    Signatures go with what the run says at level 1.
    """
    states = np.array(states)
    _ask_together(inputs, states)
    rows = inputs.frame.rows(inputs.averages, states, 0)
    flat, usual = rows.average * len(inputs.order) + rows.gauge, _given_run(inputs, 1.0, rows)
    signatures = _fixed(signatures_of(inputs, states, missed_by(inputs, rows, usual))[:, flat].T)
    tangents = _fixed(_tangents(inputs, states, flat))
    given = usual if level == 1.0 else _given_run(inputs, level, rows)
    return LinearModel(inputs, _fixed(states), rows, signatures, tangents, given)


def missed_by(inputs: Inputs, rows: Rows, given: Given) -> Floats:
    """Return what a run says that the asset reads more than the twin before any effect (n_averages, n_gauges)."""
    missed = np.zeros((len(inputs.averages), len(inputs.order)))
    if inputs.run is not None:
        missed[rows.average, rows.gauge] = given.mean
    return missed


def _given_run(inputs: Inputs, level: float, rows: Rows) -> Given:
    """Return the difference at some rows given what the run measured of it."""
    difference, run = inputs.difference.at(level), inputs.run
    own = difference.covariance(rows, rows)
    if run is None:
        departures = np.array([departure / sd for departure, sd in inputs.open.values()])
        return Given(level, rows.constants @ departures, own + rows.constants @ rows.constants.T)
    whitening = Whitening.of(run.noise + difference.covariance(run.rows, run.rows))
    across = whitening.of_columns(difference.covariance(run.rows, rows))
    left = whitening.of_columns(run.rows.residual)
    covariance = own - across.T @ across + np.diag(ROUNDING * np.diag(own))  # what is left may be far below what it was
    return Given(level, across.T @ left, covariance, whitening.log_density(left))


def difference_at(inputs: Inputs, load: Load, state: Mapping[str, float], level: float = 1.0) -> tuple[Floats, Floats]:
    """Return mean (n_gauges,) and covariance of the difference at a load and a state, given the run."""
    given = _given_run(inputs, level, inputs.frame.row_of_each_gauge(load, state))
    return given.mean, given.covariance


def whole_difference(inputs: Inputs, level: float, state: Mapping[str, float], load: Load) -> Floats:
    """Return the mean of the difference for all of the twin's gauges (n,), 0 for those that the campaign lacks."""
    found = np.zeros(len(inputs.twin.gauges))
    found[list(inputs.order)] = difference_at(inputs, load, state, level)[0]
    return found


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
                if part.number in group:
                    rows[k] = _tangent(inputs, states[part.number], p, part.load)
            columns.append(rows.ravel()[flat])
    return np.array(columns).reshape(len(columns), len(flat)).T


def _tangent(inputs: Inputs, state: Floats, parameter: int, load: Load) -> Floats:
    """Return the change (n_gauges,) of the twin's strains per unit of one state parameter."""
    ahead = state.copy()
    ahead[parameter] += STEP
    after = inputs.twin.predict(inputs.named(ahead), load)
    return np.asarray((after - inputs.twin.predict(inputs.named(state), load)) / STEP)[list(inputs.order)]
