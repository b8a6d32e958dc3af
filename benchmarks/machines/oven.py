"""A furnace of three zones with two heaters, read at nine pairs of powers.

The twin is a linear network: conductances between zones and to the room, a wall at a share of the middle zone, a flue.
The asset radiates, its wall is a node of its own, and its heaters lose a part in their leads. Each constant is 3 to
12 % off besides.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.machines.machine import Machine, Numbers, off
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, function_twin

READINGS = {"zone1": "K", "zone2": "K", "zone3": "K", "wall": "K", "flue": "K", "meter": "kW"}
NOMINAL = {"link12": 0.030, "link23": 0.022, "loss1": 0.010, "loss2": 0.006, "loss3": 0.012, "wall_share": 0.45,
           "draught": 0.30}  # fmt: skip


def oven(parameters: Numbers, loads: Numbers) -> Sequence[float]:
    """Return the readings of the user's model."""
    p, a, b = parameters, loads["front"], loads["back"]
    g12, g23 = p["link12"], p["link23"]
    network = [[g12 + p["loss1"], -g12, 0.0], [-g12, g12 + g23 + p["loss2"], -g23], [0.0, -g23, g23 + p["loss3"]]]
    t1, t2, t3 = np.linalg.solve(network, [a, 0.0, b])
    return [t1, t2, t3, p["wall_share"] * t2, p["draught"] * (t1 + t3) / 2.0, a + b]


def twin() -> FunctionTwin:
    """Return the user's twin."""
    units = {"wall_share": "-", "draught": "-"}
    parameters = {k: (v, 0.5 * v, 2.0 * v, units.get(k, "kW/K")) for k, v in NOMINAL.items()}
    return function_twin(oven, READINGS, loads=("front", "back"), parameters=parameters)


def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
    """Return what the asset shows (n_readings,): the temperatures at which heat that comes and goes is equal."""
    p = {name: value * own[name] * (1.0 + faults.get(name, 0.0)) for name, value in NOMINAL.items()}
    a, b = loads["front"], loads["back"]
    t = np.array([200.0, 200.0, 200.0])
    for _ in range(400):
        melting = faults.get("melting", 0.0) * max(0.0, t[1] - 250.0) / 60.0
        door = faults.get("door_ajar", 0.0) * max(t[2], 0.0) ** 1.5 / 20.0
        fan = faults.get("stray_draught", 0.0) * (t[0] - t[2])
        glow = 8e-12 * ((t + 293.0) ** 4 - 293.0**4) * np.array([1.0, 0.6, 1.0]) * (1.0 + faults.get("soot", 0.0))
        left = np.array([
            0.98 * a - p["link12"] * (t[0] - t[1]) - p["loss1"] * t[0] - fan,
            p["link12"] * (t[0] - t[1]) - p["link23"] * (t[1] - t[2]) - p["loss2"] * t[1] - melting,
            0.98 * b + p["link23"] * (t[1] - t[2]) - p["loss3"] * t[2] - door + fan,
        ])  # fmt: skip
        t = t + 6.0 * (left - glow)
    wall = p["wall_share"] * (0.94 * t[1] + 0.03 * (t[0] + t[2]))
    return np.array([*t, wall, p["draught"] * (0.55 * t[0] + 0.45 * t[2]), a + b])


OVEN = Machine(
    name="oven",
    twin=twin,
    cells=[{"front": a, "back": b} for a in (2.0, 4.0, 6.0) for b in (1.0, 3.0, 5.0)],
    repeats=8,
    noise=np.array([1.5, 1.5, 1.5, 1.0, 1.0, 0.03]),
    own=lambda rng: {name: off(rng) for name in NOMINAL},
    measure=measure,
    faults={"link12": (-0.4, -0.1), "link23": (-0.4, -0.1), "loss1": (0.1, 0.5), "loss2": (0.1, 0.5),
            "loss3": (0.1, 0.5), "wall_share": (0.05, 0.2), "draught": (-0.3, -0.06)},
    outside={"melting": (0.2, 0.8), "door_ajar": (0.003, 0.012), "stray_draught": (0.002, 0.008), "soot": (2.0, 8.0)},
)  # fmt: skip
