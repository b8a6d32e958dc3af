"""Recordings of loggers at the door of the diagnosis: eleven formats of one truth, and files that others wrote."""

import contextlib
import json
import struct
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.recordings import BEAM, CARD, CHANNELS, FORMATS, GAUGES, START, UNITS, write_tdms
from octmip.errors import DataError, MissingExtraError
from octmip.gap import function_twin
from octmip.gap.doors import open_twin
from octmip.interfaces.cli import main
from octmip.recordings import Window, averages_of, campaign_of, recording
from tests.doors.recorded import RATE, STEPS, WAYS, as_csv, truth

pytestmark = pytest.mark.filterwarnings("ignore:SelectableGroups dict interface")  # of obspy
LOAD_UNITS = {"force": "N", "moment": "N m"}
SHORT = ["--twin", "python:beam_of_three_gauges:beam", "--card", "card.json"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("recordings")
    (place / "beam_of_three_gauges.py").write_text(BEAM)
    (place / "card.json").write_text(json.dumps(CARD))
    for run, gain in (("run", 1.25), ("sound", 1.0)):
        (place / f"{run}.csv").write_text(as_csv(truth(gain)))
        write_tdms(place / f"{run}.tdms", truth(gain))
    for name, write, _ in FORMATS.values():
        write(place / name, truth())
    return place


@pytest.fixture
def at(folder, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))
    return folder


@pytest.fixture
def twin(at):
    return open_twin("python:beam_of_three_gauges:beam", "card.json")


def chosen(places):
    loads, readings = ({name: places[name] for name in names} for names in (CHANNELS[:2], GAUGES))
    return readings, loads


@pytest.fixture(scope="module")
def first():
    return {}


@pytest.mark.long("DataFlash", "rosbag")
@pytest.mark.parametrize("form", FORMATS)
def test_each_format_holds_the_truth_and_makes_the_same_campaign(form, at, twin, first):
    name, _, places = FORMATS[form]
    opened, series = recording(name), truth()
    for channel, place in places.items():
        found, known = opened[place], np.isfinite(series[channel])
        factor = 100.0 if found.unit == "cN" else 1.0
        assert found.time[found.is_valid] == pytest.approx(series["time"][known], abs=1e-9)
        assert found.values[found.is_valid] == pytest.approx(series[channel][known] * factor, abs=1e-6)
    campaign = campaign_of(averages_of(opened, twin, *chosen(places), load_units=LOAD_UNITS), twin)
    one = first.setdefault("campaign", campaign)
    assert len(campaign.cells) == 7  # six plateaus, one cut by the gap
    for array in ("readings", "load_factor", "time"):
        assert getattr(campaign, array) == pytest.approx(getattr(one, array), abs=1e-6, nan_ok=True)
    assert any("the longest of 0.61 s at 8.99 s; nothing is filled" in note for note in campaign.notes)


