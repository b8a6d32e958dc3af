"""Placement over kinds of sensors: gauges, a deflection, frequencies and an inspection's result share one budget.

    python -m benchmarks.wing.kinds [--budget 4] [--refinement 0.5] [--seconds 120]

The 25 states of the study, the damage mu2 of region 2, a proven tree of depth 3 of least absolute error. A gauge costs
1, the deflection of the tip at 3 g 2, an accelerometer that gives the first three frequencies 2, and an inspection of
region 2 3. Its result is a class: nothing, slight or severe; one in ten goes to another class. These costs are assumed,
and so are the noises of deflection and frequencies.
"""

import argparse
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.main_program import run_main
from femlib.dataset.samples import study_states_percent
from femlib.mesh import DOFS_PER_NODE
from femlib.wing import Wing, uav_wing, vibrate
from octmip import ClassCosts, Limits, Problem, certify
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import by_tree, place_sensors
from octmip.trees.prediction import predict

Floats = NDArray[np.float64]
LOAD_FACTOR, STRAIN_SD = 3.0, float(np.sqrt(1000.0))
DEFLECTION_SD, FREQUENCY_SD = 0.5, 0.002
"""Standard deviation of the tip's deflection [mm], and of a frequency over itself."""
N_FREQUENCIES, DEPTH = 3, 3
MISNAMED = 0.1
"""Share of inspections whose result is another class."""
RESULTS = ("nothing", "slight", "severe")
LIMITS_OF_RESULTS = (10, 50)
"""Loss of stiffness [%] beyond which an inspection finds slight damage, and severe damage."""
COSTS = {"gauge": 1.0, "deflection": 2.0, "frequency": 2.0, "inspection": 3.0}
KINDS: tuple[tuple[str, ...], ...] = (
    ("gauge",),
    ("deflection",),
    ("frequency",),
    ("inspection",),
    ("gauge", "deflection"),
    ("gauge", "frequency"),
    ("gauge", "inspection"),
    tuple(COSTS),
)
"""Kinds that may be read together."""
N_DRAWS = 40
"""Readings of each state; a quarter of them is drawn again."""


@dataclass(frozen=True, slots=True, eq=False)
class Kind:
    """Features of one kind of sensor.

    Attributes
    ----------
    names, sensors
        of the features, and the sensor that each comes from.
    means, sd
        (25, n_features) in each state, and the noise (n_features,); of the inspection the probabilities of its classes.
    """

    names: tuple[str, ...]
    sensors: tuple[str, ...]
    means: Floats
    sd: Floats


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.kinds", description=__doc__)
    parser.add_argument("--budget", type=float, default=4.0)
    parser.add_argument("--refinement", type=float, default=0.5)
    parser.add_argument("--seconds", type=float, default=120.0, help="limit of each proof")
    options = parser.parse_args()
    kinds = measured(uav_wing(refinement=options.refinement))
    print(markdown_table([row_of(kinds, chosen, options.budget, options.seconds) for chosen in KINDS]))


def measured(wing: Wing) -> dict[str, Kind]:
    """Return what each kind of sensor reads in the 25 states."""
    states = study_states_percent() / 100.0
    named = [dict(zip(wing.parameters, row.tolist(), strict=True)) for row in states]
    strains = wing.strains_microstrain(states, LOAD_FACTOR)[:, wing.gauges.is_usable]
    gauges = tuple(name for name, usable in zip(wing.gauges.names, wing.gauges.is_usable, strict=True) if usable)
    tip = wing.grid.columns(len(wing.grid.eta) - 1)[wing.grid.spar_column]
    down = np.array([1e3 * wing.solve(state, LOAD_FACTOR).reshape(-1, DOFS_PER_NODE)[tip, 2].mean() for state in named])
    hertz = np.array([[mode.frequency for mode in vibrate(wing, state, N_FREQUENCIES)] for state in named])
    frequencies = tuple(f"frequency {k + 1}" for k in range(N_FREQUENCIES))
    return {
        "gauge": Kind(gauges, gauges, strains, np.full(len(gauges), STRAIN_SD)),
        "deflection": Kind(("tip deflection",), ("deflection",), down[:, None], np.array([DEFLECTION_SD])),
        "frequency": Kind(frequencies, ("accelerometer",) * N_FREQUENCIES, hertz, FREQUENCY_SD * hertz[0]),
        "inspection": inspected(100.0 * states[:, 1]),
    }


