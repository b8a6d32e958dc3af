"""What `built_wing` bears with any of 28 regions damaged: the reduced model beside meshes that it was not made from."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.tables import Line, markdown
from femlib.rom.capability import drawn_states, full_needs
from femlib.wing import reduce_wing
from femlib.wing.built import built_library, built_wing, close_wing
from femlib.wing.strength import FINE_STEPS, wing_capability, wing_limits
from femlib.wing.structure import CARBON_LENGTH

PAIRS = ("R15 R20", "R14 R24")
"""Regions in one bay, drawn among those that the model's own error was not measured on."""
LOST = ((0.5, 0.0), (0.0, 0.75), (0.8, 0.8), (0.3, 0.9), (0.88, 0.65))
"""Of a pair: levels between those that the reduced model knows, and both at once, which it knows nothing of."""
N_TIMED = 200


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield one line for each state, with the same errors and CPU times of the reduced model in all of them."""
    library, watch = built_library(), Stopwatch()
    wing = built_wing(refinement=0.5, regions=library, edge_step=3.0 * CARBON_LENGTH)
    capable = wing_capability(wing, reduce_wing(wing), finer=close_wing)
    setup, times = watch.read()[0], []
    for state in drawn_states(np.random.default_rng(7), N_TIMED, len(library)):
        watch = Stopwatch()
        capable.limits(state[None])
        times.append(1e3 * watch.read()[0])
    shared = {"seed": 0, "error": capable.error, "mesh_error": capable.mesh_error, "set-up": round(setup, 1)}
    names = [region.name for region in library]
    for pair in PAIRS:
        numbers = [names.index(name) for name in pair.split()]
        wings = (close_wing(tuple(library[k] for k in numbers), step) for step in FINE_STEPS)
        once, twice = (full_needs(own.structure, wing_limits(own), own.lift, np.array(LOST)) for own in wings)
        for lost, truth in zip(LOST, 1.0 / (2.0 * twice - once).max(axis=1), strict=True):
            state = np.zeros((1, len(library)))
            state[0, numbers] = lost
            bears = float(capable.limits(state)[0, 0])
            yield {
                "size": f"{pair}: {100 * lost[0]:g}, {100 * lost[1]:g} %",
                "bears": bears,
                "refined": float(truth),
                "ms": float(np.median(times)),
                **shared,
            }


def summary(lines: Sequence[Line]) -> str:
    """Return the table, and the errors that the reduced model states."""
    rows = [
        [
            one["size"],
            f"{one['bears']:.3f}",
            f"{one['refined']:.3f}",
            f"{100 * (one['bears'] / one['refined'] - 1):.1f} %",
        ]
        for one in lines
    ]
    first = lines[0]
    told = f"error {100 * first['error']:.2f} %, mesh error {100 * first['mesh_error']:.1f} %, {first['ms']:.2f} ms"
    return f"{markdown(['lost', 'reduced', 'refined', 'error'], rows)}\n\n{told}, set-up {first['set-up']:.0f} s"
