"""What it costs in fit that the wing's skin is one that a person would build.

    python -m benchmarks.wing.buildable [--refinement 0.3] [--jobs N] [--table FILE.csv] [--picture FILE.png]

Each row is a calibration of `built_wing`'s layout to the published data (`benchmarks.wing.published`) with another
freedom of the skin along the span: any exponential and any step (the saw-tooth of `uav_wing`), the same with a prior of
smoothness, one step down at mid-span (two layups: `built_wing`), an exponential that never rises, a constant. Wood
stays within 4 to 9 GPa, faces and core are those of `built_materials`. Gauge rows and regions' edges move in all.
"""

import argparse
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.data import SHARED, vibration_test
from benchmarks.main_program import run_main
from benchmarks.wing.design import EDGES, SKIN_DENSITY, WingDesign
from benchmarks.wing.published import LEFT_OUT_SD, LEVELS, MASSES, UNSEEN, observations, values
from femlib.calibration import Calibration, OutputReading, Parameter, calibrate
from femlib.dataset import MeanStrains, published_strains
from femlib.wing import uav_wing
from femlib.wing.built import ROOT, built_materials
from femlib.wing.structure import MIDDLE
from octmip.formats.files import write_bytes
from octmip.interfaces.report.markdown import markdown_table

Floats = NDArray[np.float64]
WOOD = (4.0 / 3.25, 9.0 / 3.25)
"""Plywood's modulus, 4 to 9 GPa, over that of the card."""
SMOOTH_SD = 0.3
"""Standard deviation of the skin's exponent and of the logarithm of its step in the prior of smoothness."""
PARAMETERS = (
    Parameter("skin", 0.72, 0.2, 8.0, is_log=True, meaning="factor on the skin's modulus"),
    Parameter("rib", 1.3, *WOOD, is_log=True, meaning="factor on the ribs' modulus"),
    Parameter("web", 2.1, *WOOD, is_log=True, meaning="factor on the web's modulus"),
    Parameter("mass", 22.0, 10.0, 60.0, is_log=True, meaning="effective mass at load factor 1 [kg]"),
    Parameter("front_in", 0.2655, 0.2, 0.33, meaning="first gauge of the front row, eta"),
    Parameter("front_out", 0.592, 0.5, 0.65, meaning="first gauge of its outboard half, eta"),
    Parameter("rear_in", 0.293, 0.2, 0.34, meaning="first gauge of the rear row, eta"),
    Parameter("rear_out", 0.5987, 0.5, 0.66, meaning="first gauge of its outboard half, eta"),
    Parameter("pitch", 0.0226, 0.014, 0.034, meaning="pitch of the front row, half the rear row's, eta"),
    Parameter("x_front", 0.21, 0.1, 0.295, meaning="front row, x/c"),
    Parameter("x_rear", 0.342, 0.305, 0.6, meaning="rear row, x/c"),
    Parameter("density", 0.45, 0.2, 3.0, 1.0, 0.3, is_log=True, meaning="factor on the skin's density"),
    Parameter("r1_fore", 0.357, 0.30, 0.5, meaning="region 1, fore edge, x/c"),
    Parameter("r1_aft", 0.624, 0.45, 0.95, meaning="region 1, aft edge, x/c"),
    Parameter("r2_fore", 0.355, 0.3, 0.5, meaning="region 2, fore edge, x/c"),
    Parameter("r2_aft", 0.446, 0.38, 0.8, meaning="region 2, aft edge, x/c"),
    Parameter("r1_in", 0.21, 0.15, 0.3, meaning="region 1, inboard edge, eta"),
    Parameter("r1_out", 0.358, 0.3, 0.5, meaning="region 1, outboard edge, eta"),
    Parameter("r2_in", 0.656, 0.55, 0.7, meaning="region 2, inboard edge, eta"),
)
FIXED = {"rise": 0.0, "step": 1.0, "r2_out": 10.0 / 12.0, "root": ROOT}
_RISE = Parameter("rise", 0.1, -3.0, 6.0, meaning="growth of the skin's modulus along the span, exp(rise (eta - 1/2))")
_STEP = Parameter("step", 0.6, 0.05, 3.0, is_log=True, meaning="skin's modulus outboard of mid-span over inboard")
SKINS: Mapping[str, tuple[Parameter, ...]] = {
    "any exponential and step": (_RISE, _STEP),
    "the same, prior of smoothness": (
        replace(_RISE, prior_mean=0.0, prior_sd=SMOOTH_SD),
        replace(_STEP, prior_mean=1.0, prior_sd=SMOOTH_SD),
    ),
    "one step down (built_wing)": (replace(_STEP, upper=1.0),),
    "an exponential that never rises": (replace(_RISE, start=-0.5, upper=0.0),),
    "constant": (),
}


