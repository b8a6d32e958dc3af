"""The friction damper: a made folder with a known backlash and known wrong readings, and the measured one.

The made rig is a formula of its own: play and two linear springs in steps of time, not the path that is fitted.
"""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from benchmarks.data import SHARED
from benchmarks.real.damper.__main__ import main
from benchmarks.real.damper.accused import accused
from benchmarks.real.damper.answers import WORTH, answers, diagnose_tests
from benchmarks.real.damper.cycles import samples_of
from benchmarks.real.damper.faults import FAULTS, corrupted
from benchmarks.real.damper.features import shown
from benchmarks.real.damper.lacking import lacking
from benchmarks.real.damper.series import read_folder, read_test
from benchmarks.real.damper.slack import slack_force, slacks
from octmip.errors import DataError

DATA = SHARED / "damper"
needs_damper = pytest.mark.skipif(not DATA.is_dir(), reason=f"{DATA} is not there: the friction damper's data")
BACKLASH, STIFFNESS, LEVER, STRETCH = 0.12, 25.0, 2.0, 0.02
CONDITIONS = [(0.25, 0.5), (0.5, 0.5), (0.5, 1.0), (1.0, 0.5), (1.0, 1.0), (1.0, 1.5), (2.0, 0.5), (0.25, 1.5)]


def made_test(frequency, amplitude, friction, seed, rate=128.0, cycles=6):
    """Return the table of a drum driven through play BACKLASH and a spring STIFFNESS, with friction [kip]."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, cycles / frequency, 1.0 / rate)
    x = amplitude * np.sin(2.0 * np.pi * frequency * time) * np.minimum(1.0, time * frequency)
    drum, force = 0.0, np.zeros(len(time))
    for k in range(len(time)):
        gap = x[k] - drum
        wound = np.sign(gap) * max(abs(gap) - BACKLASH / 2.0, 0.0)
        force[k] = np.clip(STIFFNESS * wound, -friction, friction)
        if abs(STIFFNESS * wound) > friction:
            drum = x[k] - np.sign(gap) * (BACKLASH / 2.0 + friction / STIFFNESS)
    tight = 1000.0 * np.abs(force) / LEVER * (1.0 + STRETCH)
    ends = [np.where(side * force > 0.0, tight, 0.0) + 0.02 * tight + 8.0 for side in (-1.0, 1.0)]
    return pd.DataFrame({
        "time_s": time,
        "displacement_in": x + rng.normal(0.0, 2e-4, len(time)),
        "force_kip": force + rng.normal(0.0, 0.03 * friction, len(time)),
        "velocity_in_s": np.gradient(x, time),
        "tension_a_lb": ends[0] + rng.normal(0.0, 0.5, len(time)),
        "tension_b_lb": ends[1] + rng.normal(0.0, 0.5, len(time)),
    })  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder of eight tests, of which m3 reads one end a third too low."""
    path = tmp_path_factory.mktemp("made")
    rows = []
    for k, (frequency, amplitude) in enumerate(CONDITIONS):
        table = made_test(frequency, amplitude, 1.6 + 0.2 * k, k)
        if k == 3:
            table["tension_b_lb"] *= 0.67
        table.to_csv(path / f"m{k}.csv", index=False)
        rows.append((f"m{k}", "made", frequency, amplitude, 30.0))
    names = ["test", "series", "frequency_hz", "amplitude_in", "nominal_tension_lb"]
    pd.DataFrame(rows, columns=names).to_csv(path / "tests.csv", index=False)
    return path


@pytest.fixture(scope="module")
def made(folder):
    return read_folder(folder)


@pytest.fixture(scope="module")
def written(folder, tmp_path_factory):
    """Return what the command writes."""
    path = tmp_path_factory.mktemp("written")
    out, drawn = path / "answers.json", path / "picture.png"
    main(["--data", str(folder), "--out", str(out), "--picture", str(drawn)])
    assert drawn.stat().st_size > 10000
    return json.loads(out.read_text())


