"""What a real wing has and `uav_wing` lacks: prior of each effect, and the strain that it adds.

    python -m benchmarks.wing.effects [--refinement 1]

The strain is that of one prior standard deviation at load factor 3, rms over the 20 usable gauges, at the worst place;
creep after an hour.
"""

import argparse

import numpy as np
from numpy.typing import NDArray

from benchmarks.main_program import run_main
from femlib.wing import WingTwin, uav_wing
from femlib.wing.effects import wing_effects
from octmip.interfaces.report.markdown import markdown_table

LOAD_FACTOR, HOUR = 3.0, 3600.0


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.effects", description=__doc__)
    parser.add_argument("--refinement", type=float, default=1.0)
    options = parser.parse_args()
    wing = uav_wing(refinement=options.refinement)
    print(markdown_table(effect_rows(WingTwin(wing, wing_effects(wing)), wing.gauges.is_usable)))


def effect_rows(twin: WingTwin, is_usable: NDArray[np.bool_]) -> list[dict[str, object]]:
    """Return one row for each effect of a twin."""
    rows = []
    for name, effect in twin.effects.items():
        places = effect.places(twin)
        signatures = [effect.signature(twin, {}, LOAD_FACTOR, place, HOUR)[is_usable] for place in places]
        strains = effect.prior_sd * np.sqrt(np.square(signatures).mean(axis=1))
        row: dict[str, object] = {"effect": name, "unit": effect.unit, "prior sd": effect.prior_sd}
        rows.append(row | {"places": len(places), "strain of one sd, microstrain rms": round(float(strains.max()), 1)})
    return rows


if __name__ == "__main__":
    run_main(main)