def told(capsys, path, *words):
    assert main(["diagnose", path, *SHORT, *words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.long("DataFlash", "lvm", "MCAP", "rosbag", "MAT", "TOA5", "UFF58", "miniSEED", "ULog", "MDF")
@pytest.mark.parametrize("form", FORMATS)
def test_one_command_tells_of_each_format_what_the_table_of_the_same_truth_tells(form, at, first, capsys):
    name, _, places = FORMATS[form]
    sound = "sound.tdms" if form == "TDMS" else "sound.csv"
    loads, readings = ([f"{key}={places[key]}" for key in names] for names in (CHANNELS[:2], GAUGES))
    words = ["--steady", "--loads", *loads, "--readings", *readings, "--load-units", "force=N", "moment=N m"]
    found = told(capsys, name, "--commissioning", sound, *words, "--show-windows", "w.png")
    table = first.setdefault("table", None) or told(capsys, "run.csv", "--commissioning", "sound.csv")
    first["table"] = table
    assert [one["effect"] for one in (*table["parameters"], *found["parameters"])] == ["gain_g2"] * 2
    assert found["parameters"][0]["size"] == pytest.approx(table["parameters"][0]["size"], abs=0.005)
    assert found["parameters"][0]["size"] == pytest.approx(0.25, abs=0.01)
    assert Path("w.png").read_bytes().startswith(b"\x89PNG")
    assert [found[key] for key in ("kind", "certainty")] == [table[key] for key in ("kind", "certainty")]
    assert any(note.startswith(f"{name} is a recording") for note in found["notes"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("run.tdms", "run.tdms is a recording (TDMS); expected --steady, or --windows START,END"),
        ("run.tdms --steady --readings g1=Beam/g9", "run.tdms has no channel 'Beam/g9'; expected one of its 5"),
        ("run.tdms --steady --readings g1=Beam/g1 g1=Beam/g2", "--readings names g1 twice; expected NAME=VALUE"),
        ("run.mseed --steady", "run.mseed: no channel is the load 'force'; expected --loads force=CHANNEL"),
        ("run.tdms --steady --readings g1=Beam/g2", "channel 'Beam/g2' is g1 and g2; expected a channel for each"),
        ("volts.tdms --steady", "column g1 is in 'V'; expected microstrain"),
        ("run.tdms --steady --least 9", "no window of at least 9 s in which Beam/force stays within 1.6 N"),
        ("run.tdms --windows 50,60", "no valid sample from 50 s to 60 s; its samples go from 0 s to 40.99 s"),
        ("run.tdms --windows 1,4 3,5", "windows 1,4 and 3,5 overlap; expected each sample in one window"),
        ("run.csv --least 3", "--least is for a recording, and run.csv is a table"),
        ("far.tdms --steady", "channel Beam/g2 holds -9999 40 times from"),
        ("huge.tdms --steady", "channel Beam/g2 holds 1.79769313e+308 1 time from"),
        ("run.tdms --windows 1,4 --commissioning run.tdms", "--windows are those of run.tdms"),
    ],
)
def test_what_is_wrong_is_one_sentence(words, said, at, capsys, monkeypatch):
    series = truth()
    if "far" in words:
        series["g2"][300:340] = -9999.0
    if "huge" in words:
        series["g2"][300] = np.finfo(float).max
    if "volts" in words:
        monkeypatch.setattr("benchmarks.recordings.UNITS", {**UNITS, "g1": "V"})
    if words.startswith(("far", "huge", "volts")):
        write_tdms(Path(words.split()[0]), series)
    assert main(["diagnose", *words.split(), *SHORT]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_number_of_the_logger_for_no_reading_is_missing(at, twin):
    series = truth()
    series["g2"][300:340] = -9999.0
    write_tdms(at / "far.tdms", series)
    found = averages_of(recording("far.tdms"), twin, no_reading=[-9999.0])
    assert any("g2: 70 of 4040 samples are invalid and left out" in note for note in found.table.notes)


@pytest.mark.parametrize("form", ["parquet", "csv"])
@pytest.mark.parametrize("name", ["time", None])
def test_times_in_the_index_of_pandas_are_times(form, name, at, twin):
    series = truth()
    plain = pd.DataFrame(series)
    plain.to_csv("plain.csv", index=False)
    instants = pd.Timestamp("2026-11-29") + pd.to_timedelta(plain["time"], unit="s").dt.round("ms")
    frame = plain.drop(columns="time").set_index(pd.Index(instants, name=name))
    frame.to_csv("run.csv") if form == "csv" else frame.to_parquet("run.parquet")
    tables = (averages_of(recording(file), twin).table.frame for file in (f"run.{form}", "plain.csv"))
    found, right = (table.drop(columns="test") for table in tables)
    pd.testing.assert_frame_equal(found, right, rtol=1e-9)


@pytest.mark.parametrize("way", WAYS)
def test_times_and_numbers_are_found_as_programs_write_them(way, tmp_path):
    name, write, channel = WAYS[way]
    write(tmp_path / name)
    found = recording(tmp_path / name)[channel]
    assert found.time == pytest.approx(0.1 * STEPS)
    assert found.values == pytest.approx(STEPS)


def test_a_file_may_have_the_name_of_a_statistic(at, twin):
    Path("run.tdms").rename("max.tdms")
    found = campaign_of(averages_of(recording("max.tdms"), twin, load_units=LOAD_UNITS), twin)
    Path("max.tdms").rename("run.tdms")
    assert set(found.test) == {"max.tdms"}


def test_channels_of_two_rates_are_averaged_each_at_its_own(at, twin):
    from nptdms import ChannelObject, TdmsWriter

    series = {name: np.delete(values, slice(840, None)) for name, values in truth().items()}
    with TdmsWriter("rates.tdms") as file:
        for name in CHANNELS:
            every = 10 if name in ("force", "moment", "g3") else 1
            waveform = {"wf_increment": every / RATE, "wf_start_offset": 0.0}
            file.write_segment([ChannelObject("Beam", name, series[name][::every], waveform)])
    found = averages_of(recording("rates.tdms"), twin)
    assert "Channels have 2 rates (10 Hz, 100 Hz): each is averaged at its own." in found.table.notes
    assert [part["g1"].n // 10 - part["g3"].n for part in found.statistics] == pytest.approx([0, 0], abs=1)
    assert found.statistics[0]["g3"].mean == pytest.approx(0.0, abs=0.5)


def test_a_channel_numbers_the_tests_and_numbers_stand_for_loads(at, twin):
    import scipy.io

    series = truth()
    scipy.io.savemat("tests.mat", {**series, "number": np.where(series["time"] < 20.5, 1.0, 2.0)})
    found = campaign_of(averages_of(recording("tests.mat"), twin, test="number", load_units=LOAD_UNITS), twin)
    assert set(found.test) == {"number 1", "number 2"}
    fixed = averages_of(recording("tests.mat"), twin, loads={"moment": 0.0}, test="number")
    assert set(fixed.table.frame["moment"]) == {0.0}


# What the libraries do, and the readers do not.


def test_samples_of_tdms_keep_the_start_of_their_segment_and_other_scales_are_refused(at):
    from nptdms import ChannelObject, TdmsFile, TdmsWriter

    library = TdmsFile.read("run.tdms")["Beam"]["g1"]
    assert library.time_track(absolute_time=False)[-1] == pytest.approx(40.39)  # the gap is lost
    assert recording("run.tdms")["Beam/g1"].time[-1] == pytest.approx(40.99)
    assert recording("run.tdms").start == START * 10**9
    stamps = np.datetime64(START, "s") + np.arange(5) * np.timedelta64(10, "ms")
    with TdmsWriter("stamps.tdms") as file:
        file.write_segment([ChannelObject("Beam", "Time", stamps), ChannelObject("Beam", "g1", np.arange(5.0))])
        file.write_segment([ChannelObject("Late", "Time", stamps + 1), ChannelObject("Late", "g1", np.arange(5.0))])
    opened = recording("stamps.tdms")
    assert opened["Beam/g1"].time == pytest.approx(0.01 * np.arange(5))
    assert opened["Late/g1"].time == pytest.approx(0.001 + 0.01 * np.arange(5))
    with TdmsWriter("scaled.tdms") as file:
        for slope in (1.0, 2.0):
            scale = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Linear", "NI_Scale[0]_Linear_Slope": slope}
            scale |= {"NI_Scale[0]_Linear_Y_Intercept": 0.0, "NI_Scale[0]_Linear_Input_Source": 0, "wf_increment": 0.1}
            file.write_segment([ChannelObject("Beam", "g1", np.ones(5), scale | {"wf_start_offset": 0.0})])
    with pytest.raises(DataError, match="channel 'g1' is scaled anew within the file"):
        recording("scaled.tdms")["Beam/g1"]
    with TdmsWriter("bare.tdms") as file:
        for name, start in (("g1", {"wf_start_time": stamps[0]}), ("g2", {})):
            file.write_segment([ChannelObject("Beam", name, np.arange(5.0), {"wf_increment": 0.1} | start)])
    assert recording("bare.tdms").notes == (
        "Channels without a start are taken to begin with the first of the others: 'Beam/g2'.",
    )


def test_a_topic_of_ulog_that_was_split_is_one_series(at):
    from pyulog import ULog

    assert len(ULog("run.ulg").get_dataset("gauges").data["timestamp"]) == 2020
    opened = recording("run.ulg")
    assert len(opened["gauges/g[0]"].time) == 4040
    assert "Topic gauges was subscribed to 2 times" in opened.notes[0]


def test_invalid_samples_of_mdf_keep_their_place_though_asammdf_drops_them(at):
    from asammdf import MDF

    with MDF("run.mf4") as file:
        assert len(file.get("g2").samples) == 4010
    found = recording("run.mf4")["g2"]
    assert (len(found.time), found.is_valid.sum()) == (4040, 4010)


def test_pieces_of_miniseed_do_not_overlap_and_half_a_sample_is_told(at):
    import obspy

    def trace(start):
        header = {"network": "XX", "station": "A", "channel": "HHZ", "sampling_rate": 10.0}
        return obspy.Trace(np.arange(20.0), {**header, "starttime": obspy.UTCDateTime(START) + start})

    obspy.Stream([trace(0.0), trace(2.04)]).write("apart.mseed", format="MSEED")
    opened = recording("apart.mseed")
    assert opened["XX.A..HHZ"].time[20] == pytest.approx(2.0)
    assert any("joins pieces that begin within half a sample" in note for note in opened.notes)
    obspy.Stream([trace(0.0), trace(1.0)]).write("over.mseed", format="MSEED")
    with pytest.raises(DataError, match=r"time goes back from 1\.9 s to 1 s behind sample 20"):
        recording("over.mseed")["XX.A..HHZ"]


def test_what_is_no_series_of_time_is_refused_or_left_out(at):
    import asammdf
    import pyuff
    from mcap.writer import Writer

    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(np.arange(5.0), np.arange(5.0), name="p", master_metadata=("Angle", 2))])
        file.save("angle.mf4")
    with pytest.raises(DataError, match="'p' is recorded over 'Angle', no time"):
        recording("angle.mf4")["p"]
    with Path("packed.mcap").open("wb") as stream:
        (file := Writer(stream)).start()
        channel = file.register_channel("/t", "protobuf", file.register_schema("x", "protobuf", b""))
        file.add_message(channel, 1, b"abc", 1), file.finish()
    (at / "alone").mkdir()
    Path("alone/a.db3").write_bytes(b"SQLite format 3\0")
    with pytest.raises(DataError, match=r"a\.db3 has no metadata\.yaml beside it; expected the folder"):
        recording("alone/a.db3")
    with pytest.raises(DataError, match="holds messages in protobuf; expected JSON or ROS 2"):
        recording("packed.mcap")
    places = dict.fromkeys(("rsp_node", "rsp_dir", "ref_node", "ref_dir"), 1)
    kinds = {"func_type": 4, "abscissa_spacing": 0, "ord_data_type": 5, "binary": 0, "abscissa_spec_data_type": 18}
    kinds |= dict.fromkeys(("ordinate_spec_data_type", "orddenom_spec_data_type", "z_axis_spec_data_type"), 0)
    response = pyuff.prepare_58(x=np.arange(5.0), data=np.ones(5) * 1j, id1="H", **places, **kinds)
    Path("both.uff").write_bytes(Path("run.uff").read_bytes())
    pyuff.UFF("both.uff").write_sets([response], mode="add")
    assert recording("both.uff").notes == ("Left out: 1 function that is no time response.",)


def test_messages_of_ros_2_in_mcap_and_in_a_database(at):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.LATEST)
    kind = store.types["geometry_msgs/msg/Vector3"]
    for folder, plugin in (("mcap", StoragePlugin.MCAP), ("sqlite", StoragePlugin.SQLITE3)):
        with Writer(folder, version=9, storage_plugin=plugin) as file:
            topic = file.add_connection("/force", kind.__msgtype__, typestore=store)
            for k in range(20):
                message = kind(x=float(k), y=0.0, z=float("nan"))
                file.write(topic, START * 10**9 + k * 10**7, store.serialize_cdr(message, kind.__msgtype__))
        (bag,) = (path for path in Path(folder).iterdir() if path.suffix != ".yaml")
        opened = recording(bag)
        assert opened.channels == ("/force/x", "/force/y", "/force/z")
        assert opened["/force/x"].values == pytest.approx(np.arange(20.0))
        assert opened["/force/x"].time == pytest.approx(0.01 * np.arange(20))
        assert not opened["/force/z"].is_valid.any()


def test_matrices_of_mat_7_3_have_a_column_for_each_channel(at):
    h5py = pytest.importorskip("h5py")
    time = 739_000.0 + np.arange(50) / 10.0
    with h5py.File("new.mat", "w", userblock_size=512) as file:
        for name, values in {"t": time[None], "T": -time[None], "g": np.stack([time, 2 * time, 3 * time])}.items():
            file[name] = values  # MATLAB writes by columns, so HDF5 sees the transpose
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + struct.pack("<H2s", 0x0200, b"IM")
    content = Path("new.mat").read_bytes()
    Path("new.mat").write_bytes(head + content[len(head) :])
    opened = recording("new.mat")
    assert sorted(opened.channels) == ["T", "g/1", "g/2", "g/3"]  # a temperature, no time
    assert "may count days" in opened.notes[0]
    assert opened["g/2"].values == pytest.approx(2 * time)


@pytest.mark.long("MDF", "MCAP", "MAT")
@pytest.mark.parametrize("form", FORMATS)
def test_a_file_that_was_cut_is_read_as_far_as_it_goes_or_refused_in_one_sentence(form, at):
    name, _, places = FORMATS[form]
    content = Path(name).read_bytes()
    for share in (0.0002, 0.6):
        cut = Path(f"cut_{name}")
        cut.write_bytes(content[: max(1000, int(share * len(content)))])
        with contextlib.suppress(DataError):  # nothing else is raised
            assert len(recording(cut)[places["g3"]].time) < 4040


def test_a_missing_library_is_named_with_the_cure(at, monkeypatch):
    monkeypatch.delitem(sys.modules, "octmip.recordings.readers.tdms", raising=False)
    monkeypatch.setitem(sys.modules, "nptdms", None)
    with pytest.raises(MissingExtraError, match=r"needs the package nptdms, .* install octmip\[recordings\]"):
        recording("run.tdms")


# Files that others wrote: test data of the libraries themselves.


def of_package(package, *parts):
    spec = find_spec(package)
    path = Path(next(iter(spec.submodule_search_locations)), *parts)
    if not path.is_file():
        pytest.skip(f"{package} was installed without its test data {path.name}")
    return path


def rows_of(opened, channel, unit, windows):
    """Return the rows of a sensor's windows, and the notes."""
    twin = function_twin(
        lambda parameters, loads: [parameters["level"]], {"sensor": unit}, {"level": (0, -1e9, 1e9, unit)}
    )
    found = averages_of(opened, twin, {"sensor": channel}, {"load_factor": 1.0}, windows=windows)
    assert campaign_of(found, twin).readings.shape == (len(found.table.frame), 1)
    return found.table.frame, found.table.notes


def test_a_seismometer_with_gaps_makes_the_rows_of_its_samples():
    path, name = of_package("obspy", "io", "mseed", "tests", "data", "gaps.mseed"), "BW.BGLD..EHE"
    import obspy

    whole = np.concatenate([piece.data for piece in obspy.read(str(path))])
    frame, notes = rows_of(recording(path), name, "-", [Window(0.0, 1000.0)])
    assert len(recording(path)[name].time) == len(whole) == 52_728
    assert frame["sensor"].mean() == pytest.approx(whole.mean(), rel=1e-3)
    assert any("3 gaps, the longest of 4.12 s" in note for note in notes)


def test_a_digital_input_of_labview_makes_the_rows_of_its_samples():
    from nptdms import TdmsFile

    path = of_package("nptdms", "test", "data", "Digital_Input.tdms")
    own = next(iter(TdmsFile.read(path).groups())).channels()[0][:]
    opened = recording(path)
    frame, _ = rows_of(opened, opened.channels[0], "V", [Window(0.0, 2.5), Window(5.0, 10.0)])
    assert len(own) == 20_000
    assert frame["sensor"].to_numpy() == pytest.approx(np.concatenate([own[:5000], own[10_000:]]).mean(), abs=0.01)