def test_the_wrong_reading_is_found_and_no_other_accused(written):
    wrong = {row["test"]: row["tension_reading_wrong"] for row in written["tests"]}
    assert [name for name, is_wrong in wrong.items() if is_wrong] == ["m3"]
    assert all(0.0 <= row["probability"] <= 1.0 for row in written["tests"])


def test_the_backlash_comes_back_with_its_size(written):
    """Within 0.5 kip on either side the play and twice 0.5 / STIFFNESS are crossed."""
    first = written["effects"][0]
    assert (first["name"], first["unit"]) == ("backlash", "in")
    assert first["probability"] > 0.95
    assert first["size"] == pytest.approx(BACKLASH + 2.0 * 0.5 / STIFFNESS, abs=0.01)
    assert written["effects"][1]["name"] == "rebuild_stiffness"
    assert written["effects"][1]["size"] == pytest.approx(STIFFNESS, rel=0.1)


def test_held_out_amplitudes_and_frequencies_close(written):
    assert written["closed"] > 0.9


def test_a_drum_without_slack_lacks_no_backlash(made):
    """Where the force is the twin's own, with a lag of nothing, no slack is named."""
    stiff = [replace(one, force=2.0 * np.sign(one.velocity), tension=two_ends(one)) for one in made[2:6]]
    found = lacking(samples_of(stiff, shown(stiff), [False] * len(stiff)), stiff)
    assert not [size for size in found.sizes if size.worth >= WORTH]


def two_ends(test):
    rng = np.random.default_rng(1)
    sides = np.array([np.where(side * test.velocity > 0.0, 1000.0, 8.0) for side in (-1.0, 1.0)])
    return sides + rng.normal(0.0, 0.5, sides.shape)


@pytest.mark.parametrize("fault", sorted(FAULTS))
def test_faults_of_every_kind_are_found_in_one_test(made, fault):
    sound = [test for test in made if test.name != "m3"]
    wrong = accused(corrupted(sound, [2], FAULTS[fault], np.random.default_rng(3))) > 0.5
    assert wrong.tolist() == [k == 2 for k in range(len(sound))]


def test_a_folder_in_other_units_at_another_rate_without_velocity_gives_the_same(folder, tmp_path, written):
    for path in folder.glob("m*.csv"):
        table = pd.read_csv(path)
        fine = np.arange(0.0, table["time_s"].iloc[-1], 1.0 / 512.0)
        even = {name: np.interp(fine, table["time_s"], table[name]) for name in table}
        pd.DataFrame({
            "tension_a_n": 4.4482216 * even["tension_a_lb"], "tension_b_n": 4.4482216 * even["tension_b_lb"],
            "time": fine, "displacement_mm": 25.4 * even["displacement_in"], "force_kn": 4.4482216 * even["force_kip"],
        }).to_csv(tmp_path / path.name, index=False)  # fmt: skip
    pd.DataFrame({"test": [f"m{k}" for k in range(len(CONDITIONS))]}).to_csv(tmp_path / "tests.csv", index=False)
    found = read_folder(tmp_path)
    assert (accused(found) > 0.5).tolist() == [row["tension_reading_wrong"] for row in written["tests"]]
    assert np.mean(slacks(found, slack_force(found))) == pytest.approx(written["effects"][0]["size"], rel=0.03)


def test_a_silent_cell_is_wrong_in_the_test_that_lacks_it_and_no_fault_where_none_has_it(made):
    sound = [test for test in made if test.name != "m3"]
    silent = replace(sound[1], tension=np.full_like(sound[1].tension, np.nan))
    assert (accused([sound[0], silent, *sound[2:]]) > 0.5).tolist() == [k == 1 for k in range(len(sound))]
    one_end = [replace(test, tension=np.array([test.tension[0], np.nan * test.tension[1]])) for test in sound]
    assert not (accused(one_end) > 0.5).any()


