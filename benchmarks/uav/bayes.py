"""The Bayes limit: the least error that any classifier can reach with these gauges and this noise.

A reading is x = m_s + e with the state s drawn uniformly from the library, m_s its mean strains and
e ~ N(0, sd^2 I). The best decision for a loss is the one of least posterior expected loss: the class of the largest
posterior for misclassification, the posterior median for the absolute error. Their expected losses are estimated by
drawing readings, so each comes with its standard error.
Source: Duda, Hart & Stork, Pattern Classification (2001), section 2.2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax


@dataclass(frozen=True, slots=True)
class BayesLimit:
    """Least expected error rate and least expected absolute error, with their standard errors."""

    error_rate: float
    mae: float
    error_rate_se: float
    mae_se: float


def bayes_limit(
    means: NDArray[np.float64],
    levels: NDArray[np.float64],
    noise_sd: float,
    rng: np.random.Generator,
    n_draws: int = 4000,
) -> BayesLimit:
    """Return the Bayes limit of reading `levels` from noisy `means`.

    Parameters
    ----------
    means
        (n_states, n_gauges) mean reading in each state.
    levels
        (n_states,) value to be told in each state (percent loss of stiffness).
    noise_sd
        standard deviation of the noise, in the unit of `means`.
    n_draws
        readings drawn in each state.
    """
    values, class_of_state = np.unique(levels, return_inverse=True)
    states = np.repeat(np.arange(len(means)), n_draws)
    readings = means[states] + rng.normal(0.0, noise_sd, (len(states), means.shape[1]))
    posterior = class_posterior(readings, means, noise_sd, class_of_state, len(values))
    truth = levels[states]
    is_wrong = values[posterior.argmax(axis=1)] != truth
    median = values[(np.cumsum(posterior, axis=1) >= 0.5).argmax(axis=1)]
    deviation = np.abs(median - truth)
    root_n = np.sqrt(len(states))
    return BayesLimit(
        float(is_wrong.mean()),
        float(deviation.mean()),
        float(is_wrong.std() / root_n),
        float(deviation.std() / root_n),
    )


def class_posterior(
    readings: NDArray[np.float64],
    means: NDArray[np.float64],
    noise_sd: float,
    class_of_state: NDArray[np.int64],
    n_classes: int,
) -> NDArray[np.float64]:
    """Return (n_readings, n_classes): the posterior of every state, summed over the states of a class."""
    # |x - m|^2 without its |x|^2, which is the same for every state.
    log_likelihood = (readings @ means.T - 0.5 * (means**2).sum(axis=1)) / noise_sd**2
    of_state = softmax(log_likelihood, axis=1)
    return np.stack([of_state[:, class_of_state == k].sum(axis=1) for k in range(n_classes)], axis=1)
