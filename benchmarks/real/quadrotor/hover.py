"""The twin: forces and moments of a quadrotor in steady hover, as commands of its rotors.

    thrust, roll, pitch, yaw:    f = f_0 + weight / 4 (1, y, x, 0) + ...,    c_i = f_i (1 + loss_i) + blocked_i

Lengths are in units of the arm along x or y; commands are in grams of one rotor. A weight at a rotor lies under its
blades: it blocks the flow (loss of thrust) and takes its swirl, so that the other rotors have to turn against it.
"""

from collections.abc import Mapping

import numpy as np

from benchmarks.real.quadrotor.flight import STEADY
from femlib.arrays import FloatArray
from octmip.gap.doors.function import FunctionTwin, function_twin
from octmip.twin import Loads

NO_LOAD = Loads((), ())
PATTERNS = {
    "M1": np.array([1.0, -1.0, 1.0, 1.0]), "M2": np.array([1.0, -1.0, -1.0, -1.0]),
    "M3": np.array([1.0, 1.0, -1.0, 1.0]), "M4": np.array([1.0, 1.0, 1.0, -1.0]),
}  # fmt: skip
"""What one more gram from a rotor is in four times thrust, roll, pitch and yaw."""
ROTORS = tuple(PATTERNS)
PAIRS = tuple((one, other) for k, one in enumerate(ROTORS) for other in ROTORS[k + 1 :])
SIDES = {"M3+M4": (0, 1, 0, 0), "M1+M2": (0, -1, 0, 0), "M1+M4": (0, 0, 1, 0), "M2+M3": (0, 0, -1, 0)}
ARM = 32.5
"""Place of a rotor along x and y [mm]."""
HOVER = 9.3
"""Thrust of one rotor in hover [g]."""
CUT = 0.032
"""Thrust that a rotor loses by a millimetre that is cut off, relative."""
BLOCKED, SWIRL = 0.5, 1.0
"""Thrust that a gram under the blades costs, and swirl that it takes, both in grams of that rotor."""
DRAGGED, LIFTED = 0.45, 0.2
"""A weight on a thread longer than the flight is high is dragged along: difference of the yaw command between both ways
for a gram, and share of it that hangs."""
TAPE = 0.05
"""Thrust that a piece of tape costs its rotor, relative."""
TILT = 0.3
"""Yaw command for a degree of one arm [g]."""


def hover(parameters: Mapping[str, float], _: Mapping[str, float]) -> FloatArray:
    """Return thrust, roll, pitch and yaw commands and the difference of yaw between the ways (5,) [g]."""
    steady, way = np.array([HOVER + parameters["payload_centre centre"] / 4.0, 0.0, 0.0, 0.0]), 0.0
    for place, side in SIDES.items():
        steady += HOVER / ARM * parameters[f"centre_of_mass_shift {place}"] * np.array(side)
    for one, other in PAIRS:
        middle = (PATTERNS[one] + PATTERNS[other]) / 2.0
        steady += parameters[f"weight_near_rotor {one}+{other}"] * (1.0 + BLOCKED) / 4.0 * middle
    for rotor, pattern in PATTERNS.items():
        level = np.array([1.0, 1.0, 1.0, 0.0]) * pattern
        weight, string = parameters[f"weight_near_rotor {rotor}"], parameters[f"weight_on_string {rotor}"]
        steady += (weight + LIFTED * string) / 4.0 * level
        steady[3] += weight * SWIRL / 4.0 * pattern[3] + TILT * parameters[f"arm_bent {rotor}"]
        loss = CUT * parameters[f"blade_cut {rotor}"] + TAPE * parameters[f"tape_on_blade {rotor}"]
        loss += TAPE * parameters[f"blade_bent {rotor}"] + parameters[f"motor_weak {rotor}"] / 100.0
        steady += (HOVER * loss + BLOCKED * weight) / 4.0 * pattern
        way += DRAGGED * string * pattern[1]
    return np.array([*steady, way])


def hover_twin() -> FunctionTwin:
    """Return the twin with a range for everything that may have been changed and shows in steady commands."""
    by_rotor = {
        "weight_near_rotor": (0.0, 6.0, "g"), "weight_on_string": (0.0, 6.0, "g"), "blade_cut": (0.0, 12.0, "mm"),
        "tape_on_blade": (0.0, 4.0, "-"), "blade_bent": (0.0, 4.0, "-"), "motor_weak": (0.0, 30.0, "%"),
        "arm_bent": (-5.0, 5.0, "deg"),
    }  # fmt: skip
    ranges = {f"{kind} {rotor}": (0.0, *own) for kind, own in by_rotor.items() for rotor in ROTORS}
    ranges |= {f"weight_near_rotor {one}+{other}": (0.0, 0.0, 6.0, "g") for one, other in PAIRS}
    ranges |= {f"centre_of_mass_shift {side}": (0.0, 0.0, 6.0, "mm") for side in SIDES}
    ranges |= {"payload_centre centre": (0.0, 0.0, 8.0, "g")}
    return function_twin(hover, dict.fromkeys(STEADY, "g"), ranges, loads=())
