"""A beam of three gauges under two loads, and its recordings: for the benchmark, the fuzz of files and the tests."""

import datetime
import json
import struct
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.recordings import recording

STEP, START = 1e-3, 1_700_000_000
"""Of a sample [s], and the beginning [s since 1970]."""
UNITS = {"force": "N", "moment": "N m", "g1": "um/m", "g2": "um/m", "g3": "um/m"}
CHANNELS = tuple(UNITS)
GAUGES = CHANNELS[2:]
CODES = ("LDF", "LDM", "SG1", "SG2", "SG3")
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
    from nptdms import ChannelObject, TdmsWriter

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
    from asammdf import MDF, Signal

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


def _packed(columns: Iterable[tuple[str, Any]], n: int) -> NDArray[np.void]:
    """Return n records without padding; a column is its type and its numbers, or one for all."""
    parts = list(columns)
    found = np.zeros(n, dtype=[(f"f{k}", kind) for k, (kind, _) in enumerate(parts)])
    for k, (_, values) in enumerate(parts):
        found[f"f{k}"] = values
    return found


def write_ulog(path: Path, samples: Series) -> None:
    """Write by the specification: header, flags, formats, subscriptions, data; gauges are a topic that is split."""

    def message(kind: bytes, content: bytes) -> bytes:
        return struct.pack("<Hc", len(content), kind) + content

    head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", START) + message(b"B", bytes(40))
    head += message(b"F", b"loads:uint64_t timestamp;double force;double moment;")
    head += message(b"F", b"gauges:uint64_t timestamp;double[3] g;")
    head += message(b"A", struct.pack("<BH", 0, 0) + b"loads") + message(b"A", struct.pack("<BH", 0, 1) + b"gauges")
    stamps = np.round(samples["time"] * 1e6).astype(np.int64) + START
    half = len(stamps) // 2
    with path.open("wb") as file:
        file.write(head)
        for part, number in ((slice(half), 1), (slice(half, None), 2)):
            columns = [("<u2", 26), ("S1", b"D"), ("<u2", 0), ("<u8", stamps[part])]
            columns += [("<f8", samples[name][part]) for name in CHANNELS[:2]]
            columns += [("<u2", 34), ("S1", b"D"), ("<u2", number), ("<u8", stamps[part])]
            columns += [("<f8", samples[name][part]) for name in GAUGES]
            file.write(message(b"A", struct.pack("<BH", 0, 2) + b"gauges") if number == 2 else b"")
            _packed(columns, len(stamps[part])).tofile(file)


