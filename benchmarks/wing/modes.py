"""The reduced model of the wing's natural frequencies beside the full model, 28 damage regions.

python -m benchmarks.wing.modes [--refinement R] [--states N]

Prints Markdown: how far the frequencies lie above the full model's and the lower bounds below, over random states.
"""

import argparse
import time

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.main_program import run_main
from benchmarks.wing.damages import random_states
from femlib.rom import reduce_modes
from femlib.wing import mass_matrix, uav_wing, vibrate
from femlib.wing.damage import damage_library

N_MODES = 4
MOST = 0.9
DAMAGED = (1, 2, 3, 8, 28)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.modes", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.35)
    parser.add_argument("--states", type=int, default=10, help="random states of each kind")
    options = parser.parse_args()
    wing = uav_wing(refinement=options.refinement, regions=damage_library())
    watch = Stopwatch()
    model = reduce_modes(wing.structure, mass_matrix(wing), N_MODES)
    print(f"{model.basis.shape[1]} vectors, {watch.read()[0]:.0f} CPU s to make\n")
    print("| regions damaged | too high, at most | bound too low: median, 90 %, at most | a state, its bounds, ms |")
    print("|---|---|---|---|")
    rng = np.random.default_rng(3)
    for n_damaged in DAMAGED:
        states = random_states(rng, options.states, len(wing.parameters), n_damaged, MOST)
        begin = time.perf_counter()
        above = model.frequencies(states)
        middle = time.perf_counter()
        below = model.lower_bounds(states)
        spent = 1e3 * np.diff([begin, middle, time.perf_counter()]) / len(states)
        named = [dict(zip(wing.parameters, row, strict=True)) for row in states.tolist()]
        truth = np.array([[mode.frequency for mode in vibrate(wing, state, N_MODES)] for state in named])
        low, middle_low, most_low = np.quantile(1.0 - below / truth, [0.5, 0.9, 1.0])
        assert (below <= truth).all()
        print(
            f"| {n_damaged} | {(above / truth - 1.0).max():.1e} | {low:.1e}, {middle_low:.1e}, {most_low:.1e} | "
            f"{spent[0]:.1f}, {spent[1]:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    run_main(main)
