"""Lift of the wing by Prandtl's lifting line, and other lifts beside it.

The circulation of a symmetric wing is 2 b V sum A_n sin(n theta), n odd, y = b cos(theta), and at every station
sum A_n (sin(n theta) + n mu sin(n theta) / sin(theta)) = mu alpha, mu = 2 pi c / (8 b).
Source: Glauert (1926), The Elements of Aerofoil and Airscrew Theory, chapter XI.
"""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.assets.beam.strips import Card
from femlib.arrays import FloatArray

TERMS = 16
FINE = 2000
WEIGHT = 25.0 * 9.81 / 2.0
"""Half the weight at load factor 1 [N]: the study's."""
AFT = -0.05
"""Place of the lift in chords aft of the web: the quarter chord."""
Twist = Callable[[FloatArray], FloatArray]


def lifting_line(card: Card, twist: Twist = np.ones_like) -> Callable[[FloatArray], FloatArray]:
    """Return the lift per length over span fractions where sections stand at the angles `twist`, any scale."""
    theta = np.pi / 2.0 * (np.arange(TERMS) + 1.0) / TERMS
    n = 2.0 * np.arange(TERMS) + 1.0
    eta = np.cos(theta)
    mu = (2.0 * np.pi * card.chord(eta) / (8.0 * card.span))[:, None]
    sines = np.sin(np.outer(theta, n))
    amounts = np.linalg.solve(sines * (1.0 + mu * n / np.sin(theta)[:, None]), mu[:, 0] * twist(eta))
    return lambda at: np.asarray(np.sin(np.outer(np.arccos(np.clip(at, 0.0, 1.0)), n)) @ amounts)


def at_stations(eta: FloatArray, density: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Return the forces (n_stations,) of a density over the span fraction: each station carries its half bays."""
    fine = (np.arange(FINE) + 0.5) / FINE
    inner = np.clip(np.searchsorted(eta, fine) - 1, 0, len(eta) - 2)
    outward = (fine - eta[inner]) / (eta[inner + 1] - eta[inner])
    amount = density(fine) / FINE
    force = np.bincount(inner, amount * (1.0 - outward), len(eta))
    return np.asarray(force + np.bincount(inner + 1, amount * outward, len(eta)))


def own_lift(card: Card, eta: FloatArray) -> FloatArray:
    """Return the lift (n_stations,) [N] at load factor 1."""
    force = at_stations(eta, lifting_line(card))
    return np.asarray(WEIGHT * force / force.sum())


def other_lift(card: Card, eta: FloatArray, kind: str) -> FloatArray:
    """Return a lift (n_stations,) [N] of total zero that adds one per cent to the root's bending moment.

    washout: the tip turned nose down; flap: the inner half drooped; gust: an angle that grows with the square.
    """
    twists: dict[str, Twist] = {
        "washout": lambda y: -y,
        "flap": lambda y: np.where(y < 0.5, 1.0, 0.0),
        "gust": lambda y: y**2,
    }
    own = own_lift(card, eta)
    shape = at_stations(eta, lifting_line(card, twists[kind]))
    shape = shape - own * shape.sum() / own.sum()
    return np.asarray(shape * (0.01 * (own @ eta) / (shape @ eta)))


LIFT_KINDS = ("washout", "flap", "gust")
