"""Peaks and levels of simulated vibrations whose truth is known, from a recording to the diagnosis."""

import json

import numpy as np
import pytest
import scipy.io
import scipy.signal
import scipy.stats

from octmip.errors import DataError
from octmip.interfaces.cli import main
from octmip.recordings import Channel, levels_of
from octmip.recordings.statistics import worth

RATE, SECONDS = 100.0, 400.0
EIGHTHS = np.linspace(0.0, SECONDS, 9)
BEAM = """
def beam(parameters, loads):
    return [parameters["level"] / 100, parameters["level"] / 100 * 3.677]
"""
CARD = {
    "readings": {"rms": "g", "peak": "g"},
    "loads": ["speed"],
    "parameters": {"level": [100, 50, 200, "%"]},
}
WORDS = ["--windows", "0,400", "--loads", "speed=1", "--readings", "rms=a", "peak=b", "--json"]
WORDS += ["--twin", "python:beam_of_levels:beam", "--card", "card.json", "--levels", "rms=10:20", "peak=max"]


def noise(seed, memory, seconds=SECONDS):
    """Return an AR(1) process (n,) of unit shocks."""
    shocks = np.random.default_rng(seed).normal(size=round(seconds * RATE) + 2000)
    return scipy.signal.lfilter([1.0], [1.0, -memory], shocks)[2000:]


def channel(values):
    return Channel("a", "g", np.arange(len(values)) / RATE, values)


def level(memory, low=10.0, high=20.0):
    """Return the root of the power of the process in a band, by its density."""
    f = np.linspace(low, high, 20_001)
    return np.sqrt(np.trapezoid(2.0 / RATE / np.abs(1.0 - memory * np.exp(-2j * np.pi * f / RATE)) ** 2, f))


PEAKS = {0.0: 3.677, 0.9: 8.022}
"""Mean largest sample of 5,000, of five thousand blocks."""


def half_width(levels):
    """Return that of the 95 % interval about the mean of levels (n,)."""
    return scipy.stats.t.ppf(0.975, len(levels) - 1) * levels.std(ddof=1) / np.sqrt(worth(levels))


@pytest.mark.long
@pytest.mark.parametrize("memory", PEAKS)
def test_intervals_of_95_percent_hold_the_truth_of_a_hundred_series(memory):
    held = np.zeros(3, dtype=int)
    for seed in range(100):
        series = channel(noise(seed, memory))
        found = [levels_of(series, how, EIGHTHS) for how in ("max", "min", (10.0, 20.0))]
        truth = (PEAKS[memory], -PEAKS[memory], level(memory))
        held += [abs(one.mean() - right) < half_width(one) for one, right in zip(found, truth, strict=True)]
    assert held.min() >= 90
    assert held.max() <= 99


def test_values_are_those_of_the_blocks_and_their_worth_falls_with_memory():
    values = noise(1, 0.9)
    found = levels_of(channel(values), "max", np.linspace(0.0, 80.0, 5))
    assert found.tolist() == values[:8000].reshape(4, 2000).max(axis=1).tolist()
    drift = levels_of(channel(values + np.linspace(0.0, 50.0, len(values))), "max", np.linspace(0.0, SECONDS, 41))
    assert worth(drift) < 3.0
    sine = channel(2.0 * np.sin(2.0 * np.pi * 15.0 * np.arange(40_000) / RATE))
    assert levels_of(sine, (10.0, 20.0), EIGHTHS).mean() == pytest.approx(np.sqrt(2.0), rel=1e-3)
    assert levels_of(sine, (20.0, 30.0), EIGHTHS).mean() < 0.02


def test_a_block_with_a_gap_or_a_bad_sample_has_no_value():
    values = noise(2, 0.0)
    values[100] = np.nan
    keep = (np.arange(len(values)) < 9000) | (np.arange(len(values)) > 9010)
    series = Channel("a", "g", np.arange(len(values))[keep] / RATE, values[keep])
    assert np.isfinite(levels_of(series, "max", EIGHTHS)).tolist() == [False, False] + [True] * 6


@pytest.mark.parametrize(
    ("how", "end", "said"),
    [
        ((10.0, 60.0), SECONDS, "band from 10 to 60 Hz .* expected one below 50 Hz"),
        ((20.0, 10.0), SECONDS, "band from 20 to 10 Hz; expected its lower end first"),
        ((10.0, 10.1), SECONDS, "in blocks of 50 s .* and 0.32 Hz wide at least"),
        ("max", 0.2, "0 of 8 blocks of 0.025 s of channel a have no gap"),
    ],
)
def test_what_a_recording_does_not_bear_is_one_sentence(how, end, said):
    with pytest.raises(DataError, match=said):
        levels_of(channel(noise(1, 0.0)), how, np.linspace(0.0, end, 9))


@pytest.fixture
def louder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "beam_of_levels.py").write_text(BEAM)
    (tmp_path / "card.json").write_text(json.dumps(CARD))
    rms, peak = 1.4 / level(0.0) * noise(3, 0.0), 1.4 * noise(4, 0.0)
    scipy.io.savemat("run.mat", {"fs": RATE, "a": rms, "b": peak})


def test_one_command_finds_a_machine_that_is_louder_by_level_and_peak(louder, capsys):
    assert main(["diagnose", "run.mat", *WORDS]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["parameters"][0]["size"] == pytest.approx(40.0, abs=4.0)
    said = "Readings are no means but levels (rms 10 to 20 Hz, peak max) of blocks of 50 s, a row each; 0 of 16"
    assert any(note.startswith(said) for note in told["notes"])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("peak=max", "peak=most", "level 'most'; expected max, min, or LOW:HIGH in Hz"),
        ("peak=max", "crest=max", "the twin has no reading 'crest'; expected 'rms', 'peak'"),
        ("peak=b", "rms=b", "--readings names rms twice"),
        ("rms=a", "peak=a", "--readings names peak twice"),
    ],
)
def test_what_is_wrong_with_levels_is_one_sentence(old, new, said, louder, capsys):
    assert main(["diagnose", "run.mat", *(new if word == old else word for word in WORDS)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_level_without_a_channel_is_one_sentence(louder, capsys):
    words = [word for word in WORDS if word != "peak=b"]
    assert main(["diagnose", "run.mat", *words]) == 2
    assert "the level 'peak' has no channel; expected --readings peak=CHANNEL" in capsys.readouterr().err
