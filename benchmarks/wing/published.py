"""The fit of `femlib.wing.uav_wing` to the published data, and what it predicts of readings that it did not see.

    python -m benchmarks.wing.published [--refinement R] [--draws 3]

Strains of the undamaged wing and of 40 and 80 % loss in either region (increments), tip stiffness, weight and both
measured frequencies are fitted; the levels 20 and 60 % never are. Each draw holds out six of the 20 gauges besides.
The regions' edges are lines of the mesh and stay. Prints Markdown.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.cpu import Stopwatch
from benchmarks.data import SHARED, tip_test, vibration_test
from benchmarks.main_program import run_main
from benchmarks.wing.design import EDGES, WingDesign
from femlib.calibration import (
    Calibration,
    FrequencyReading,
    MassReading,
    Observation,
    OutputReading,
    Parameter,
    calibrate,
)
from femlib.dataset import MeanStrains, published_strains
from femlib.wing import uav_wing

Floats = NDArray[np.float64]
LEVELS = (20, 40, 60, 80)
UNSEEN = ("mu1 20 %", "mu2 20 %", "mu1 60 %", "mu2 60 %")
N_HELD_OUT = 6
PRISTINE_SD, INCREMENT_SD = 0.015, 0.03
"""Standard deviations: share of each pristine strain, and share of the largest increment of the 20 gauges."""
INSIDE_SD = 0.1
LEFT_OUT_SD = 1e6
"""Standard deviation [microstrain] of the four gauges that the study leaves out: predicted, never fitted."""
TIP_SD, FREQUENCY_SD = 0.005, 0.03
WEIGHT, WEIGHT_SD = 2.3, 0.25
"""Weight of the half wing's structure [kg]: estimated, none was published."""
MASSES = {0.40: "mass_servo_1", 0.65: "mass_servo_2", 0.80: "mass_pitot"}
"""Span fractions of the published point masses, assumed."""

PARAMETERS = (
    Parameter("skin", 1.38, 0.05, 20.0, is_log=True, meaning="factor on all moduli"),
    Parameter("rise", 3.17, -3.0, 6.0, meaning="growth of the skin's modulus along the span, exp(rise (eta - 1/2))"),
    Parameter("step", 0.262, 0.05, 3.0, is_log=True, meaning="skin's modulus outboard of mid-span over inboard"),
    Parameter("rib", 2.57, 0.1, 50.0, 5.0, 0.8, is_log=True, meaning="factor on the ribs' modulus"),
    Parameter("web", 2.2, 0.1, 20.0, 2.1, 0.8, is_log=True, meaning="factor on the web's modulus"),
    Parameter("mass", 32.4, 5.0, 60.0, is_log=True, meaning="effective mass at load factor 1 [kg]"),
    Parameter("front_in", 0.2898, 0.26, 0.32, 0.293, 0.01, meaning="first gauge of the front row, eta"),
    Parameter("front_out", 0.5922, 0.57, 0.62, 0.594, 0.01, meaning="first gauge of its outboard half, eta"),
    Parameter("rear_in", 0.2983, 0.26, 0.33, 0.308, 0.01, meaning="first gauge of the rear row, eta"),
    Parameter("rear_out", 0.5994, 0.57, 0.63, 0.600, 0.01, meaning="first gauge of its outboard half, eta"),
    Parameter(
        "pitch", 0.01716, 0.014, 0.022, 0.0167, 0.002, meaning="pitch of the front row, half the rear row's, eta"
    ),
    Parameter("x_front", 0.2216, 0.12, 0.29, 0.22, 0.03, meaning="front row, x/c"),
    Parameter("x_rear", 0.3459, 0.305, 0.6, 0.35, 0.03, meaning="rear row, x/c"),
    Parameter("density", 0.916, 0.3, 3.0, 1.0, 0.3, is_log=True, meaning="factor on the skin's density"),
)


def main() -> None:
    """Fit, hold out, print."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.published", description=__doc__)
    parser.add_argument("--refinement", type=float, default=1.0)
    parser.add_argument("--draws", type=int, default=3)
    options = parser.parse_args()
    watch, table = Stopwatch(), published_strains(SHARED / "uav" / "strains.csv")
    structure, seen = wing_design(options.refinement), observations(table)
    everything = calibrate(structure, PARAMETERS, seen, UNSEEN)
    print(
        "\n".join(values(everything)),
        "\n\n| held out | gauges | pristine | mu1 20 / 40 / 60 / 80 % | mu2 |\n|---|---|---|---|---|",
    )
    print(row("none", everything, table.is_usable))
    warm = [replace(p, start=everything[p.name]) for p in PARAMETERS]
    for seed in range(options.draws):
        chosen = np.random.default_rng(seed).choice(np.flatnonzero(table.is_usable), N_HELD_OUT, replace=False)
        held = np.isin(np.arange(len(table.gauges)), chosen)
        names = [table.gauges[k] for k in np.sort(chosen)]
        fit = calibrate(structure, warm, seen, [*UNSEEN, *names])
        print(row(f"seed {seed}: {', '.join(names)}", fit, held), flush=True)
    print(f"\n{watch.read()[0]:.0f} CPU s, {everything.n_predictions} predictions of the first fit")


def wing_design(refinement: float) -> WingDesign:
    """Return the wing's mesh with parameters and the states of one damaged region."""
    wing = uav_wing(refinement=refinement)
    edges = {n: e for r in wing.regions for n, e in zip(EDGES[r.parameter], (r.chord_min, r.chord_max), strict=True)}
    return WingDesign(wing, one_region_states(), edges, measured_masses())


