"""One truth as recordings of many formats: a beam of three gauges, two loads, a fault, a gap and bad samples."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.recordings import BEAM, CHANNELS, GAUGES, Series, write_uff

RATE, HOLD, RAMP = 100.0, 6.0, 1.0
PLATEAUS = ((0, 0), (40, 0), (40, 20), (80, 20), (0, 20), (80, 0))
GAP, BAD = slice(900, 960), slice(1650, 1680)
"""Samples that no file holds, in a plateau, and those of the gauge g2 that are no readings."""


def truth(gain: float = 1.25) -> dict[str, np.ndarray]:
    """Return the samples (n,) of every channel and of "time" [s]; NaN where a reading is bad, nothing in the gap."""
    rng, space = np.random.default_rng(7), dict[str, Any]()
    knots = np.add.outer(np.arange(len(PLATEAUS)) * (HOLD + RAMP), [0.0, HOLD]).ravel()
    time = np.arange(0.0, knots[-1], 1.0 / RATE)
    force, moment = (np.interp(time, knots, np.repeat(np.array(PLATEAUS, float)[:, k], 2)) for k in (0, 1))
    exec(BEAM, space)
    clean = space["beam"]({"stiffness": 100.0, "gain_g2": gain}, {"force": force, "moment": moment})
    found = {"time": time, "force": force, "moment": moment, **dict(zip(GAUGES, clean, strict=True))}
    for name in CHANNELS:
        noise = np.zeros(len(time))
        for k, shock in enumerate(rng.standard_normal(len(time))):  # remembers some three samples
            noise[k] = 0.7 * noise[k - 1] + shock
        found[name] = found[name] + {"force": 0.01, "moment": 0.005}.get(name, 1.0) * noise
    found["g2"][BAD] = np.nan
    return {name: np.delete(values, np.r_[GAP]) for name, values in found.items()}


def as_csv(series: Series) -> str:
    """Return the campaign that somebody cut by hand: the middle of each plateau, sample by sample."""
    rows = ["test,force,moment,g1,g2,g3,time"]
    for k in range(len(PLATEAUS)):
        inside = np.flatnonzero(np.abs(series["time"] - k * (HOLD + RAMP) - HOLD / 2) < 0.4 * HOLD)
        force, moment = (round(float(series[name][inside].mean()), 6) for name in ("force", "moment"))
        for row in inside[::20]:
            cells = ("" if np.isnan(series[name][row]) else f"{series[name][row]:.9g}" for name in GAUGES)
            rows.append(f"run,{force},{moment},{','.join(cells)},{series['time'][row]:.6f}")
    return "\n".join(rows) + "\n"


def _tdms(unit: str, *names: str) -> Callable[[Path], None]:
    """Return what writes a group with times in milliseconds, as the first name says, and the steps as force."""

    def write(path: Path) -> None:
        from nptdms import ChannelObject, TdmsWriter

        with TdmsWriter(path) as file:
            series = (np.full(5, 20.0), 100.0 * STEPS) if len(names) > 1 else (100.0 * STEPS,)
            own = [
                ChannelObject("G", name, values, {"unit_string": unit})
                for name, values in zip(names, series, strict=False)
            ]
            file.write_segment([*own, ChannelObject("G", "force", STEPS, {"unit_string": "N"})])

    return write


def _unfinished(path: Path) -> None:
    """Write a file of MDF that its logger did not end, as its head says."""
    import asammdf

    with asammdf.MDF(version="4.10") as file:
        file.append(asammdf.Signal(STEPS, 0.1 * STEPS, name="force"))
        file.save(path)
    path.write_bytes(b"UnFinMF " + path.read_bytes()[8:])


def _mat(content: Mapping[str, Any]) -> Callable[[Path], None]:
    import scipy.io

    return lambda path: scipy.io.savemat(path, content)


def _uff(header: Mapping[str, Any]) -> Callable[[Path], None]:
    """Return what writes a set before the series, as programs of modal analysis do."""

    def write(path: Path) -> None:
        import pyuff

        write_uff(path, dict.fromkeys(CHANNELS, STEPS) | {"time": 0.1 * STEPS})
        series = path.read_bytes()
        pyuff.UFF(str(path)).write_sets([header], mode="overwrite")
        path.write_bytes(path.read_bytes() + series)

    return write


STEPS = np.arange(5.0)
SIGNALS = np.array([(STEPS, "force"), (2 * STEPS, "g1")], dtype=[("values", object), ("label", object)])
SI = {"type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1, "length": 1, "force": 1, "temp": 1}
WAYS: dict[str, tuple[str, Callable[[Path], Any], str]] = {
    "times of TDMS in a unit": ("a.tdms", _tdms("ms", "Time"), "G/force"),
    "times of TDMS with their unit behind": ("a.tdms", _tdms("", "Time [ms]"), "G/force"),
    "a temperature t before the times": ("a.tdms", _tdms("", "t [degC]", "Time (ms)"), "G/force"),
    "MDF that was not finished": ("a.mf4", _unfinished, "force"),
    "a temperature t in a table": (
        "a.csv",
        lambda path: path.write_text("t [°C],Time [ms],force\n" + "".join(f"20,{100 * k},{k}\n" for k in range(5))),
        "force",
    ),
    "a Simulink structure with time": (
        "a.mat",
        _mat({"out": {"time": 0.1 * STEPS, "signals": SIGNALS}}),
        "out/signals/values/1",
    ),
    "a row for each channel": ("a.mat", _mat({"t": 0.1 * STEPS, "M": np.stack([STEPS, -STEPS])}), "M/1"),
    "a row for each channel at a rate": ("a.mat", _mat({"fs": 10, "M": np.stack([STEPS, -STEPS])}), "M/1"),
    "times that are texts beside a rate": ("a.mat", _mat({"time": ["0 s"] * 5, "Fs": 10.0, "f": STEPS}), "f"),
    "units before the series": ("a.uff", _uff(SI | {"temp_offset": 273.15}), "force"),
}
"""File, its writer, and the channel of the numbers 0 to 4 at steps of 0.1 s, in ways in which programs write it."""
