"""What it costs in fit that the wing's skin is one that a person would build.

    python -m benchmarks.wing.buildable [--refinement 0.3] [--skin NAME]

Each skin is a calibration of `built_wing`'s layout to the published data (`benchmarks.wing.published`) with another
freedom along the span: one step down at mid-span (two layups: `built_wing`), or any exponential and any step (the
saw-tooth of `uav_wing`). Wood stays within 4 to 9 GPa, faces and core are those of `built_materials`. Gauge rows and
regions' edges move in both. Prints Markdown: fitted values, then the misfits in percent.
"""

import argparse
from collections.abc import Mapping
from dataclasses import replace

from benchmarks.data import SHARED
from benchmarks.main_program import run_main
from benchmarks.wing.design import SKIN_DENSITY, WingDesign
from benchmarks.wing.published import UNSEEN, measured_masses, observations, one_region_states, row, values
from femlib.calibration import Parameter, calibrate
from femlib.dataset import published_strains
from femlib.wing import uav_wing
from femlib.wing.built import ROOT, built_materials

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
YOUNG, DENSITY = 0.4884e9, 0.44 * SKIN_DENSITY
"""Modulus [Pa] and density [kg/m^3] that `skin` and `density` start from, of the layer that stands for the sandwich."""
FIXED = {"rise": 0.0, "step": 1.0, "r2_out": 10.0 / 12.0, "root": ROOT}
SKINS: Mapping[str, tuple[Parameter, ...]] = {
    "step": (
        Parameter("step", 0.6, 0.05, 1.0, is_log=True, meaning="skin's modulus outboard of mid-span over inboard"),
    ),
    "free": (
        Parameter("rise", 0.1, -3.0, 6.0, meaning="growth of the skin's modulus along the span, exp(rise (eta - 1/2))"),
        Parameter("step", 0.6, 0.05, 3.0, is_log=True, meaning="skin's modulus outboard of mid-span over inboard"),
    ),
}
"""What is fitted of the skin along the span: one step down (`built_wing`), any exponential and step."""


def main() -> None:
    """Fit each skin and print."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.buildable", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.3)
    parser.add_argument("--skin", choices=SKINS, action="append", help="that one alone")
    options = parser.parse_args()
    table = published_strains(SHARED / "uav" / "strains.csv")
    design = buildable_design(options.refinement)
    for name in options.skin or SKINS:
        fit = calibrate(design, (*PARAMETERS, *SKINS[name]), observations(table), UNSEEN)
        print(
            "\n".join(values(fit)),
            "\n\n| skin | gauges | pristine | mu1 20 / 40 / 60 / 80 % | mu2 |\n|---|---|---|---|---|",
        )
        print(row(name, fit, table.is_usable), f"\n\n{fit.n_predictions} predictions\n", flush=True)


def buildable_design(refinement: float) -> WingDesign:
    """Return the mesh with the cards of `built_wing` at a factor of 1, and the states of one damaged region."""
    cards = replace(built_materials(), skin_young=YOUNG, skin_density=DENSITY)
    cards = replace(cards, skin_step=1.0, web_factor=1.0, rib_factor=1.0, root_factor=1.0)
    wing = uav_wing(refinement=refinement, materials=cards)
    return WingDesign(wing, one_region_states(), FIXED, measured_masses(), is_wood_apart=True)


if __name__ == "__main__":
    run_main(main)