def inspected(lost: Floats) -> Kind:
    """Return the inspection of region 2 whose stiffness has lost so many per cent (25,)."""
    true = np.searchsorted(LIMITS_OF_RESULTS, lost)
    chances = np.full((len(lost), len(RESULTS)), MISNAMED / (len(RESULTS) - 1))
    chances[np.arange(len(lost)), true] = 1.0 - MISNAMED
    names = tuple(f"inspection finds {result}" for result in RESULTS)
    return Kind(names, ("inspection",) * len(RESULTS), chances, np.zeros(len(RESULTS)))


def drawn(kinds: Mapping[str, Kind], n: int, seed: int) -> tuple[dict[str, Floats], NDArray[np.int64]]:
    """Return n readings of each state by kind, the inspection's as one column for each class, and the states (m,)."""
    rng, state = np.random.default_rng(seed), np.repeat(np.arange(25), n)
    found = {}
    for name, kind in kinds.items():
        if name == "inspection":
            told = (rng.random((len(state), 1)) > np.cumsum(kind.means[state], axis=1)).sum(axis=1)
            found[name] = np.eye(len(RESULTS))[np.minimum(told, len(RESULTS) - 1)]
        else:
            found[name] = kind.means[state] + rng.normal(size=(len(state), len(kind.sd))) * kind.sd
    return found, state


def problem_of(kinds: Mapping[str, Kind], chosen: tuple[str, ...], budget: float) -> Problem:
    """Return the training problem whose candidates are the sensors of some kinds."""
    readings, state = drawn(kinds, N_DRAWS, 0)
    levels = np.unique(study_states_percent()[:, 1])
    cost = {sensor: COSTS[kind] for kind in chosen for sensor in kinds[kind].sensors}
    return Problem(
        np.concatenate([readings[kind] for kind in chosen], axis=1),
        study_states_percent()[state, 1],
        depth=DEPTH,
        loss=ClassCosts(np.abs(np.subtract.outer(levels, levels)).astype(float)),
        feature_names=tuple(name for kind in chosen for name in kinds[kind].names),
        sensor_of_feature=tuple(sensor for kind in chosen for sensor in kinds[kind].sensors),
        sensor_cost=cost,
        sensor_budget=budget,
    )


def row_of(kinds: Mapping[str, Kind], chosen: tuple[str, ...], budget: float, seconds: float) -> dict[str, object]:
    """Return the sensors that the best tree within the budget reads, and its error on unseen readings."""
    problem = problem_of(kinds, chosen, budget)
    found = place_sensors(problem, starts=[by_tree(problem, budget)], limits=Limits(seconds=seconds))
    certify(found.problem, found.solution)
    assert found.solution.tree is not None
    fresh, state = drawn(kinds, N_DRAWS // 4, 1)
    told = predict(found.solution.tree, np.concatenate([fresh[kind] for kind in chosen], axis=1))
    off = np.abs(np.array(problem.class_names)[told] - study_states_percent()[state, 1])
    return {
        "may read": ", ".join(chosen),
        "reads": ", ".join(found.sensors),
        "cost": found.cost,
        "MAE training %": round(found.solution.objective / problem.n_samples, 2),
        "MAE unseen %": round(float(off.mean()), 2),
        "proven": found.solution.is_optimal,
    }


if __name__ == "__main__":
    run_main(main)