def main() -> None:
    """Fit each skin, print, write."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.buildable", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.3)
    parser.add_argument("--jobs", type=int, help="processes, one skin each; as many as there are cores if not given")
    parser.add_argument("--table", help="CSV file to write")
    parser.add_argument("--picture", help="PNG file to write")
    options = parser.parse_args()
    with ProcessPoolExecutor(options.jobs) as pool:
        fits = list(pool.map(fitted, SKINS, [options.refinement] * len(SKINS)))
    rows = [row for row, _, _ in fits]
    print(markdown_table(rows), "\n\n" + "\n".join(fits[2][2]))
    if options.table:
        write_bytes(options.table, pd.DataFrame(rows).to_csv(index=False).encode())
    if options.picture:
        picture([found for _, found, _ in fits], rows).savefig(options.picture, dpi=110)


def fitted(name: str, refinement: float) -> tuple[dict[str, object], dict[str, float], list[str]]:
    """Return the row, the fitted values and the report of one skin."""
    table = published_strains(SHARED / "uav" / "strains.csv")
    fit = calibrate(buildable_design(refinement), (*PARAMETERS, *SKINS[name]), observations(table), UNSEEN)
    return row(name, fit, table), fit.by_name, list(values(fit))


def buildable_design(refinement: float) -> WingDesign:
    """Return the mesh with the cards of `built_wing` at a factor of 1, and the states of one damaged region."""
    cards = built_materials()
    cards = replace(cards, skin_young=0.4884e9, skin_step=1.0, web_factor=1.0, rib_factor=1.0, root_factor=1.0)
    cards = replace(cards, skin_density=SKIN_DENSITY * 0.44)
    states = {f"{name} {level} %": (name, level / 100.0) for name in EDGES for level in LEVELS}
    test = vibration_test()
    masses = {eta: test.masses[name] for eta, name in MASSES.items()}
    wing = uav_wing(refinement=refinement, materials=cards)
    return WingDesign(wing, {"sound": ("", 0.0), **states}, FIXED, masses, is_wood_apart=True)


def row(name: str, fit: Calibration, table: MeanStrains) -> dict[str, object]:
    """Return what a fit misses: pristine in percent, increments in percent of the largest of the 20 gauges."""
    skin = skin_of(fit.by_name, np.linspace(0.0, 1.0, 201))
    found: dict[str, object] = {"skin": name, "parameters": len(fit.parameters)}
    found["greatest over least modulus"] = round(float(skin.max() / skin.min()), 2)
    found["greatest rise outboard"] = round(float((skin / np.minimum.accumulate(skin)).max()), 2)
    usable = table.is_usable
    for reading in fit.observations:
        if isinstance(reading, OutputReading) and reading.group.split()[0] in ("pristine", *EDGES):
            wanted = np.asarray(reading.measured)
            size = wanted if reading.group == "pristine" else np.abs(wanted[usable]).max()
            error = (100.0 * (fit.of(reading) - wanted) / size)[np.asarray(reading.sd) < LEFT_OUT_SD]
            found[f"{reading.group} rms %"] = round(float(np.sqrt(np.mean(error**2))), 2)
        elif reading.n_entries == 1:
            found[reading.group] = round(float(fit.of(reading)[0]), 6)
    return found | {"effective mass kg": round(fit["mass"], 2), "at a limit": " ".join(fit.limits) or "none"}


def skin_of(fitted_values: Mapping[str, float], eta: Floats) -> Floats:
    """Return the skin's modulus (n,) at span fractions [GPa], of the layer that stands for the sandwich."""
    v = {**FIXED, **fitted_values}
    along = np.exp(v["rise"] * (eta - MIDDLE)) * np.where(eta > MIDDLE, v["step"], 1.0)
    return np.asarray(0.4884 * v["skin"] * along)


def picture(fits: list[dict[str, float]], rows: list[dict[str, object]]) -> Figure:
    """Return the skins along the span, and what each misses."""
    figure = Figure(figsize=(11, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    eta = np.linspace(0.0, 1.0, 401)
    for own, fit in zip(rows, fits, strict=True):
        left.plot(eta, skin_of(fit, eta), label=str(own["skin"]))
    left.set(xlabel="span fraction", ylabel="modulus of the equivalent skin layer [GPa]", ylim=(0.0, None))
    left.set_title("skin along the span (root layup left out)", fontsize=10)
    left.legend(fontsize=7.5)
    kinds = ("pristine rms %", "mu1 80 % rms %", "mu2 80 % rms %")
    places = np.arange(len(rows))
    for k, kind in enumerate(kinds):
        heights = [float(str(own[kind])) for own in rows]
        bars = right.barh(places + 0.27 * (k - 1), heights, 0.25, label=kind.replace(" rms %", ""))
        right.bar_label(bars, fmt="%.1f", fontsize=7, padding=2)
    right.set_yticks(places, [str(own["skin"]) for own in rows], fontsize=8)
    right.invert_yaxis()
    right.set(xlabel="misfit beside the published strains, rms [%]")
    right.legend(fontsize=8)
    return figure


if __name__ == "__main__":
    run_main(main)
