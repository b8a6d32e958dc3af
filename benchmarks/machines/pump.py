"""A centrifugal pump that drives water through a pipe and a valve, read at three speeds and three openings.

The twin has parabolas: the head falls with the square of the flow, pipe and valve take the square of it, the efficiency
is one number. The asset's head follows speed to the power 1.9, its pipe is between smooth and rough (1.85), its
efficiency has a peak, a seal leaks, and the bearing warms by friction too. Each constant is 3 to 12 % off besides.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.machines.machine import Machine, Numbers, off
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, function_twin

READINGS = {"flow": "l/s", "lift": "kPa", "pipe": "kPa", "valve": "kPa", "shaft": "kW", "bearing": "K"}
NOMINAL = {"head": 300.0, "curve": 0.8, "pipe_loss": 0.9, "valve_loss": 0.5, "efficiency": 0.62, "warming": 8.0}


def pump(parameters: Numbers, loads: Numbers) -> Sequence[float]:
    """Return the readings of the user's model."""
    p, speed, opening = parameters, loads["speed"], loads["opening"]
    valve = p["valve_loss"] / opening**2
    flow = speed * np.sqrt(p["head"] / (p["curve"] + p["pipe_loss"] + valve))
    lift = p["head"] * speed**2 - p["curve"] * flow**2
    shaft = 1e-3 * lift * flow / p["efficiency"]
    return [flow, lift, p["pipe_loss"] * flow**2, valve * flow**2, shaft, p["warming"] * shaft]


def twin() -> FunctionTwin:
    """Return the user's twin."""
    ends = {"head": (0.8, 1.1), "curve": (0.5, 2.0), "pipe_loss": (0.6, 2.0), "valve_loss": (0.5, 2.0),
            "efficiency": (0.7, 1.12), "warming": (0.6, 1.8)}  # fmt: skip
    units = {"head": "kPa", "efficiency": "-", "warming": "K/kW"}
    parameters = {k: (v, ends[k][0] * v, ends[k][1] * v, units.get(k, "kPa s2/l2")) for k, v in NOMINAL.items()}
    return function_twin(pump, READINGS, loads=("speed", "opening"), parameters=parameters)


def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
    """Return what the asset shows (n_readings,): the flow at which the heads agree."""
    speed, opening = loads["speed"], loads["opening"]
    p = {name: value * own[name] * (1.0 + faults.get(name, 0.0)) for name, value in NOMINAL.items()}
    low, high = 0.0, 60.0
    for _ in range(60):
        flow = 0.5 * (low + high)
        through = flow * (1.0 + 0.02 + faults.get("recirculation", 0.0) * (1.0 - flow / 20.0))
        lift = p["head"] * speed**1.9 - p["curve"] * through**2
        lift -= faults.get("cavitation", 0.0) * max(0.0, flow - 8.0) ** 2
        pipe = p["pipe_loss"] * flow**1.85 * 10.0**0.15
        valve = p["valve_loss"] * flow**2 / opening**2 + faults.get("sticking_flap", 0.0) * 10.0 / (1.0 + flow)
        low, high = (flow, high) if lift > pipe + valve else (low, flow)
    best = 1.04 - 0.15 * (flow / (12.0 * speed) - 1.0) ** 2
    shaft = 1e-3 * lift * through / (p["efficiency"] * best) + faults.get("rubbing_ring", 0.0) * speed * 0.1
    return np.array([flow, lift, pipe, valve, shaft, p["warming"] * (0.93 * shaft + 0.12 * speed)])


PUMP = Machine(
    name="pump",
    twin=twin,
    cells=[{"speed": s, "opening": o} for s in (0.7, 0.85, 1.0) for o in (0.4, 0.6, 1.0)],
    repeats=8,
    noise=np.array([0.08, 1.2, 0.8, 0.8, 0.02, 0.2]),
    own=lambda rng: {name: off(rng) for name in NOMINAL},
    measure=measure,
    faults={"head": (-0.15, -0.03), "curve": (0.1, 0.6), "pipe_loss": (0.08, 0.4), "valve_loss": (0.08, 0.4),
            "efficiency": (-0.2, -0.05), "warming": (0.08, 0.4)},
    outside={"recirculation": (0.05, 0.2), "cavitation": (2.0, 8.0), "sticking_flap": (3.0, 15.0),
             "rubbing_ring": (0.8, 3.0)},
)  # fmt: skip
