"""Filter: the belief over the library's states, carried from reading to reading.

    belief_t(s')  ~  P(reading_t | s', load_t) * sum_s  growth(s -> s')  belief_{t-1}(s)

The observation is the leaf that a tree reached (LeafLikelihood: the tree alone is asked, as on the smallest
processor), or what another `Likelihood` makes of a reading. Readings may lack gauges, or be left out altogether.

Source: L. R. Rabiner, A tutorial on hidden Markov models, Proc. IEEE 77 (1989), equation 20 (the forward recursion).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.monitor.belief import Belief
from octmip.monitor.growth import Growth, probabilities
from octmip.monitor.leaf_likelihood import check_readings
from octmip.monitor.library import Applied, Library

Floats = NDArray[np.float64]


class Likelihood(Protocol):
    """The probability of an observation in every state, as a filter needs it."""

    @property
    def library(self) -> Library:
        """The states."""
        ...

    def log_likelihood(self, readings: Floats, load_factor: float) -> Floats:
        """Return the log of the probability of what was seen in every state, shape (n, n_states), up to a constant."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Filter:
    """A hidden Markov model of the asset.

    Attributes
    ----------
    likelihood
        of a reading in every state.
    growth
        of damage in one step.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> tree = Split(0, 125.0, Leaf(0), Leaf(1))  # of the gauge g1
    >>> chain = Filter(LeafLikelihood(tree, library), steady_growth(library, rates=0.01))
    >>> belief = chain.step(chain.start(state=0), [[148, 201]], load_factor=1.0)
    >>> belief.probability.round(2).tolist()
    [[0.19, 0.81]]
    """

    likelihood: Likelihood
    growth: Growth

    def __post_init__(self) -> None:
        if self.growth.n_states != self.library.n_states:
            raise ProblemError(
                f"growth has {self.growth.n_states} states but the likelihood's library has "
                f"{self.library.n_states}; make both for one library"
            )

    @property
    def library(self) -> Library:
        """The states."""
        return self.likelihood.library

    def start(self, n: int = 1, state: int | None = None, rates: Floats | None = None) -> Belief:
        """Return the belief about n assets before any reading: in one state or in any.

        `rates` (n_rates,): probability of every growth rate, such as `learnt_rates` gives; None: all alike.
        """
        share = np.full(self.library.n_states, 1.0 / self.library.n_states)
        if state is not None:
            share = np.zeros(self.library.n_states)
            share[state] = 1.0
        n_rates = self.growth.n_rates
        chances = np.full(n_rates, 1.0 / n_rates) if rates is None else probabilities(rates, "rates", 1, n_rates)
        return Belief(self.library, np.broadcast_to(np.outer(chances, share), (n, n_rates, self.library.n_states)))

    def advance(self, belief: Belief, n_steps: int = 1) -> Belief:
        """Return the belief `n_steps` later without a reading."""
        weights = belief.weights
        for _ in range(n_steps):
            weights = self.growth.advance(weights)
        return Belief(self.library, weights)

    def observe(self, belief: Belief, readings: Floats, load_factor: Applied | Floats) -> Belief:
        """Return the belief after readings (n, n_gauges) in microstrain, NaN where missing, one row per asset.

        Parameters
        ----------
        load_factor
            known, of all readings or (n,) of each.

        Raises
        ------
        DataError
            the readings have another shape or hold an infinite number, or a load is not positive.
        """
        rows = check_readings(readings, self.library)
        loads = self.library.checked_loads(load_factor, len(rows))
        log_likelihood = np.empty((len(rows), self.library.n_states))
        for load in map(self.library.checked_load, np.unique(loads).tolist()):
            chosen = np.flatnonzero(loads == load)
            log_likelihood[chosen] = self.likelihood.log_likelihood(rows[chosen], load)
        log_likelihood -= log_likelihood.max(axis=1, keepdims=True)
        weights = belief.weights * np.exp(log_likelihood)[:, None, :]
        total = weights.sum(axis=(1, 2))[:, None, None]
        # A reading that no believed state explains says nothing of them: the belief stays, and the watch speaks up.
        is_possible = total > 0.0
        weights = np.where(is_possible, weights, belief.weights)
        return Belief(self.library, weights / np.where(is_possible, total, 1.0))

    def step(self, belief: Belief, readings: Floats, load_factor: Applied | Floats, n_steps: int = 1) -> Belief:
        """Return the belief `n_steps` later, after readings: `advance`, then `observe`."""
        return self.observe(self.advance(belief, n_steps), readings, load_factor)


def learnt_rates(rates: Floats, flights: Belief, weight: float = 1.0) -> Floats:
    """Return the probability (n_rates,) of every growth rate after flights, for `Filter.start` of the next ones.

    Parameters
    ----------
    rates
        (n_rates,) that the flights began with; it counts as `weight` flights.
    flights
        the belief about each at its end.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> belief = Belief(library, np.array([[[0.1, 0.1], [0.2, 0.6]]]))  # one flight: the second rate is likely
    >>> learnt_rates(np.array([0.5, 0.5]), belief).round(2).tolist()
    [0.35, 0.65]
    """
    return np.asarray((weight * rates + flights.rates.sum(axis=0)) / (weight + len(flights.weights)))
