"""A transformer under load, read at three voltages and three burdens.

The twin is the equivalent circuit with constant elements. The asset's core saturates, its windings warm, stray flux
costs a little with the square of the current. Each constant is 3 to 12 % off besides.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.machines.machine import Machine, Numbers, off
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, function_twin

READINGS = {"primary": "A", "output": "V", "input": "W", "idle": "A", "oil": "K", "winding": "K"}
NOMINAL = {"copper": 0.60, "leakage": 1.1, "core": 900.0, "magnetising": 420.0, "to_air": 0.14, "to_oil": 0.09}
RATIO = 0.1


def transformer(parameters: Numbers, loads: Numbers) -> Sequence[float]:
    """Return the readings of the user's model."""
    p, volt = parameters, loads["voltage"]
    through = loads["burden"] * RATIO
    inner = volt - p["copper"] * through
    output = RATIO * np.sqrt(inner**2 - (p["leakage"] * through) ** 2)
    loss, iron = p["copper"] * through**2, volt**2 / p["core"]
    idle = volt / p["magnetising"]
    primary = np.hypot(through + volt / p["core"], idle)
    oil = p["to_air"] * (loss + iron)
    return [primary, output, output * loads["burden"] + loss + iron, idle, oil, oil + p["to_oil"] * loss]


def twin() -> FunctionTwin:
    """Return the user's twin."""
    units = {"copper": "ohm", "leakage": "ohm", "core": "ohm", "magnetising": "ohm", "to_air": "K/W", "to_oil": "K/W"}
    parameters = {k: (v, 0.5 * v, 2.2 * v, units[k]) for k, v in NOMINAL.items()}
    return function_twin(transformer, READINGS, loads=("voltage", "burden"), parameters=parameters)


def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
    """Return what the asset shows (n_readings,): a fixed point, as it warms itself."""
    volt, burden = loads["voltage"], loads["burden"]
    p = {name: value * own[name] * (1.0 + faults.get(name, 0.0)) for name, value in NOMINAL.items()}
    hot = 0.0
    for _ in range(40):
        through = burden * RATIO * (1.0 + faults.get("shorted_turn", 0.0) * volt / 230.0)
        copper = (
            p["copper"] * (1.0 + 0.0039 * hot) * (1.0 + faults.get("loose_tap", 0.0) * max(0.0, burden - 80.0) / 40.0)
        )
        stray = 0.05 * through**2 + faults.get("harmonics", 0.0) * through**3 / 10.0
        loss, iron = copper * through**2 + stray, volt**1.9 * 230.0**0.1 / p["core"]
        oil = p["to_air"] * (loss + iron)
        hot = oil + p["to_oil"] * loss
    inner = volt - copper * through
    output = RATIO * np.sqrt(inner**2 - (p["leakage"] * through) ** 2)
    bent = 1.0 + (0.04 + faults.get("saturation", 0.0)) * (volt / 230.0) ** 6
    idle = volt / p["magnetising"] * bent
    primary = np.hypot(through + iron / volt, idle)
    return np.array([primary, output, output * burden + loss + iron, idle, oil, hot])


TRANSFORMER = Machine(
    name="transformer",
    twin=twin,
    cells=[{"voltage": v, "burden": b} for v in (180.0, 210.0, 240.0) for b in (40.0, 80.0, 120.0)],
    repeats=8,
    noise=np.array([0.03, 0.05, 4.0, 0.005, 0.3, 0.3]),
    own=lambda rng: {name: off(rng) for name in NOMINAL},
    measure=measure,
    faults={"copper": (0.05, 0.3), "leakage": (0.2, 0.8), "core": (-0.3, -0.06), "magnetising": (-0.25, -0.04),
            "to_air": (0.08, 0.4), "to_oil": (0.1, 0.5)},
    outside={"shorted_turn": (0.02, 0.08), "loose_tap": (0.2, 0.8), "harmonics": (0.02, 0.08),
             "saturation": (0.1, 0.4)},
)  # fmt: skip
