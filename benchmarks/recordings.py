"""A beam of three gauges under two loads, and its recordings: for the benchmark, the fuzz of files and the tests."""

import datetime
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from asammdf import MDF, Signal
from nptdms import ChannelObject, TdmsWriter
from numpy.typing import NDArray

from octmip.recordings import recording

STEP, START = 1e-3, 1_700_000_000
"""Of a sample [s], and the beginning [s since 1970]."""
UNITS = {"force": "N", "moment": "N m", "g1": "um/m", "g2": "um/m", "g3": "um/m"}
BEAM = """
def beam(parameters, loads):
    scale, force, moment = 100.0 / parameters["stiffness"], loads["force"], loads["moment"]
    gain = parameters["gain_g2"]
    return [scale * (9 * force + 4 * moment), gain * scale * (5 * force + 6 * moment), scale * (2 * force + 7 * moment)]
"""
CARD = {
    "readings": dict.fromkeys(("g1", "g2", "g3"), "microstrain"),
    "loads": ["force", "moment"],
    "parameters": {"stiffness": [100, 70, 130, "%"], "gain_g2": [1, 0.7, 1.3, "-"]},
    "linear": True,
}
Series = Mapping[str, NDArray[np.float64]]


def series(n: int) -> Series:
    """Return n samples of every channel: ten plateaus of both loads, the gauge g2 with a gain of 1.25."""
    rng = np.random.default_rng(11)
    knots = np.linspace(0.0, n, 21)
    force, moment = (
        np.interp(np.arange(n), knots[:-1], np.repeat(levels, 2))
        for levels in ([0, 40, 40, 80, 0] * 2, [0, 0, 20, 20, 20] * 2)
    )
    found = {"time": STEP * np.arange(n), "force": force, "moment": moment, "g1": 9 * force + 4 * moment}
    found |= {"g2": 1.25 * (5 * force + 6 * moment), "g3": 2 * force + 7 * moment}
    sd = {"time": 0.0, "force": 0.02, "moment": 0.01}
    return {name: values + sd.get(name, 1.0) * rng.standard_normal(n) for name, values in found.items()}


def write_tdms(path: Path, samples: Series) -> None:
    """Write waveforms, a segment for each stretch without a gap."""
    time = samples["time"]
    step = float(np.median(np.diff(time)))
    with TdmsWriter(path) as file:
        for part in np.split(np.arange(len(time)), np.flatnonzero(np.diff(time) > 1.5 * step) + 1):
            start = np.datetime64(START, "s") + np.timedelta64(round(time[part[0]] * 1e6), "us")
            waveform = {"wf_start_time": start, "wf_increment": step, "wf_start_offset": 0.0}
            file.write_segment(
                [
                    ChannelObject("Beam", name, samples[name][part], waveform | {"unit_string": UNITS[name]})
                    for name in UNITS
                ]
            )


def write_mdf(path: Path, samples: Series) -> None:
    """Write one group whose channels have one time; NaN is a number whose invalidation bit is set."""
    file = MDF(version="4.10")
    file.header.start_time = datetime.datetime.fromtimestamp(START, datetime.UTC)
    signals = []
    for name, unit in UNITS.items():
        bad = np.isnan(samples[name])
        values, bits = np.where(bad, 99999.0, samples[name]), bad if bad.any() else None
        signals.append(Signal(values, samples["time"], name=name, unit=unit, invalidation_bits=bits))
    file.append(signals)
    file.save(path, overwrite=True)
    file.close()


WRITERS: Mapping[str, Callable[[Path, Series], None]] = {"tdms": write_tdms, "mf4": write_mdf}


def make_recording(number: int, folder: Path) -> None:
    """Write a short recording, of another format for every other number, as the file "run"."""
    ending = list(WRITERS)[number % len(WRITERS)]
    WRITERS[ending](folder / f"run.{ending}", series(200 + number))
    (folder / f"run.{ending}").rename(folder / "run")


def read_recording(_: np.random.Generator, folder: Path) -> None:
    """Read every channel."""
    opened = recording(folder / "run")
    for name in opened.channels:
        opened[name].notes()
