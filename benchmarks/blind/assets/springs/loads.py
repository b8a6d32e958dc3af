"""Loads of the wing of bricks: lift after Schrenk and other lifts, a torque, masses, warmth."""

import numpy as np

from benchmarks.blind.assets.springs.solids import LINES, WEB, Shape, Solids
from femlib.arrays import FloatArray

WEIGHT = 25.0 * 9.81 / 2.0
"""Half the weight at load factor 1 [N]: the study's."""
GRAVITY = 9.80665
FINE = 2000
LIFT_KINDS = ("ellipse", "aileron", "tip vortex")


def lift(wing: Solids, shape: Shape) -> FloatArray:
    """Return the vertical forces (n_nodes,) of the lift at load factor 1 [N].

    Source: Schrenk (1940), NACA TM 948: half-way from the chord to the ellipse.
    """
    eta = (np.arange(FINE) + 0.5) / FINE
    return spread(wing, WEIGHT * 0.5 * (_ellipse(eta) + shape.chord(eta) / shape.chord(eta).mean()), pressure())


def _ellipse(eta: FloatArray) -> FloatArray:
    return np.asarray(4.0 / np.pi * np.sqrt(1.0 - eta**2))


def pressure(aft: float = 0.0) -> FloatArray:
    """Return the shares (n_lines,) of a lift on the upper lines, its middle at the quarter chord or `aft` of it."""
    x = np.array(LINES)
    share = (1.0 - x / x[0]) ** 1.6 * -np.gradient(x)
    share = share / share.sum()
    bent = share * (x - share @ x)
    return np.asarray(share + bent * (0.25 + aft - share @ x) / (bent @ x))


def spread(wing: Solids, density: FloatArray, share: FloatArray) -> FloatArray:
    """Return the forces (n_nodes,) of a density (FINE,) over the span fraction, shared among the upper lines."""
    eta = (np.arange(FINE) + 0.5) / FINE
    inner = np.clip(np.searchsorted(wing.stations, eta) - 1, 0, len(wing.stations) - 2)
    outward = (eta - wing.stations[inner]) / (wing.stations[inner + 1] - wing.stations[inner])
    line = np.bincount(inner, density * (1.0 - outward) / FINE, len(wing.stations))
    line = line + np.bincount(inner + 1, density * outward / FINE, len(wing.stations))
    force = np.zeros(len(wing.nodes))
    force[wing.outer[:, : len(LINES)]] = line[:, None] * share
    return force


def force(wing: Solids, shape: Shape, name: str) -> FloatArray:
    """Return the vertical forces (n_nodes,) at load factor 1 of a named field, per unit of its size."""
    kind, _, place = name.partition(":")
    if kind == "lift_distribution":
        return _other(wing, shape, place)
    if kind == "torsion":
        eta = (np.arange(FINE) + 0.5) / FINE
        own = WEIGHT * 0.5 * (_ellipse(eta) + shape.chord(eta) / shape.chord(eta).mean())
        return spread(wing, own, pressure(0.01) - pressure())
    near = np.abs(wing.stations - float(place)).argmin()
    load = np.zeros(len(wing.nodes))
    at = LINES.index(WEB)
    load[wing.outer[near, at - 1 : at + 2]] = -GRAVITY / 3.0
    return load


def _other(wing: Solids, shape: Shape, kind: str) -> FloatArray:
    """Return a lift of total zero that adds one per cent to the root's bending moment.

    ellipse: from Schrenk to the ellipse; aileron: an outer flap, up; tip vortex: suction on the outer tenth.
    """
    eta = (np.arange(FINE) + 0.5) / FINE
    own = 0.5 * (_ellipse(eta) + shape.chord(eta) / shape.chord(eta).mean())
    added = {
        "ellipse": _ellipse(eta),
        "aileron": np.where((eta > 0.6) & (eta < 0.92), shape.chord(eta), 0.0),
        "tip vortex": np.exp(-(((eta - 1.0) / 0.12) ** 2)),
    }[kind]
    shape_ = added - own * added.mean() / own.mean()
    moment = WEIGHT * float(own @ eta) / FINE
    return spread(wing, 0.01 * moment * shape_ / (float(shape_ @ eta) / FINE), pressure())


def warming(wing: Solids, name: str) -> FloatArray:
    """Return the temperatures (n_nodes,) of one kelvin: everywhere, or between the skins with the inside at rest."""
    if name == "temperature_uniform":
        return np.ones(len(wing.nodes))
    warm = np.zeros(len(wing.nodes))
    n = len(LINES)
    for sheet in (wing.outer, wing.outer + wing.outer.size):
        warm[sheet[:, : n - 1]], warm[sheet[:, n:]] = 0.5, -0.5
    return warm
