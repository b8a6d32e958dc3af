"""One truth as recordings of many formats: a beam of three gauges, two loads, a fault, a gap and bad samples."""

import json
import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.recordings import BEAM, START, UNITS, Series, write_mdf, write_tdms

RATE, HOLD, RAMP = 100.0, 6.0, 1.0
PLATEAUS = ((0, 0), (40, 0), (40, 20), (80, 20), (0, 20), (80, 0))
GAP, BAD = slice(900, 960), slice(1650, 1680)
"""Samples that no file holds, in a plateau, and those of the gauge g2 that are no readings."""
CHANNELS = tuple(UNITS)
GAUGES = CHANNELS[2:]
CODES = ("LDF", "LDM", "SG1", "SG2", "SG3")


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


def write_ulog(path: Path, series: Series) -> None:
    """Write by the specification: header, flags, formats, subscriptions, data; gauges are a topic that is split."""

    def message(kind: bytes, content: bytes) -> bytes:
        return struct.pack("<Hc", len(content), kind) + content

    found = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", START) + message(b"B", bytes(40))
    found += message(b"F", b"loads:uint64_t timestamp;double force;double moment;")
    found += message(b"F", b"gauges:uint64_t timestamp;double[3] g;")
    for number, name in ((0, b"loads"), (1, b"gauges")):
        found += message(b"A", struct.pack("<BH", 0, number) + name)
    stamps = np.round(series["time"] * 1e6).astype(np.int64) + START
    half = len(stamps) // 2
    for k, stamp in enumerate(stamps.tolist()):
        if k == half:
            found += message(b"A", struct.pack("<BH", 0, 2) + b"gauges")
        found += message(b"D", struct.pack("<HQdd", 0, stamp, series["force"][k], series["moment"][k]))
        found += message(b"D", struct.pack("<HQddd", 1 + (k >= half), stamp, *(series[name][k] for name in GAUGES)))
    path.write_bytes(found)


