"""Three tanks in a row with two inlets, read at nine pairs of flows.

The twin's orifices follow the square root of the height. The asset's follow the power 0.53, water evaporates and foams
a little, and a pump lifts the outflow. Each constant is 3 to 12 % off besides.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.machines.machine import Machine, Numbers, off
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, function_twin

READINGS = {"level1": "cm", "level2": "cm", "level3": "cm", "flow12": "l/min", "flow23": "l/min", "power": "W"}
NOMINAL = {"gate12": 1.9, "gate23": 2.4, "outlet": 2.2, "lift": 3.4, "leak": 0.0}


def tanks(parameters: Numbers, loads: Numbers) -> Sequence[float]:
    """Return the readings of the user's model: from the last tank to the first, the leak by steps."""
    p, first, last = parameters, loads["first"], loads["last"]
    lost = 0.0
    for _ in range(30):
        f12, f23 = first, first - lost
        out = f23 + last
        h3 = (out / p["outlet"]) ** 2
        h2 = h3 + (f23 / p["gate23"]) ** 2
        lost = 0.5 * (lost + min(p["leak"] * np.sqrt(h2), 0.9 * first))
    return [h2 + (f12 / p["gate12"]) ** 2, h2, h3, f12, f23, p["lift"] * out]


def twin() -> FunctionTwin:
    """Return the user's twin."""
    parameters = {k: (v, 0.6 * v, 1.3 * v, "l/min/cm0.5") for k, v in NOMINAL.items() if v}
    parameters |= {"lift": (3.4, 2.4, 6.0, "W min/l"), "leak": (0.0, 0.0, 1.0, "l/min/cm0.5")}
    return function_twin(tanks, READINGS, loads=("first", "last"), parameters=parameters)


def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
    """Return what the asset shows (n_readings,), by steps to a balance."""
    first, last = loads["first"], loads["last"]
    p = {
        name: NOMINAL[name] * own[name] * (1.0 + faults.get(name, 0.0))
        for name in ("gate12", "gate23", "outlet", "lift")
    }
    lost = 0.0
    for _ in range(60):
        f12 = first
        f23 = f12 - lost
        out = f23 + last - 0.05
        blocked = 1.0 - faults.get("debris", 0.0) * (out / 12.0) ** 2
        h3 = (out / (p["outlet"] * blocked)) ** (1.0 / 0.53) * 1.2
        h2 = h3 + (f23 / p["gate23"]) ** (1.0 / 0.53) * 1.2 + faults.get("air_lock", 0.0) / (1.0 + f23)
        spill = faults.get("overflow", 0.0) * max(0.0, h2 - 12.0)
        lost = 0.5 * (lost + min(faults.get("leak", 0.0) * np.sqrt(h2) + spill, 0.9 * first))
    h1 = h2 + (f12 / p["gate12"]) ** (1.0 / 0.53) * 1.2
    foam = 1.0 + faults.get("foam", 0.0) * out / 12.0
    return np.array([h1 * foam, h2 * foam, h3, f12, f23, p["lift"] * out * (1.0 + 0.004 * out)])


TANKS = Machine(
    name="tanks",
    twin=twin,
    cells=[{"first": a, "last": b} for a in (3.0, 5.0, 7.0) for b in (1.0, 3.0, 5.0)],
    repeats=8,
    noise=np.array([0.12, 0.12, 0.12, 0.04, 0.04, 0.3]),
    own=lambda rng: {name: off(rng) for name in NOMINAL},
    measure=measure,
    faults={"gate12": (-0.2, -0.05), "gate23": (-0.2, -0.05), "outlet": (-0.2, -0.04), "lift": (0.06, 0.4),
            "leak": (0.05, 0.4)},
    outside={"debris": (0.05, 0.2), "air_lock": (3.0, 12.0), "overflow": (0.05, 0.3), "foam": (0.04, 0.15)},
)  # fmt: skip
