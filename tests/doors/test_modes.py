"""Frequencies and damping of a simulated beam whose modes are known, from a recording of its vibrations."""

import json

import numpy as np
import pytest
import scipy.io
import scipy.signal

from benchmarks.cases.doors.modes import DAMPING, EIGHTHS, FREQUENCIES, RATE, accelerations, mean_and_half_width, series
from octmip.errors import DataError
from octmip.interfaces.cli import main
from octmip.recordings import Channel, modes_of

NEAR = [4.0, 25.0, 70.0]
BEAM = """
import numpy as np

def beam(parameters, loads):
    return [*(np.array(%s) * np.sqrt(parameters["stiffness"] / 100)), parameters["damping"]]
""" % FREQUENCIES.tolist()  # noqa: UP031
CARD = {
    "readings": {"f1": "Hz", "f2": "Hz", "f3": "Hz", "d2": "%"},
    "loads": ["mass"],
    "parameters": {"stiffness": [100, 70, 130, "%"], "damping": [1, 0.5, 3, "%"]},
}
WORDS = ["--windows", "0,300", "--loads", "mass=1", "--modes", "f1=4", "f2=25", "f3=70", "d2=25", "--json"]
WORDS += ["--twin", "python:beam_that_vibrates:beam", "--card", "card.json", "--vibrations"]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_true_frequency_lies_within_its_interval_and_damping_near(seed):
    mean, half_widths = mean_and_half_width(modes_of(series(accelerations(seed)), NEAR, EIGHTHS))
    assert (np.abs(mean[:3] - FREQUENCIES) < half_widths[:3]).all()
    assert (half_widths[:3] < 0.005 * FREQUENCIES).all()
    assert mean[3:] == pytest.approx(DAMPING, rel=0.2)
    assert np.geterr()["invalid"] == np.geterr()["divide"] == "warn"  # though pyOMA-2 was imported


@pytest.fixture
def softer(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "beam_that_vibrates.py").write_text(BEAM)
    (tmp_path / "card.json").write_text(json.dumps(CARD))
    scipy.io.savemat("run.mat", {"fs": RATE, "a": accelerations(5, stiffness=0.9, seconds=300.0)})
    return [f"a/{k + 1}" for k in range(4)]


def test_one_command_finds_a_softer_beam_by_its_frequencies(softer, capsys):
    assert main(["diagnose", "run.mat", *WORDS, *softer]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["verdict"].startswith(("Stiffness is 90.", "Stiffness is 89.9"))
    said = "Modes (f1, f2, f3, d2) are identified by 4 channels, a row each 37.5 s (SSI-cov of pyOMA-2)"
    assert any(said in note for note in told["notes"])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "f1=4",
            "f1=5",
            "0 of 8 stretches of 37.5 s have a mode near 5 Hz; expected half of them; most stable ones are",
        ),
        ("f1=4", "f1=low", "--modes says"),
        ("f3=70", "f3=95", "channel a/1 has 200 samples a second; expected more than 237.5 for a mode near 95 Hz"),
        ("f1=4", "f9=4", "the twin has no reading 'f9'; expected 'f1', 'f2', 'f3'"),
        ("--vibrations", "--test", "4 modes and 0 vibrations; expected both"),
    ],
)
def test_what_is_wrong_with_modes_is_one_sentence(old, new, said, softer, capsys):
    words = [new if word == old else word for word in WORDS]
    assert main(["diagnose", "run.mat", *words, *softer[: 1 if new == "--test" else 4]]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_stretches_with_a_gap_or_a_bad_sample_have_no_row_and_two_rates_are_refused():
    samples, time = accelerations(1, seconds=300.0), np.arange(60_000) / RATE
    samples[100, 0] = np.nan
    keep = (time < 50.0) | (time > 51.0)
    first, second = (Channel(name, "g", time[keep], own[keep]) for name, own in zip("ab", samples.T, strict=False))
    found = modes_of([first, second], [25.0], EIGHTHS / 2.0)
    assert np.isfinite(found[:, 0, 0]).tolist() == [False, False] + [True] * 6
    with pytest.raises(DataError, match=r"channels a \(200 Hz\) and slow \(50 Hz\) were not read at the same times"):
        modes_of([first, Channel("slow", "g", time[::4], samples[::4, 2])], [4.0], EIGHTHS / 2.0)


def test_two_modes_under_one_name_are_refused_and_told_apart_by_two():
    rng, motions = np.random.default_rng(3), []
    for frequency in (24.0, 25.5):
        decay, turn = np.exp(-0.01 * 2 * np.pi * frequency / RATE), np.cos(2 * np.pi * frequency / RATE)
        motions.append(scipy.signal.lfilter([1.0], [1.0, -2 * decay * turn, decay**2], rng.normal(size=100_000)))
    both = series(np.transpose(motions) @ np.array([[1.0, 0.5, 0.2, 1.0], [0.5, -1.0, 1.0, 0.3]]))
    edges = np.linspace(0.0, 500.0, 9)
    with pytest.raises(DataError, match=r"two modes lie near 25 Hz \(24\.01 and 25\.51 Hz in the median\)"):
        modes_of(both, [25.0], edges)
    mean, _ = mean_and_half_width(modes_of(both, [24.0, 25.4], edges))
    assert mean[:2] == pytest.approx([24.0, 25.5], rel=0.002)
