"""A ship and its propeller, read at five speeds and two draughts.

The twin has a hull with the square of the speed, waves with the sixth power, and straight lines for the propeller. The
asset's hull follows the power 1.85, its propeller's coefficients bend, its engine burns more at part load. Each
constant is 3 to 12 % off besides.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.machines.machine import Machine, Numbers, off
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, function_twin

READINGS = {"revs": "1/min", "thrust": "kN", "torque": "kN m", "power": "kW", "fuel": "kg/h"}
NOMINAL = {"hull": 1.4, "waves": 0.9, "grip": 0.45, "drag": 0.055, "engine": 0.21, "wake": 0.22}
"""Coefficients of hull [kN s2/m2/m], waves, thrust at rest, torque at rest, fuel [kg/kWh] and wake."""
DIAMETER = 3.0


def _revs(speed: float, thrust: float, grip: float, bend: float = 0.0) -> float:
    """Return revolutions [1/s] at which a propeller gives a thrust [kN]: its coefficient is grip - 0.42 J - bend J2."""
    a, b = 1.025 * DIAMETER**4, speed / DIAMETER
    c = [a * grip, -a * 0.42 * b, -(a * bend * b**2) - thrust]
    return float((-c[1] + np.sqrt(c[1] ** 2 - 4.0 * c[0] * c[2])) / (2.0 * c[0]))


def ship(parameters: Numbers, loads: Numbers) -> Sequence[float]:
    """Return the readings of the user's model."""
    p, v, draught = parameters, loads["speed"], loads["draught"]
    thrust = p["hull"] * draught * v**2 * (1.0 + p["waves"] * (v / 10.0) ** 4) / 0.85
    inflow = v * (1.0 - p["wake"])
    n = _revs(inflow, thrust, p["grip"])
    torque = 1.025 * n**2 * DIAMETER**5 * (p["drag"] - 0.04 * inflow / (n * DIAMETER))
    power = 2.0 * np.pi * n * torque
    return [60.0 * n, thrust, torque, power, p["engine"] * power]


def twin() -> FunctionTwin:
    """Return the user's twin."""
    units = {"hull": "kN s2/m3", "engine": "kg/(kW h)"}
    ends = {"hull": (0.7, 1.8), "waves": (0.4, 2.0), "grip": (0.8, 1.2), "drag": (0.8, 1.4), "engine": (0.8, 1.5),
            "wake": (0.5, 1.6)}  # fmt: skip
    parameters = {k: (v, v * ends[k][0], v * ends[k][1], units.get(k, "-")) for k, v in NOMINAL.items()}
    return function_twin(ship, READINGS, loads=("speed", "draught"), parameters=parameters)


def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
    """Return what the asset shows (n_readings,)."""
    v, draught = loads["speed"], loads["draught"]
    p = {name: value * own[name] * (1.0 + faults.get(name, 0.0)) for name, value in NOMINAL.items()}
    hull = p["hull"] * draught**0.95 * v**1.85 * 7.0**0.15 * (1.0 + faults.get("shallow_water", 0.0) * (v / 8.0) ** 4)
    thrust = (hull * (1.0 + p["waves"] * (v / 10.0) ** 4) + faults.get("towed_gear", 0.0) * 10.0) / 0.85
    inflow = v * (1.0 - p["wake"] * (1.0 - faults.get("swirl", 0.0) * (draught - 4.0)))
    n = _revs(inflow, thrust * (1.0 + faults.get("ventilation", 0.0) * max(0.0, thrust / 400.0 - 0.3)), p["grip"], 0.02)
    j = inflow / (n * DIAMETER)
    torque = 1.025 * n**2 * DIAMETER**5 * (p["drag"] - 0.036 * j - 0.004 * j**2) + 0.6
    power = 2.0 * np.pi * n * torque
    return np.array([60.0 * n, thrust, torque, power, p["engine"] * power * (1.0 + 15.0 / (power + 60.0))])


SHIP = Machine(
    name="ship",
    twin=twin,
    cells=[{"speed": v, "draught": d} for v in (3.0, 4.5, 6.0, 7.0, 8.0) for d in (3.5, 4.5)],
    repeats=8,
    noise=np.array([1.0, 5.0, 2.0, 25.0, 6.0]),
    own=lambda rng: {name: off(rng) for name in NOMINAL},
    measure=measure,
    faults={"hull": (0.06, 0.3), "waves": (0.2, 0.8), "grip": (-0.12, -0.04), "drag": (0.05, 0.2),
            "engine": (0.05, 0.25), "wake": (0.15, 0.5)},
    outside={"shallow_water": (0.1, 0.4), "towed_gear": (1.0, 5.0), "swirl": (0.3, 1.0), "ventilation": (0.1, 0.4)},
)  # fmt: skip
