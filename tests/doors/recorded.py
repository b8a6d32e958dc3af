"""One truth as recordings of many formats, and small files as other programs write them, with what each says."""

import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from benchmarks.recordings import BEAM, CHANNELS, GAUGES, START, Series, write_uff

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


class File(NamedTuple):
    """A file, its writer, times, numbers and unit of some channels, words of a note, and the error of the first."""

    name: str
    write: Callable[[Path], Any]
    channels: Mapping[str, tuple[Any, ...]]
    said: str = ""
    error: str = ""


STEPS = np.arange(5.0)
TENTHS = 0.1 * STEPS
DAYS = 739_000.0 + TENTHS
EVEN = {"wf_increment": 0.1}
STAMPS = np.datetime64(START, "s") + np.arange(5) * np.timedelta64(100, "ms")


def tdms(*channels: tuple[str, Any, Mapping[str, Any]], apart: bool = False) -> Callable[[Path], None]:
    """Return what writes channels GROUP:NAME with numbers and properties, one segment for all or for each."""

    def write(path: Path) -> None:
        from nptdms import ChannelObject, TdmsWriter

        own = [ChannelObject(*place.split(":"), values, given) for place, values, given in channels]
        with TdmsWriter(path) as file:
            for segment in [[one] for one in own] if apart else [own]:
                file.write_segment(segment)

    return write


def scaled(slope: float) -> Mapping[str, Any]:
    scale = {"Scale_Type": "Linear", "Linear_Slope": slope, "Linear_Y_Intercept": 0.0, "Linear_Input_Source": 0}
    return {"NI_Number_Of_Scales": 1, "wf_increment": 0.1, **{f"NI_Scale[0]_{key}": own for key, own in scale.items()}}


def mdf(version: str = "4.10", is_finished: bool = True, **master: Any) -> Callable[[Path], None]:
    """Return what writes a channel of MDF over time or another quantity; a logger's head says whether it ended it."""

    def write(path: Path) -> None:
        import asammdf

        with asammdf.MDF(version=version) as file:
            file.append(asammdf.Signal(STEPS, TENTHS, name="force", **master))
            file.save(path)
        if not is_finished:
            path.write_bytes(b"UnFinMF " + path.read_bytes()[8:])

    return write


def mat(**content: Any) -> Callable[[Path], None]:
    import scipy.io

    return lambda path: scipy.io.savemat(path, content)


def mat_7_3(path: Path) -> None:
    """Write by columns as MATLAB does, so that HDF5 sees the transpose."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"t": DAYS[None], "T": -DAYS[None], "g": np.stack([DAYS, STEPS])}.items():
            file[name] = values
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + struct.pack("<H2s", 0x0200, b"IM")
    path.write_bytes(head + path.read_bytes()[len(head) :])


def uff(header: Mapping[str, Any]) -> Callable[[Path], None]:
    """Return what writes a set before the series, as programs of modal analysis do."""

    def write(path: Path) -> None:
        import pyuff

        write_uff(path, dict.fromkeys(CHANNELS, STEPS) | {"time": TENTHS})
        series = path.read_bytes()
        own = pyuff.prepare_58(x=STEPS, data=np.ones(5) * 1j, **header) if "func_type" in header else header
        pyuff.UFF(str(path)).write_sets([own], mode="overwrite")
        path.write_bytes(path.read_bytes() + series)

    return write


def mseed(late: float) -> Callable[[Path], None]:
    """Return what writes two pieces of five samples, the second so late [s]."""

    def write(path: Path) -> None:
        import obspy

        header = {"network": "XX", "station": "A", "channel": "HHZ", "sampling_rate": 10.0}
        starts = [obspy.UTCDateTime(START) + at for at in (0.0, late)]
        obspy.Stream([obspy.Trace(STEPS, {**header, "starttime": at}) for at in starts]).write(str(path), "MSEED")

    return write


def protobuf(path: Path) -> None:
    from mcap.writer import Writer

    with path.open("wb") as stream:
        (file := Writer(stream)).start()
        channel = file.register_channel("/t", "protobuf", file.register_schema("x", "protobuf", b""))
        file.add_message(channel, 1, b"abc", 1), file.finish()


def ros_2(plugin: str) -> Callable[[Path], None]:
    """Return what writes a folder of ROS 2 and brings the file in it and its metadata to the path."""

    def write(path: Path) -> None:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.LATEST)
        kind = store.types["geometry_msgs/msg/Vector3"]
        with Writer(path.parent / path.stem, version=9, storage_plugin=StoragePlugin[plugin]) as file:
            topic = file.add_connection("/force", kind.__msgtype__, typestore=store)
            for k, x in enumerate(STEPS.tolist()):
                message = store.serialize_cdr(kind(x=x, y=0.0, z=float("nan")), kind.__msgtype__)
                file.write(topic, START * 10**9 + k * 10**8, message)
        for own in (path.parent / path.stem).iterdir():
            own.rename(path if own.suffix == path.suffix else path.with_name(own.name))

    return write


def text(content: str) -> Callable[[Path], Any]:
    return lambda path: path.write_text(content)


def indexed(name: str | None) -> pd.DataFrame:
    """Return numbers whose times are pandas' index."""
    stamps = pd.Timestamp("2026-11-29") + pd.to_timedelta(TENTHS, unit="s").round("ms")
    return pd.DataFrame({"force": STEPS, "g1": -STEPS}, index=pd.Index(stamps, name=name))