def one_region_states() -> dict[str, tuple[str, float]]:
    """Return damage parameter and loss of the published states of one damaged region, the undamaged one first."""
    damaged = {f"{name} {level} %": (name, level / 100.0) for name in EDGES for level in LEVELS}
    return {"sound": ("", 0.0), **damaged}


def measured_masses() -> dict[float, float]:
    """Return the published point masses [kg] by span fraction."""
    test = vibration_test()
    return {eta: test.masses[name] for eta, name in MASSES.items()}


def observations(table: MeanStrains, is_all_fitted: bool = False) -> list[Observation]:
    """Return strains, increments, tip compliance, frequencies and weight with their standard deviations.

    With `is_all_fitted` the four gauges in or near a region count too, by `INSIDE_SD` of their own increments besides.
    """
    usable = table.is_usable
    sound = _state(table, "", 0)
    sd = np.where(usable | is_all_fitted, PRISTINE_SD * sound, LEFT_OUT_SD)
    found: list[Observation] = [OutputReading("pristine", "sound", "lift", "gauges", sound, sd, labels=table.gauges)]
    for name in EDGES:
        for level in LEVELS:
            change = _state(table, name, level) - sound
            far = np.abs(change[usable]).max()
            inside = INCREMENT_SD * far + INSIDE_SD * np.abs(change) if is_all_fitted else LEFT_OUT_SD
            spread = np.where(usable, INCREMENT_SD * far, inside)
            state = f"{name} {level} %"
            found.append(OutputReading(state, state, "lift", "gauges", change, spread, "sound", table.gauges))
    compliance = 1.0 / (1000.0 * tip_test("model").stiffness)
    found.append(OutputReading("tip", "sound", "tip", "up", np.array([compliance]), np.array([TIP_SD * compliance])))
    for number, frequency in enumerate(vibration_test().measured):
        group = f"frequency {number + 1}"
        found.append(FrequencyReading(number, frequency, FREQUENCY_SD * frequency, "up", "aft", group))
    return [*found, MassReading(WEIGHT, WEIGHT_SD, "weight")]


def values(fit: Calibration) -> Iterator[str]:
    """Yield the fitted values as Markdown, then the scalar readings."""
    yield "| parameter | fitted | sd | range | at its limit |\n|---|---|---|---|---|"
    for p, sd in zip(fit.parameters, fit.standard_deviation, strict=True):
        limit = fit.limits.get(p.name, "no")
        yield f"| {p.name}: {p.meaning} | {fit[p.name]:.5g} | {sd:.2g} | {p.lower:g} to {p.upper:g} | {limit} |"
    yield "\n| reading | measured | fitted |\n|---|---|---|"
    for reading in fit.observations:
        if reading.n_entries == 1:
            yield f"| {reading.group} | {float(np.atleast_1d(reading.measured)[0]):.5g} | {fit.of(reading)[0]:.5g} |"


def row(name: str, fit: Calibration, gauges: NDArray[np.bool_]) -> str:
    """Return a fit's errors at some gauges: pristine in percent, increments in percent of the largest of the 20."""
    words = [" / ".join(f"{error:.1f}" for error in errors) for errors in misfits(fit, gauges).values()]
    ends = f", at a limit: {fit.limits}" if fit.limits else ""
    return f"| {name}{ends} | {int(gauges.sum())} | {words[0]} % | {words[1]} % | {words[2]} % |"


def misfits(fit: Calibration, gauges: NDArray[np.bool_]) -> dict[str, list[float]]:
    """Return the same as numbers [%], root mean squares: one of pristine strains, one for each level of mu1 and mu2."""
    usable = fit.observations[0].sd < LEFT_OUT_SD if isinstance(fit.observations[0], OutputReading) else gauges
    found: dict[str, list[float]] = {"pristine": [], "mu1": [], "mu2": []}
    for reading in fit.observations:
        kind = reading.group.split()[0]
        if isinstance(reading, OutputReading) and kind in found:
            wanted = np.asarray(reading.measured)
            size = wanted[gauges] if kind == "pristine" else np.abs(wanted[usable]).max()
            error = 100.0 * (fit.of(reading) - wanted)[gauges] / size
            found[kind].append(float(np.sqrt(np.mean(np.square(error)))))
    return found


def _state(table: MeanStrains, parameter: str, level: int) -> Floats:
    """Return the mean strains (24,) of one damaged region."""
    wanted = [level if parameter == name else 0 for name in EDGES]
    return np.asarray(table.strain_microstrain[(table.states_percent == wanted).all(axis=1)][0])


if __name__ == "__main__":
    run_main(main)
