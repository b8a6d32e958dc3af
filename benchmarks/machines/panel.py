"""A string of solar cells, read at four irradiances and two temperatures of the air.

The twin has one diode, solved by steps, with constant elements. The asset's shunt falls with the light, its current
rises with the temperature, its back is cooled by wind that the user does not know. Each constant is 3 to 12 % off
besides.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.machines.machine import Machine, Numbers, off
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, function_twin

READINGS = {"short": "A", "open": "V", "current": "A", "voltage": "V", "back": "K"}
NOMINAL = {"light": 9.0, "series": 0.35, "shunt": 220.0, "ideality": 1.25, "heating": 0.03}
CELLS, FALL = 60.0, 0.0021
"""Cells in the string; fall of each one's voltage [V/K]."""
POINTS = np.linspace(0.0, 1.0, 401)


def _curve(light: float, series: float, shunt: float, ideality: float, hot: float) -> tuple[float, float, float, float]:
    """Return short and open point, and current and voltage at the greatest power, by the inner voltage."""
    thermal = CELLS * ideality * 0.0257 * (1.0 + hot / 298.0)
    dark = 9.0 * np.exp(-(0.63 - FALL * hot) * CELLS / (CELLS * 1.25 * 0.0257))
    most = thermal * np.log1p(light / dark)
    inner = most * POINTS
    current = light - dark * np.expm1(inner / thermal) - inner / shunt
    outer = inner - series * current
    best = int(np.argmax(np.where(current > 0.0, current * outer, 0.0)))
    peak = slice(best - 2, best + 3)
    a, b, _ = np.polyfit(inner[peak], (current * outer)[peak], 2)
    at = float(np.clip(-b / (2.0 * a), inner[best - 2], inner[best + 2]))
    i = light - dark * np.expm1(at / thermal) - at / shunt
    return (
        float(np.interp(0.0, outer, current)),
        float(np.interp(0.0, -current, inner)),
        float(i),
        float(at - series * i),
    )


def panel(parameters: Numbers, loads: Numbers) -> Sequence[float]:
    """Return the readings of the user's model."""
    p, sun, air = parameters, loads["sun"], loads["air"]
    warm = p["heating"] * sun
    return [*_curve(p["light"] * sun / 1000.0, p["series"], p["shunt"], p["ideality"], air + warm - 25.0), warm]


def twin() -> FunctionTwin:
    """Return the user's twin."""
    ends = {
        "light": (0.7, 1.1),
        "series": (0.5, 4.0),
        "shunt": (0.1, 2.0),
        "ideality": (0.85, 1.4),
        "heating": (0.6, 1.8),
    }
    units = {"light": "A", "series": "ohm", "shunt": "ohm", "heating": "K m2/W"}
    parameters = {k: (v, v * ends[k][0], v * ends[k][1], units.get(k, "-")) for k, v in NOMINAL.items()}
    return function_twin(panel, READINGS, loads=("sun", "air"), parameters=parameters)


def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
    """Return what the asset shows (n_readings,)."""
    sun, air = loads["sun"], loads["air"]
    p = {name: value * own[name] * (1.0 + faults.get(name, 0.0)) for name, value in NOMINAL.items()}
    warm = p["heating"] * sun * (1.0 - 0.05 * sun / 1000.0) + faults.get("hot_spot", 0.0) * (sun / 1000.0) ** 3 * 10.0
    hot = air + warm - 25.0
    light = (
        p["light"]
        * sun
        / 1000.0
        * (1.0 + 0.0005 * hot)
        * (1.0 - faults.get("low_sun_dust", 0.0) * (1.0 - sun / 1000.0))
    )
    shunt = p["shunt"] / (0.8 + 0.25 * sun / 1000.0) / (1.0 + faults.get("leaking_frame", 0.0) * sun / 1000.0)
    short, opened, i, v = _curve(light, p["series"], shunt, p["ideality"], hot)
    drop = faults.get("bypass", 0.0) * max(0.0, sun - 400.0) / 600.0
    return np.array([short, opened - drop, i, v - 1.5 * drop, warm])


PANEL = Machine(
    name="panel",
    twin=twin,
    cells=[{"sun": s, "air": a} for s in (250.0, 500.0, 750.0, 1000.0) for a in (10.0, 35.0)],
    repeats=8,
    noise=np.array([0.02, 0.06, 0.03, 0.1, 0.4]),
    own=lambda rng: {name: off(rng) for name in NOMINAL},
    measure=measure,
    faults={"light": (-0.15, -0.03), "series": (0.3, 2.0), "shunt": (-0.8, -0.3), "ideality": (0.05, 0.25),
            "heating": (0.1, 0.5)},
    outside={"hot_spot": (0.3, 1.5), "low_sun_dust": (0.05, 0.2), "leaking_frame": (1.0, 5.0), "bypass": (0.5, 2.5)},
)  # fmt: skip