HEAD = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\t{}\n"
HEAD += "Date\t2026/11/29\nTime\t12:00:00\n***End_of_Header***\t\n\n"
SEGMENT = "Channels\t2\nSamples\t3\t3\nDate\t2026/11/29\t2026/11/29\nTime\t12:00:0{0}\t12:00:0{0}\n"
SEGMENT += "Y_Unit_Label\tum/m\tN\nX0\t0.5\t0.5\nDelta_X\t0.1\t0.2\n***End_of_Header***\t\n{1}\n"
ONE = "X_Value\tstrain\tforce\tComment\n0.5\t1\t10\tbegun\n0.6\t2\t20\n0.7\t3\t30\n"
MULTI = "X_Value\tstrain\tX_Value\tforce\tComment\n0.5\t1\t0.5\t10\n0.6\t2\t0.7\t20\n0.7\t3\t\t\n"
NONE = "X_Value\tstrain\tforce\tComment\n\t1\t10\n\t2\t20\n\t3\t30\n"
BARE = "strain\tforce\tComment\n1\t10\n2\t20\n3\t30\n"


def lvm(kind: str, *bodies: str, late: int = 2) -> str:
    """Return a measurement whose segments begin so late [s] behind one another."""
    return HEAD.format(kind) + "".join(SEGMENT.format(late * k, body) for k, body in enumerate(bodies))


