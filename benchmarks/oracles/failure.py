"""Losses of every tree of depth 2 in every failure scenario, by exhaustive enumeration with numpy alone.

A tree is a root cut and, on each side, a leaf or a stump with two labels; thresholds are all values of all scenarios.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def losses(readings: list[Floats], codes: NDArray[np.int64], weights: Floats, costs: Floats) -> Floats:
    """Return (n_trees, n_scenarios) weighted costs, from the readings (n, p) of each scenario."""
    cuts = [(j, t) for j in range(readings[0].shape[1]) for t in np.unique(np.concatenate([r[:, j] for r in readings]))]
    found = [_options(readings, codes, weights, costs, cuts, [np.ones(len(codes), bool)] * len(readings))]
    for j, t in cuts:
        left = [r[:, j] <= t for r in readings]
        sides = [_options(readings, codes, weights, costs, cuts, side) for side in (left, [~k for k in left])]
        found.append((sides[0][:, None, :] + sides[1][None, :, :]).reshape(-1, len(readings)))
    return np.concatenate(found)


def _options(
    readings: list[Floats],
    codes: NDArray[np.int64],
    weights: Floats,
    costs: Floats,
    cuts: list[tuple[int, float]],
    inside: list[NDArray[np.bool_]],
) -> Floats:
    """Return the losses of every leaf and stump on the samples that are `inside` in each scenario."""

    def leaf(masks: list[NDArray[np.bool_]]) -> Floats:
        return np.array([[(weights[m] * costs[codes[m], k]).sum() for m in masks] for k in range(len(costs))])

    rows = [leaf(inside)]
    for j, t in cuts:
        left = leaf([i & (r[:, j] <= t) for i, r in zip(inside, readings, strict=True)])
        right = leaf([i & (r[:, j] > t) for i, r in zip(inside, readings, strict=True)])
        rows.append((left[:, None, :] + right[None, :, :]).reshape(-1, len(readings)))
    return np.concatenate(rows)