def test_ends_that_a_whole_series_names_the_other_way_round_are_no_fault(made):
    sound = [replace(test, tension=test.tension[::-1].copy()) for test in made if test.name != "m3"]
    assert not (accused(sound) > 0.5).any()


def test_a_force_of_the_other_sign_is_turned_and_named_and_a_test_without_motion_changes_nothing(folder, tmp_path):
    for path in folder.glob("*.csv"):
        (tmp_path / path.name).write_text(path.read_text())
    table = pd.read_csv(tmp_path / "m1.csv")
    table["force_kip"] *= -1.0
    table.to_csv(tmp_path / "m1.csv", index=False)
    found = read_folder(tmp_path)
    assert [test.name for test in found if test.is_turned] == ["m1"]
    assert (accused(found) > 0.5).tolist() == [test.name == "m3" for test in found]
    still = replace(found[0], displacement=0.0 * found[0].displacement, force=0.0 * found[0].force)
    assert slacks([*found[1:], still], slack_force([*found[1:], still])) == slacks(found[1:], slack_force(found[1:]))


def test_a_folder_without_its_table_or_a_file_says_so(folder, tmp_path):
    with pytest.raises(DataError, match=r"tests\.csv is not there"):
        read_folder(tmp_path)
    (tmp_path / "tests.csv").write_text((folder / "tests.csv").read_text())
    with pytest.raises(DataError, match=r"m0\.csv is not there"):
        read_folder(tmp_path)


def test_the_answers_have_the_form_that_was_asked_for(written):
    assert {"tests", "effects", "closed"} <= set(written)
    assert all(set(row) == {"test", "tension_reading_wrong", "probability"} for row in written["tests"])
    assert all({"name", "size", "low", "high", "unit", "probability"} <= set(row) for row in written["effects"])
    assert all(row["low"] <= row["size"] <= row["high"] for row in written["effects"])


@needs_damper
def test_the_measured_damper_has_one_backlash_in_both_series_and_no_wrong_reading():
    found = answers(diagnose_tests(read_folder(DATA)))
    assert not any(row["tension_reading_wrong"] for row in found["tests"])
    assert found["cause"]["name"] == "backlash"
    assert found["cause"]["sizes_agree"]
    assert found["closed"] > 0.9


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "m0.csv is no table"),
        (
            "time_s,displacement_in,force_kip,force_set\n0,0,0,0\n",
            "more than one column .* with 'force'.*force_set",
        ),
        ("time_s,displacement_in\n0,0\n", "no column that begins with 'force'"),
    ],
)
def test_a_test_that_cannot_be_read_is_one_sentence(folder, tmp_path, content, told, capsys):
    (tmp_path / "tests.csv").write_text((folder / "tests.csv").read_text())
    (tmp_path / "m0.csv").write_text(content)
    with pytest.raises(SystemExit):
        main(["--data", str(tmp_path)])
    assert re.search(told, capsys.readouterr().err)


def test_answers_that_cannot_be_written_are_refused_before_the_work(folder, tmp_path, capsys):
    for option in ("--out", "--picture"):
        with pytest.raises(SystemExit):
            main(["--data", str(folder), option, str(tmp_path / "nowhere" / "x.json")])
        assert "there is no folder" in capsys.readouterr().err


def test_the_end_that_was_recorded_alone_stays_that_end(folder, tmp_path):
    whole = pd.read_csv(folder / "m0.csv")
    whole.drop(columns="tension_a_lb").to_csv(tmp_path / "m0.csv", index=False)
    told = dict.fromkeys(("frequency", "amplitude", "tension"), 1.0)
    alone = read_test(tmp_path / "m0.csv", "m0", "made", told)
    assert np.isnan(alone.tension[0]).all()
    assert np.isfinite(alone.tension[1]).all()