def write_dataflash(path: Path, series: Series) -> None:
    """Write by the specification: formats, units, multipliers; forces in centinewtons, gauges as instances."""

    def message(kind: int, content: bytes) -> bytes:
        return b"\xa3\x95" + bytes([kind]) + content

    def form(kind: int, name: str, fields: str, columns: str) -> bytes:
        size = 3 + struct.calcsize(
            "<" + fields.translate({ord("n"): "4s", ord("N"): "16s", ord("Z"): "64s", ord("c"): "h"})
        )
        return message(128, struct.pack("<BB4s16s64s", kind, size, name.encode(), fields.encode(), columns.encode()))

    found = form(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    found += form(129, "UNIT", "QbZ", "TimeUS,Id,Label") + form(130, "MULT", "Qbd", "TimeUS,Id,Mult")
    found += form(131, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds")
    found += form(140, "LOAD", "Qdd", "TimeUS,F,M") + form(141, "GAGE", "QBd", "TimeUS,I,S")
    for key, label in (("s", b"s"), ("N", b"N"), ("m", b"N.m"), ("u", b"m/m"), ("#", b"instance")):
        found += message(129, struct.pack("<Qb64s", 0, ord(key), label))
    for key, factor in (("F", 1e-6), ("-", 0.0), ("B", 1e-2)):
        found += message(130, struct.pack("<Qbd", 0, ord(key), factor))
    found += message(131, struct.pack("<QB16s16s", 0, 140, b"sNm", b"FB-"))
    found += message(131, struct.pack("<QB16s16s", 0, 141, b"s#u", b"F-F"))
    for k, stamp in enumerate(np.round(series["time"] * 1e6).astype(np.int64).tolist()):
        found += message(140, struct.pack("<Qdd", stamp + 10**6, series["force"][k] * 100.0, series["moment"][k]))
        for number, name in enumerate(GAUGES):
            found += message(141, struct.pack("<QBd", stamp + 10**6, number, series[name][k]))
    path.write_bytes(found)


def write_mcap(path: Path, series: Series) -> None:
    from mcap.writer import Writer

    with path.open("wb") as stream:
        file = Writer(stream)
        file.start()
        schema = file.register_schema("beam", "jsonschema", b"{}")
        channel = file.register_channel("/beam", "json", schema)
        for k, at in enumerate(series["time"]):
            instant = START * 10**9 + round(at * 1e9)
            numbers = {name: None if np.isnan(series[name][k]) else float(series[name][k]) for name in CHANNELS}
            file.add_message(channel, instant, json.dumps(numbers).encode(), instant)
        file.finish()


def write_bag(path: Path, series: Series) -> None:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    kind = store.types["std_msgs/msg/Float64"]
    with Writer(path) as file:
        topics = {name: file.add_connection(f"/beam/{name}", kind.__msgtype__, typestore=store) for name in CHANNELS}
        for k, at in enumerate(series["time"]):
            for name, topic in topics.items():
                data = store.serialize_ros1(kind(data=float(series[name][k])), kind.__msgtype__)
                file.write(topic, START * 10**9 + round(at * 1e9), data)


def write_miniseed(path: Path, series: Series) -> None:
    import obspy

    stream = obspy.Stream()
    for code, name in zip(CODES, CHANNELS, strict=True):
        known = np.isfinite(series[name])
        breaks = np.diff(series["time"], prepend=series["time"][0]) > 1.5 / RATE
        number = np.cumsum(breaks | (np.diff(known, prepend=known[0]) != 0))
        for piece in np.unique(number[known]):
            part = (number == piece) & known
            header = {"network": "XX", "station": "BEAM", "channel": code, "sampling_rate": RATE}
            start = obspy.UTCDateTime(START) + float(series["time"][part][0])
            stream.append(obspy.Trace(series[name][part], {**header, "starttime": start}))
    stream.write(str(path), format="MSEED", encoding="FLOAT64")


def write_uff(path: Path, series: Series) -> None:
    import pyuff

    place = {"func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0, "binary": 0, "ord_data_type": 4}
    axes = {"abscissa": 17, "ordinate": 3, "orddenom": 0, "z_axis": 0}
    place |= {"abscissa_spacing": 0} | {f"{axis}_spec_data_type": kind for axis, kind in axes.items()}
    for k, name in enumerate(CHANNELS):
        known = np.isfinite(series[name])
        arrays = {"x": series["time"][known], "data": series[name][known]}
        one = pyuff.prepare_58(id1=name, ordinate_axis_units_lab=UNITS[name], **place, **arrays)
        pyuff.UFF(str(path)).write_sets([one], mode="add" if k else "overwrite")


def write_mat(path: Path, series: Series) -> None:
    import scipy.io

    beam = {"time": series["time"], "loads": np.column_stack([series["force"], series["moment"]])}
    beam["gauges"] = np.column_stack([series[name] for name in GAUGES])
    scipy.io.savemat(path, {"beam": beam})


def write_toa5(path: Path, series: Series) -> None:
    lines = [
        '"TOA5","CR6","CR6","1234","CR6.Std","CPU:beam.CR6","1","Fast"',
        '"TIMESTAMP","RECORD","force","moment","g1","g2","g3"',
    ]
    lines += ['"TS","RN","N","N m","um/m","um/m","um/m"', '"","","Smp","Smp","Smp","Smp","Smp"']
    for k, at in enumerate(series["time"]):
        stamp = str(np.datetime64(START, "s") + np.timedelta64(round(at * 100), "ms") * 10).replace("T", " ")
        cells = ('"NAN"' if np.isnan(series[name][k]) else f"{series[name][k]:.9g}" for name in CHANNELS)
        lines.append(f'"{stamp}",{k},{",".join(cells)}')
    path.write_text("\r\n".join(lines) + "\r\n")


def write_lvm(path: Path, series: Series) -> None:
    lines = ["LabVIEW Measurement", "Writer_Version\t2", "Separator\tTab", "***End_of_Header***", ""]
    lines += ["Channels\t5", "***End_of_Header***", "\t".join(["X_Value", *CHANNELS, "Comment"])]
    for k, at in enumerate(series["time"]):
        lines.append("\t".join([f"{at:.6f}", *(f"{series[name][k]:.9g}" for name in CHANNELS)]))
    path.write_text("\n".join(lines) + "\n")


def _places(*names: str) -> dict[str, str]:
    return dict(zip(CHANNELS, names, strict=True))


FORMATS: dict[str, tuple[str, Callable[[Path, Series], None], Mapping[str, str]]] = {
    "TDMS": ("run.tdms", write_tdms, _places(*(f"Beam/{name}" for name in CHANNELS))),
    "MDF": ("run.mf4", write_mdf, _places(*CHANNELS)),
    "ULog": ("run.ulg", write_ulog, _places("loads/force", "loads/moment", *(f"gauges/g[{k}]" for k in range(3)))),
    "DataFlash": ("run.bin", write_dataflash, _places("LOAD/F", "LOAD/M", *(f"GAGE[{k}]/S" for k in range(3)))),
    "MCAP": ("run.mcap", write_mcap, _places(*(f"/beam/{name}" for name in CHANNELS))),
    "rosbag": ("run.bag", write_bag, _places(*(f"/beam/{name}/data" for name in CHANNELS))),
    "miniSEED": ("run.mseed", write_miniseed, _places(*(f"XX.BEAM..{code}" for code in CODES))),
    "UFF58": ("run.uff", write_uff, _places(*CHANNELS)),
    "MAT": (
        "run.mat",
        write_mat,
        _places(*(f"beam/loads/{k}" for k in (1, 2)), *(f"beam/gauges/{k}" for k in (1, 2, 3))),
    ),
    "TOA5": ("run.dat", write_toa5, _places(*CHANNELS)),
    "lvm": ("run.lvm", write_lvm, _places(*CHANNELS)),
}
"""Name of a file, its writer, and its channels by the twin's names."""


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
