"""Recordings of loggers at the door of the diagnosis: eleven formats of one truth, and files that others wrote."""

import contextlib
import json
import re
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from benchmarks.recordings import BEAM, CARD, CHANNELS, FORMATS, GAUGES, START, UNITS, write_tdms
from octmip.errors import DataError, MissingExtraError
from octmip.gap import function_twin
from octmip.gap.doors import open_twin
from octmip.interfaces.cli import main
from octmip.recordings import Window, averages_of, campaign_of, recording
from tests.doors.recorded import FILES, RATE, as_csv, tdms, truth

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
    assert opened.start == (START * 10**9 if form in ("TDMS", "MDF", "MCAP", "rosbag", "miniSEED") else None)
    for channel, place in places.items():
        found, known = opened[place], np.isfinite(series[channel])
        leaves_out = form in ("UFF58", "miniSEED")  # whose files have no bad samples
        assert len(found.time) == (np.count_nonzero(known) if leaves_out else 4040)
        factor = 100.0 if found.unit == "cN" else 1.0
        assert found.time[found.is_valid] == pytest.approx(series["time"][known], abs=1e-9)
        assert found.values[found.is_valid] == pytest.approx(series[channel][known] * factor, abs=1e-6)
    campaign = campaign_of(averages_of(opened, twin, *chosen(places), load_units=LOAD_UNITS), twin)
    one = first.setdefault("campaign", campaign)
    assert len(campaign.cells) == 7  # six plateaus, one cut by the gap
    for array in ("readings", "load_factor", "time"):
        assert getattr(campaign, array) == pytest.approx(getattr(one, array), abs=1e-6, nan_ok=True)
    assert any("the longest of 0.61 s at 8.99 s; nothing is filled" in note for note in campaign.notes)


REFUSED = {
    "a wrong channel": ({"readings": {"g1": "nowhere"}}, "has no channel 'nowhere'; expected one of its"),
    "no steady window": ({"least": 9.0}, "no window of at least 9 s in which .* stays within 1"),
    "another unit": ({"load_units": {"force": "m"}}, "is in 'c?N'; expected m"),
}


@pytest.mark.parametrize("what", REFUSED)
@pytest.mark.parametrize("form", FORMATS)
def test_what_is_wrong_with_a_format_is_one_sentence(form, what, at, twin):
    name, _, places = FORMATS[form]
    opened, (readings, loads), (asked, said) = recording(name), chosen(places), REFUSED[what]
    given = {"load_units": LOAD_UNITS, **asked, "readings": readings | asked.get("readings", {}), "loads": loads}
    if what == "another unit" and not opened[places["force"]].unit:
        assert any(
            "has no unit in its file and is taken as m" in one for one in averages_of(opened, twin, **given).table.notes
        )
        return
    with pytest.raises(DataError, match=said):
        averages_of(opened, twin, **given)


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
        ("run.tdms --steady --readings g1=Beam/g1 g1=Beam/g2", "--readings names g1 twice; expected NAME=VALUE"),
        ("run.mseed --steady", "run.mseed: no channel is the load 'force'; expected --loads force=CHANNEL"),
        ("run.tdms --steady --readings g1=Beam/g2", "channel 'Beam/g2' is g1 and g2; expected a channel for each"),
        ("volts.tdms --steady", "column g1 is in 'V'; expected microstrain"),
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


@pytest.mark.parametrize("way", FILES)
def test_times_numbers_and_units_are_those_that_a_program_wrote(way, tmp_path):
    name, write, channels, said, error = FILES[way]
    write(tmp_path / name)
    if error:
        with pytest.raises(DataError, match=re.escape(error)):
            recording(tmp_path / name)[next(iter(channels), "")]
        return
    opened = recording(tmp_path / name)
    for channel, (time, values, *unit) in channels.items():
        assert opened[channel].time == pytest.approx(time, rel=1e-12, abs=2e-9)
        assert opened[channel].values == pytest.approx(values, rel=1e-12, nan_ok=True)
        assert [opened[channel].unit] == (unit or [opened[channel].unit])
    assert said in " ".join(opened.notes)


def test_a_file_may_have_the_name_of_a_statistic(at, twin):
    Path("run.tdms").rename("max.tdms")
    found = campaign_of(averages_of(recording("max.tdms"), twin, load_units=LOAD_UNITS), twin)
    Path("max.tdms").rename("run.tdms")
    assert set(found.test) == {"max.tdms"}


def test_channels_of_two_rates_are_averaged_each_at_its_own(at, twin):
    every = {name: 10 if name in ("force", "moment", "g3") else 1 for name in CHANNELS}
    series = {name: truth()[name][: 840 : every[name]] for name in CHANNELS}
    tdms(*((f"Beam:{name}", series[name], {"wf_increment": every[name] / RATE}) for name in CHANNELS))(
        Path("rates.tdms")
    )
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