def write_dataflash(path: Path, samples: Series) -> None:
    """Write by the specification: formats, units, multipliers; forces in centinewtons, gauges as instances."""

    def message(kind: int, content: bytes) -> bytes:
        return b"\xa3\x95" + bytes([kind]) + content

    def form(kind: int, name: str, fields: str, columns: str) -> bytes:
        size = 3 + struct.calcsize(
            "<" + fields.translate({ord("n"): "4s", ord("N"): "16s", ord("Z"): "64s", ord("c"): "h"})
        )
        return message(128, struct.pack("<BB4s16s64s", kind, size, name.encode(), fields.encode(), columns.encode()))

    head = form(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    head += form(129, "UNIT", "QbZ", "TimeUS,Id,Label") + form(130, "MULT", "Qbd", "TimeUS,Id,Mult")
    head += form(131, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds")
    head += form(140, "LOAD", "Qdd", "TimeUS,F,M") + form(141, "GAGE", "QBd", "TimeUS,I,S")
    for key, label in (("s", b"s"), ("N", b"N"), ("m", b"N.m"), ("u", b"m/m"), ("#", b"instance")):
        head += message(129, struct.pack("<Qb64s", 0, ord(key), label))
    for key, factor in (("F", 1e-6), ("-", 0.0), ("B", 1e-2)):
        head += message(130, struct.pack("<Qbd", 0, ord(key), factor))
    head += message(131, struct.pack("<QB16s16s", 0, 140, b"sNm", b"FB-"))
    head += message(131, struct.pack("<QB16s16s", 0, 141, b"s#u", b"F-F"))
    stamps = np.round(samples["time"] * 1e6).astype(np.int64) + 10**6
    columns = [("S3", b"\xa3\x95\x8c"), ("<u8", stamps)]
    columns += [("<f8", 100.0 * samples["force"]), ("<f8", samples["moment"])]
    for number, name in enumerate(GAUGES):
        columns += [("S3", b"\xa3\x95\x8d"), ("<u8", stamps), ("u1", number), ("<f8", samples[name])]
    with path.open("wb") as file:
        file.write(head)
        _packed(columns, len(stamps)).tofile(file)


def write_mcap(path: Path, samples: Series) -> None:
    """Write messages in JSON."""
    from mcap.writer import Writer

    with path.open("wb") as stream:
        file = Writer(stream)
        file.start()
        channel = file.register_channel("/beam", "json", file.register_schema("beam", "jsonschema", b"{}"))
        for at, *numbers in zip(samples["time"].tolist(), *(samples[name].tolist() for name in CHANNELS), strict=True):
            instant = START * 10**9 + round(at * 1e9)
            content = {name: None if one != one else one for name, one in zip(CHANNELS, numbers, strict=True)}
            file.add_message(channel, instant, json.dumps(content).encode(), instant)
        file.finish()  # type: ignore[no-untyped-call]


def write_bag(path: Path, samples: Series) -> None:
    """Write a bag of ROS 1: a message of all channels."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    kind, layout = (store.types[f"std_msgs/msg/{name}"] for name in ("Float64MultiArray", "MultiArrayLayout"))
    empty, rows = layout(dim=[], data_offset=0), np.column_stack([samples[name] for name in CHANNELS])
    with Writer(path) as file:
        topic = file.add_connection("/beam", kind.__msgtype__, typestore=store)
        for at, numbers in zip(samples["time"].tolist(), rows, strict=True):
            data = store.serialize_ros1(kind(layout=empty, data=numbers), kind.__msgtype__)
            file.write(topic, START * 10**9 + round(at * 1e9), data)


def write_miniseed(path: Path, samples: Series) -> None:
    """Write traces, one for each stretch without a gap or a bad sample."""
    import obspy

    step, stream = float(np.median(np.diff(samples["time"]))), obspy.Stream()
    for code, name in zip(CODES, CHANNELS, strict=True):
        known = np.isfinite(samples[name])
        breaks = np.diff(samples["time"], prepend=samples["time"][0]) > 1.5 * step
        number = np.cumsum(breaks | (np.diff(known, prepend=known[0]) != 0))
        for piece in np.unique(number[known]):
            part = (number == piece) & known
            header = {"network": "XX", "station": "BEAM", "channel": code, "sampling_rate": round(1.0 / step, 6)}
            start = obspy.UTCDateTime(START) + float(samples["time"][part][0])
            stream.append(obspy.Trace(samples[name][part], {**header, "starttime": start}))
    stream.write(str(path), format="MSEED", encoding="FLOAT64")


def write_uff(path: Path, samples: Series) -> None:
    """Write time responses as text, without the bad samples."""
    import pyuff

    place = {"func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0, "binary": 0, "ord_data_type": 4}
    axes = {"abscissa": 17, "ordinate": 3, "orddenom": 0, "z_axis": 0}
    place |= {"abscissa_spacing": 0} | {f"{axis}_spec_data_type": kind for axis, kind in axes.items()}
    for k, name in enumerate(CHANNELS):
        known = np.isfinite(samples[name])
        arrays = {"x": samples["time"][known], "data": samples[name][known]}
        one = pyuff.prepare_58(id1=name, ordinate_axis_units_lab=UNITS[name], **place, **arrays)
        pyuff.UFF(str(path)).write_sets([one], mode="add" if k else "overwrite")


def write_mat(path: Path, samples: Series) -> None:
    """Write a structure of the times and two matrices."""
    import scipy.io

    beam = {"time": samples["time"], "loads": np.column_stack([samples["force"], samples["moment"]])}
    beam["gauges"] = np.column_stack([samples[name] for name in GAUGES])
    scipy.io.savemat(path, {"beam": beam})


def _texts(samples: Series, missing: str) -> list[list[str]]:
    """Return the cells of every channel with nine digits."""
    return [[missing if one != one else f"{one:.9g}" for one in samples[name].tolist()] for name in CHANNELS]


def write_toa5(path: Path, samples: Series) -> None:
    """Write the table of a Campbell logger."""
    head = '"TOA5","CR6","CR6","1234","CR6.Std","CPU:beam.CR6","1","Fast"\r\n'
    head += '"TIMESTAMP","RECORD","force","moment","g1","g2","g3"\r\n'
    head += '"TS","RN","N","N m","um/m","um/m","um/m"\r\n"","","Smp","Smp","Smp","Smp","Smp"\r\n'
    at = np.round(samples["time"] * 1000).astype(np.int64)
    stamps = np.char.replace((np.datetime64(START * 1000, "ms") + at).astype(str), "T", " ")
    rows = zip(stamps.tolist(), map(str, range(len(at))), *_texts(samples, '"NAN"'), strict=True)
    with path.open("w", newline="") as file:
        file.write(head)
        file.writelines(f'"{stamp}",{",".join(cells)}\r\n' for stamp, *cells in rows)


def write_lvm(path: Path, samples: Series) -> None:
    """Write a measurement of LabVIEW."""
    head = "LabVIEW Measurement\nWriter_Version\t2\nSeparator\tTab\n***End_of_Header***\n\n"
    head += "Channels\t5\n***End_of_Header***\n" + "\t".join(["X_Value", *CHANNELS, "Comment"])
    rows = zip((f"{at:.6f}" for at in samples["time"].tolist()), *_texts(samples, "nan"), strict=True)
    path.write_text("\n".join([head, *("\t".join(row) for row in rows)]) + "\n")


def _places(*names: str) -> dict[str, str]:
    return dict(zip(CHANNELS, names, strict=True))


FORMATS: dict[str, tuple[str, Callable[[Path, Series], None], Mapping[str, str]]] = {
    "TDMS": ("run.tdms", write_tdms, _places(*(f"Beam/{name}" for name in CHANNELS))),
    "MDF": ("run.mf4", write_mdf, _places(*CHANNELS)),
    "ULog": ("run.ulg", write_ulog, _places("loads/force", "loads/moment", *(f"gauges/g[{k}]" for k in range(3)))),
    "DataFlash": ("run.bin", write_dataflash, _places("LOAD/F", "LOAD/M", *(f"GAGE[{k}]/S" for k in range(3)))),
    "MCAP": ("run.mcap", write_mcap, _places(*(f"/beam/{name}" for name in CHANNELS))),
    "rosbag": ("run.bag", write_bag, _places(*(f"/beam/data.{k}" for k in range(5)))),
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


def make_recording(number: int, folder: Path) -> None:
    """Write a short recording, of TDMS or MDF for every other number, as the file "run"."""
    name, write, _ = FORMATS[("TDMS", "MDF")[number % 2]]
    write(folder / name, series(200 + number))
    (folder / name).rename(folder / "run")


def read_recording(_: np.random.Generator, folder: Path) -> None:
    """Read every channel."""
    opened = recording(folder / "run")
    for name in opened.channels:
        opened[name].notes()