RIGHT, FORCE = (TENTHS, STEPS), ("G:force", STEPS, {"unit_string": "N"})
HALF, TENS = np.array([0.5, 0.6, 0.7]), np.array([10.0, 20.0, 30.0])
SIGNALS = np.array([(STEPS, "force"), (2 * STEPS, "g1")], dtype=[("values", object), ("label", object)])
SI = {"type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1, "length": 1, "force": 1, "temp": 1}
RESPONSE = {"func_type": 4, "abscissa_spacing": 0, "ord_data_type": 5, "binary": 0, "abscissa_spec_data_type": 18}
RESPONSE |= dict.fromkeys(("ordinate_spec_data_type", "orddenom_spec_data_type", "z_axis_spec_data_type"), 0)
RESPONSE |= dict.fromkeys(("rsp_node", "rsp_dir", "ref_node", "ref_dir"), 1) | {"id1": "H"}
LVM = {"One": (ONE, HALF), "Multi": (MULTI, HALF[::2]), "No": (NONE, 2 * HALF - 0.5), "No ": (BARE, 2 * HALF - 0.5)}
CHANGES = {"": ("", ""), ", Windows": ("\n", "\r\n"), ", commas": (".", ",")}
TWICE = (np.append(HALF, HALF + 2.0), np.append(TENS, TENS))
FILES = {
    "times of TDMS in a unit": File(
        "a.tdms", tdms(("G:Time", 100.0 * STEPS, {"unit_string": "ms"}), FORCE), {"G/force": (*RIGHT, "N")}
    ),
    "times of TDMS with their unit behind": File(
        "a.tdms", tdms(("G:Time [ms]", 100.0 * STEPS, {}), FORCE), {"G/force": RIGHT}
    ),
    "a temperature t before the times": File(
        "a.tdms", tdms(("G:t [degC]", STEPS, {}), ("G:Time (ms)", 100.0 * STEPS, {}), FORCE), {"G/force": RIGHT}
    ),
    "stamps of TDMS": File(
        "a.tdms",
        tdms(("G:Time", STAMPS, {}), FORCE, ("Late:Time", STAMPS + 1, {}), ("Late:g1", STEPS, {})),
        {"G/force": RIGHT, "Late/g1": (TENTHS + 1e-3, STEPS)},
    ),
    "a scale that changes": File(
        "a.tdms", tdms(("G:g1", STEPS, scaled(1)), ("G:g1", STEPS, scaled(2)), apart=True), {"G/g1": RIGHT}, "",
        "channel 'g1' is scaled anew within the file",
    ),
    "a waveform without a start": File(
        "a.tdms",
        tdms(("G:g1", STEPS, {**EVEN, "wf_start_time": STAMPS[0]}), ("G:g2", STEPS, EVEN)),
        {"G/g2": RIGHT}, "Channels without a start are taken to begin with the first of the others: 'G/g2'.",
    ),
    "segments of one start": File(
        "a.tdms", tdms(*[("G:g1", STEPS, {**EVEN, "wf_start_offset": 0.5})] * 2, apart=True),
        {"G/g1": (0.5 + 0.1 * np.arange(10), np.tile(STEPS, 2))},
    ),
    "names of TDMS that join to one": File(
        "a.tdms",
        tdms(*((place, k + STEPS, EVEN) for k, place in enumerate(("A/B:C", "A:B/C", "A:D"))), apart=True),
        {"'A/B'/'C'": RIGHT, "'A'/'B/C'": (TENTHS, 1 + STEPS), "A/D": (TENTHS, 2 + STEPS)},
    ),
    "MDF that was not finished": File("a.mf4", mdf(is_finished=False), {"force": RIGHT}),
    "MDF 3": File("a.mdf", mdf("3.30"), {"force": RIGHT}),
    "a channel over an angle": File(
        "a.mf4", mdf(master_metadata=("Angle", 2)), {"force": RIGHT}, "", "'force' is recorded over 'Angle', no time"
    ),
    "pieces within half a sample": File(
        "a.mseed", mseed(0.54), {"XX.A..HHZ": (np.arange(10) / 10, np.tile(STEPS, 2))}, "joins pieces that begin",
    ),
    "pieces that overlap": File(
        "a.mseed", mseed(0.2), {"XX.A..HHZ": RIGHT}, "", "time goes back from 0.4 s to 0.2 s behind sample 5"
    ),
    "messages of protobuf": File("a.mcap", protobuf, {}, "", "holds messages in protobuf; expected JSON or ROS 2"),
    "a database alone": File(
        "a.db3", text("SQLite format 3\0"), {}, "", "a.db3 has no metadata.yaml beside it; expected the folder"
    ),
    "ROS 2 in MCAP": File("a.mcap", ros_2("MCAP"), {"/force/x": RIGHT, "/force/z": (TENTHS, STEPS * np.nan)}),
    "ROS 2 in a database": File("a.db3", ros_2("SQLITE3"), {"/force/x": RIGHT, "/force/z": (TENTHS, STEPS * np.nan)}),
    "units before the series": File("a.uff", uff(SI | {"temp_offset": 273.15}), {"force": RIGHT}),
    "a response before the series": File(
        "a.uff", uff(RESPONSE), {"force": RIGHT}, "Left out: 1 function that is no time response."
    ),
    "a Simulink structure with time": File(
        "a.mat", mat(out={"time": TENTHS, "signals": SIGNALS}), {"out/signals/values/1": RIGHT}
    ),
    "a row for each channel": File("a.mat", mat(t=TENTHS, M=np.stack([STEPS, -STEPS])), {"M/1": RIGHT}),
    "a row for each channel at a rate": File("a.mat", mat(fs=10, M=np.stack([STEPS, -STEPS])), {"M/1": RIGHT}),
    "times that are texts beside a rate": File("a.mat", mat(time=["0 s"] * 5, Fs=10.0, f=STEPS), {"f": RIGHT}),
    "MAT 7.3, a temperature T": File("a.mat", mat_7_3, {"g/2": (DAYS, STEPS), "T": (DAYS, -DAYS)}, "may count days"),
    "a temperature t in a table": File(
        "a.csv", text("t [°C],Time [ms],force\n" + "".join(f"20,{100 * k},{k}\n" for k in range(5))), {"force": RIGHT}
    ),
    **{
        f"an index of pandas called {name} in {ending}": File(
            f"a.{ending}", lambda path, name=name, write=write: write(indexed(name), path), {"force": RIGHT}
        )
        for ending, write in (("csv", pd.DataFrame.to_csv), ("parquet", pd.DataFrame.to_parquet))
        for name in ("time", None)
    },
    "segments of .lvm": File("a.lvm", text(lvm("One", ONE, ONE)), {"force": TWICE}, "2 segments follow one another."),
    "segments of .lvm that overlap": File(
        "a.lvm", text(lvm("One", ONE, ONE, late=0)), {"force": TWICE}, "",
        "time goes back from 0.7 s to 0.5 s behind sample 3",
    ),
    "a name of .lvm that comes twice": File(
        "a.lvm", text(lvm("One", ONE.replace("force", "strain"))),
        {"strain#1": (HALF, TENS / 10), "strain#2": (HALF, TENS)},
    ),
    "an .lvm without times": File(
        "a.lvm", text(lvm("No", NONE).replace("Delta_X", "Delta")), {}, "",
        "channel 'strain' has no times; expected X_Columns One or Delta_X",
    ),
    **{
        f".lvm with times {kind}{how}": File(
            "a.lvm",
            text(lvm(kind.strip(), body).replace(*change) if how else lvm(kind.strip(), body)),
            {"strain": (HALF, TENS / 10, "um/m"), "force": (times, TENS[: len(times)], "N")},
        )
        for kind, (body, times) in LVM.items()
        for how, change in CHANGES.items()
    },
}  # fmt: skip
"""By the way in which a program wrote it."""
