"""What it costs in fit that the wing's skin is smooth along the span, and when it buckles.

    python -m benchmarks.wing.buildable [--refinement 0.3] [--skin NAME] [--picture FILE.png]

Each skin is a calibration of `built_wing`'s layout to the published data (`benchmarks.wing.published`): one step down
at mid-span (two layups: `built_wing`), or any exponential and any step under a prior of smoothness, normal about a skin
that is alike everywhere. Its standard deviation counts for the growth and for the step's logarithm. Wood stays within 4
to 9 GPa. Gauge rows and regions' edges move in all. Each fit is made again without six gauges, which then judge it.

A skin buckles by its thickness, which strains hardly show: each fit is loaded as the sandwich of `built_wing` and as
one layer of the same stiffness in its plane, as `uav_wing` has. The last fit includes the four gauges that the study
leaves out, so that g17 and g18 stand in region 1, g23 and g24 in region 2, if anywhere.
"""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.data import SHARED
from benchmarks.main_program import run_main
from benchmarks.wing.buckling import ANY
from benchmarks.wing.design import SKIN_DENSITY, WingDesign
from benchmarks.wing.published import (
    N_HELD_OUT,
    UNSEEN,
    measured_masses,
    misfits,
    observations,
    one_region_states,
    values,
)
from femlib.calibration import Calibration, Parameter, calibrate
from femlib.dataset import MeanStrains, published_strains
from femlib.wing import buckle, uav_wing
from femlib.wing.built import ROOT, built_materials
from femlib.wing.structure import WingMaterials
from octmip.interfaces.report.markdown import markdown_table

Row = dict[str, object]
WOOD = (4.0 / 3.25, 9.0 / 3.25)
"""Plywood's modulus, 4 to 9 GPa, over that of the card."""
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
SANDWICH = replace(built_materials(), skin_step=1.0, web_factor=1.0, rib_factor=1.0)
"""Cards of `built_wing` at factors of 1."""
YOUNG, DENSITY = 0.4884e9, 0.44 * SKIN_DENSITY
"""Modulus [Pa] and density [kg/m^3] that `skin` and `density` start from, of the layer that stands for the sandwich."""
FIXED = {"rise": 0.0, "step": 1.0, "r2_out": 10.0 / 12.0, "root": ROOT}
SMOOTH = (0.05, 0.2, 0.5)
"""Standard deviations of the prior of smoothness."""


def skin(sd: float | None) -> tuple[Parameter, ...]:
    """Return what is fitted of the skin along the span under a prior of smoothness; None: without."""
    rise = Parameter("rise", 0.1, -3.0, 6.0, meaning="growth of the skin's modulus, exp(rise (eta - 1/2))")
    step = Parameter("step", 0.6, 0.05, 3.0, is_log=True, meaning="its modulus outboard of mid-span over inboard")
    if sd is None:
        return rise, step
    return replace(rise, prior_mean=0.0, prior_sd=sd), replace(step, prior_mean=1.0, prior_sd=sd)


ONE_STEP = Parameter("step", 0.6, 0.05, 1.0, is_log=True, meaning="skin's modulus outboard of mid-span over inboard")
SKINS: Mapping[str, tuple[Parameter, ...]] = {
    **{f"smooth, sd {sd:g}": skin(sd) for sd in SMOOTH},
    "free": skin(None),
    "one step down": (ONE_STEP,),
}
"""What is fitted of the skin along the span."""
THIN = 3.81e-3, 1.1e-3
"""Thickness and height of the face [m] of the one layer of `uav_wing`."""
BUCKLING = 0.5
"""Refinement of the mesh on which the skins buckle."""
DRAWS = 1
"""Choices of six gauges that are held out."""


