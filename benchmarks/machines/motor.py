"""A direct-current motor under a brake, read at three voltages and three load torques.

The twin is linear: R, k and two constants of friction. The asset's resistance rises and its magnets weaken as it warms,
its friction is greater when it is slow (Stribeck), the fan takes a torque with the square of the speed, and the brushes
drop 0.4 V. Each constant is 3 to 12 % off besides.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.machines.machine import Machine, Numbers, off
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, function_twin

READINGS = {"current": "A", "speed": "rad/s", "winding": "K", "case": "K", "power": "W"}


def motor(parameters: Numbers, loads: Numbers) -> Sequence[float]:
    """Return the readings of the user's model."""
    r, k = parameters["resistance"], parameters["magnet"]
    braked = loads["torque"] + parameters["dry_friction"]
    speed = (loads["voltage"] * k / r - braked) / (k * k / r + parameters["friction"])
    current = (loads["voltage"] - k * speed) / r
    heat = r * current**2
    warm = parameters["to_air"] * heat
    power = loads["voltage"] * current
    return [current, speed, warm + parameters["to_case"] * heat, warm, power]


def twin() -> FunctionTwin:
    """Return the user's twin."""
    return function_twin(
        motor, READINGS, loads=("voltage", "torque"),
        parameters={
            "resistance": (1.2, 0.8, 1.8, "ohm"), "magnet": (0.06, 0.045, 0.066, "N m/A"),
            "dry_friction": (0.010, 0.0, 0.05, "N m"), "friction": (2e-5, 0.0, 1e-4, "N m s"),
            "to_air": (0.8, 0.4, 1.6, "K/W"), "to_case": (0.4, 0.2, 0.8, "K/W"),
        },
    )  # fmt: skip


def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
    """Return what the asset shows (n_readings,): a fixed point, as it warms itself."""
    voltage, torque = loads["voltage"], loads["torque"]
    warm = rise = speed = current = 0.0
    for _ in range(200):
        r = own["resistance"] * 1.2 * (1.0 + faults.get("resistance", 0.0)) * (1.0 + 0.0039 * rise)
        k = own["magnet"] * 0.06 * (1.0 + faults.get("magnet", 0.0)) * (1.0 - 0.0005 * rise)
        k *= 1.0 - faults.get("armature_reaction", 0.0) * current**2
        rub = own["dry"] * 0.010 * (1.0 + 0.4 * np.exp(-speed / 100.0)) + faults.get("dry_friction", 0.0)
        turn = own["friction"] * 2e-5 + faults.get("friction", 0.0)
        fan = 2e-8 * speed**2 + faults.get("rubbing_blade", 0.0) * max(0.0, speed - 220.0)
        drop = 0.4 + faults.get("brush_bounce", 0.0) * (speed / 300.0) ** 2
        wanted = (k * (voltage - drop) / r - torque - rub - fan) / (k * k / r + turn)
        speed = max(0.0, 0.5 * speed + 0.5 * wanted)
        current = (voltage - drop - k * speed) / r
        heat = r * current**2 + drop * current + faults.get("eddy_currents", 0.0) * (speed / 300.0) ** 2
        warm = own["to_air"] * 0.8 * (1.0 + faults.get("to_air", 0.0)) * heat
        rise = warm + own["to_case"] * 0.4 * (1.0 + faults.get("to_case", 0.0)) * heat
    slip = 1.0 - faults.get("slipping_coupling", 0.0) * (torque / 0.2) ** 2
    return np.array([current, speed * slip, rise, warm, voltage * current])


def own_numbers(rng: np.random.Generator) -> Numbers:
    """Return the constants of one motor over those of the twin."""
    return {name: off(rng) for name in ("resistance", "magnet", "dry", "friction", "to_air", "to_case")}


MOTOR = Machine(
    name="motor",
    twin=twin,
    cells=[{"voltage": v, "torque": t} for v in (12.0, 18.0, 24.0) for t in (0.05, 0.1, 0.2)],
    repeats=8,
    noise=np.array([0.08, 3.0, 0.5, 0.4, 1.6]),
    own=own_numbers,
    measure=measure,
    faults={
        "resistance": (0.06, 0.25), "magnet": (-0.10, -0.03), "dry_friction": (0.005, 0.02), "friction": (1e-5, 4e-5),
        "to_air": (0.08, 0.3), "to_case": (0.15, 0.5),
    },
    outside={
        "armature_reaction": (0.001, 0.004), "rubbing_blade": (5e-5, 2e-4), "brush_bounce": (0.5, 1.5),
        "eddy_currents": (3.0, 8.0), "slipping_coupling": (0.03, 0.1),
    },
)  # fmt: skip
