"""What both comparisons of the wing with the published data share: frequencies, and the errors that none can avoid."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.data import vibration_test
from benchmarks.tables import Line
from femlib.assembly import matrix_modes, point_masses
from femlib.dataset import MeanStrains, build_dataset
from femlib.wing import Wing

Floats = NDArray[np.float64]

MASS_PLACES: Mapping[str, Mapping[float, str]] = {
    "none": {},
    "servos at 0.40 and 0.65, pitot at 0.80 of the span": {
        0.40: "mass_servo_1",
        0.65: "mass_servo_2",
        0.80: "mass_pitot",
    },
    "servos at 0.35 and 0.75, pitot at the tip": {0.35: "mass_servo_1", 0.75: "mass_servo_2", 1.0: "mass_pitot"},
}
"""Span fractions of the published point masses; their places were not published."""
SEEDS = (0, 1, 2)


def frequencies(wing: Wing) -> Iterator[Line]:
    """Yield the two lowest frequencies [Hz] without point masses and with the published ones at assumed places."""
    test, shells = vibration_test(), wing.structure.shells
    for places, names in MASS_PLACES.items():
        masses = _masses(wing, {eta: test.masses[name] for eta, name in names.items()})
        mass = shells.mass() + point_masses(shells.mesh, masses)
        modes = matrix_modes(shells.stiffness(), mass, wing.structure.supports, 6)
        ours = [modes[k].frequency for k in _flapping(wing, [mode.shape for mode in modes])[:2]]
        line = {"size": f"frequencies, point masses: {places}", "seed": 0, "places": places, "unit": "Hz"}
        yield {**line, "measured": list(test.measured), "published": list(test.model), "ours": ours}


def _flapping(wing: Wing, shapes: Sequence[Floats]) -> list[int]:
    """Return the modes whose tip moves up more than fore and aft."""
    tip_node = int(wing.grid.upper[-1, wing.grid.spar_column])
    moves = [np.abs(shape[6 * tip_node : 6 * tip_node + 3]) for shape in shapes]
    return [k for k, move in enumerate(moves) if move[2] > move[0]]


def _masses(wing: Wing, masses: Mapping[float, float]) -> dict[int, float]:
    """Return the masses at the nodes of the spar's upper cap next to their span fractions."""
    rows = {eta: int(np.abs(wing.grid.eta - eta).argmin()) for eta in masses}
    return {int(wing.grid.upper[row, wing.grid.spar_column]): masses[eta] for eta, row in rows.items()}


def least_errors(means: MeanStrains, seed: int) -> list[float]:
    """Return the share of rows [%] that the rule which knows the 25 means gets wrong, for mu1 and mu2."""
    data = build_dataset(means, seed=seed)
    square = np.square(data.features[:, None] - data.mean_features[None]).sum(axis=2)
    likely = np.exp(-0.5 * (square - square.min(axis=1, keepdims=True)) / data.noise_sd**2)
    wrong = []
    for label in data.states_percent.T:
        levels = np.unique(label)
        posterior = np.stack([likely[:, label == level].sum(axis=1) for level in levels], axis=1)
        wrong.append(100.0 * float(np.mean(levels[posterior.argmax(axis=1)] != label[data.states])))
    return wrong