def main() -> None:
    """Fit each skin and print."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.buildable", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.3)
    parser.add_argument("--skin", choices=SKINS, action="append", help="that one alone")
    parser.add_argument("--picture", type=Path, help="PNG file to write")
    options = parser.parse_args()
    table = published_strains(SHARED / "uav" / "strains.csv")
    design = buildable_design(options.refinement)
    rows, start = [], dict[str, float]()
    for name in options.skin or SKINS:  # a smooth skin starts from the one before, others on their own
        row, fit = skin_row(name, design, table, start if name.startswith("smooth") else {})
        rows.append(row)
        start |= fit.by_name
    free = started((*PARAMETERS, *SKINS["free"]), start)
    inside = calibrate(design, free, observations(table, is_all_fitted=True), UNSEEN)
    print("\n".join(values(inside)))
    for own in (rows, inside_rows(inside, table)):
        print(f"\n{markdown_table(own)}")
    if options.picture:
        picture(rows).savefig(options.picture, dpi=110)


def started(parameters: Sequence[Parameter], values: Mapping[str, float]) -> list[Parameter]:
    """Return parameters that start at values where these lie in their range."""
    return [replace(p, start=float(np.clip(values.get(p.name, p.start), p.lower, p.upper))) for p in parameters]


def skin_row(name: str, design: WingDesign, table: MeanStrains, start: Mapping[str, float]) -> tuple[Row, Calibration]:
    """Return a skin's fit and its row: misfits [%] of 20 gauges and of those held out, load factors of buckling."""
    seen, usable = observations(table), table.is_usable
    parameters = started((*PARAMETERS, *SKINS[name]), start)
    fit = calibrate(design, parameters, seen, UNSEEN)
    print("\n".join(values(fit)), flush=True)
    warm, apart = started(parameters, fit.by_name), []
    for seed in range(DRAWS):
        chosen = np.random.default_rng(seed).choice(np.flatnonzero(usable), N_HELD_OUT, replace=False)
        without = calibrate(design, warm, seen, [*UNSEEN, *(table.gauges[k] for k in chosen)])
        apart.append(_squares(without, np.isin(np.arange(len(usable)), chosen)))
    row: Row = {"skin": name, "rise": fit.by_name.get("rise", 0.0), "step": fit["step"]}
    for label, squares in (("", _squares(fit, usable)), (", held out", np.mean(apart, axis=0))):
        for kind, square in zip(("pristine", "mu1", "mu2"), squares, strict=True):
            row[f"{kind}{label} %"] = round(float(np.sqrt(square)), 2)
    for kind, (thickness, height) in {
        "sandwich": (SANDWICH.skin_thickness, SANDWICH.face_height),
        "layer": THIN,
    }.items():
        cards = cards_of(fit, thickness, height)
        wing = uav_wing(refinement=BUCKLING, materials=cards, effective_mass=fit["mass"])
        row[f"buckles at, {kind}"] = round(buckle(wing, {}, limit=ANY)[0].factor, 2)
    print(row, flush=True)
    return row, fit


def _squares(fit: Calibration, gauges: NDArray[np.bool_]) -> list[float]:
    """Return the mean squares of the misfits [%] of pristine strains and of the increments of mu1 and mu2."""
    found = misfits(fit, gauges)
    return [float(np.mean(np.square(found[kind]))) for kind in ("pristine", "mu1", "mu2")]


def cards_of(fit: Calibration, thickness: float, height: float) -> WingMaterials:
    """Return the cards of a fit with a skin of another thickness and the same stiffness in its plane."""
    young = YOUNG * fit["skin"] * SANDWICH.skin_thickness / thickness
    own = replace(SANDWICH, skin_young=young, skin_thickness=thickness, face_height=height)
    own = replace(own, skin_rise=fit.by_name.get("rise", 0.0), skin_step=fit["step"])
    return replace(own, web_factor=fit["web"], rib_factor=fit["rib"])


def inside_rows(fit: Calibration, table: MeanStrains) -> list[Row]:
    """Return published and fitted answers [microstrain] of the four gauges that the study leaves out."""
    rows: list[Row] = [{"gauge": table.gauges[k]} for k in np.flatnonzero(~table.is_usable)]
    for reading in fit.observations:
        if reading.group == "pristine" or reading.group.endswith(" 80 %"):
            pairs = zip(np.atleast_1d(reading.measured), fit.of(reading), strict=True)
            for row, (measured, fitted) in zip(rows, np.array(list(pairs))[~table.is_usable], strict=True):
                row |= {f"{reading.group}, published": round(measured), f"{reading.group}, fitted": round(fitted)}
    return rows


def picture(rows: list[Row]) -> Figure:
    """Return misfits and load factors of buckling of each skin, from the smoothest to the free one."""
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    places, names = np.arange(len(rows)), [str(row["skin"]).replace(", ", "\n") for row in rows]
    for kind, colour in {"pristine": "#222222", "mu1": "#1f6feb", "mu2": "#c2410c"}.items():
        for label, style in (("", "o-"), (", held out", "o:")):
            values = [float(str(row[f"{kind}{label} %"])) for row in rows]
            left.plot(places, values, style, color=colour, label=f"{kind}{label}", markersize=4)
    for kind, colour in {"sandwich": "#15803d", "layer": "#9333ea"}.items():
        values = [float(str(row[f"buckles at, {kind}"])) for row in rows]
        words = {"sandwich": "sandwich, 5 mm apart", "layer": "one layer, 3.8 mm"}[kind]
        right.plot(places, values, "o-", color=colour, label=words, markersize=4)
    right.axhline(3.0, color="#222222", lw=0.8, ls="--", label="flown: 3 g")
    left.set(ylabel="misfit, rms [%]", ylim=(0, None))
    right.set(ylabel="load factor at which it buckles", ylim=(0, None))
    for axis in (left, right):
        axis.set_xticks(places, names, fontsize=8)
        axis.legend(fontsize=8)
        axis.grid(alpha=0.3)
    return figure


def buildable_design(refinement: float) -> WingDesign:
    """Return the mesh with the cards of `built_wing` at a factor of 1, and the states of one damaged region."""
    cards = replace(SANDWICH, skin_young=YOUNG, skin_density=DENSITY, root_factor=1.0)
    wing = uav_wing(refinement=refinement, materials=cards)
    return WingDesign(wing, one_region_states(), FIXED, measured_masses(), is_wood_apart=True)


if __name__ == "__main__":
    run_main(main)
