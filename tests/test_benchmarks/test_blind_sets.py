"""The noises, the sets of sound assets, and the tables that stand families side by side."""

import csv

import numpy as np
import pytest

from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.cases import ALL_LOADS, SOUND, draw_cases, write_run
from benchmarks.blind.noises import GROWN, NOISES
from benchmarks.blind.sealing import facts
from benchmarks.blind.singles import singles
from benchmarks.blind.truths import SINGLES
from benchmarks.cases.gap import noise as gap_noise
from benchmarks.noises import VARIANCE


@pytest.fixture(scope="module")
def asset():
    return BeamAsset(7, n_stations=41)


@pytest.mark.parametrize("name", NOISES)
def test_every_noise_has_about_the_variance_of_white_noise(name):
    noise = NOISES[name](np.random.default_rng(5), np.repeat(ALL_LOADS, 200), 40)
    within = noise.reshape(4, 200, 40).var(axis=1).mean()
    assert 0.7 * VARIANCE < within < 3.2 * VARIANCE
    means = noise.reshape(-1, 200, 40).mean(axis=1)
    if name in GROWN:
        assert means.var() == pytest.approx(GROWN[name] * VARIANCE / 200, rel=0.35)


def test_a_set_of_sound_assets_has_every_stratum_and_no_truth(asset):
    drawn = draw_cases(2, len(SOUND), [asset], "sound")
    assert {c.stratum for c in drawn} == set(SOUND)
    assert all(c.truths == () for c in drawn)
    (split,) = [c for c in drawn if c.is_split]
    assert len(split.cells) == 2
    assert not split.is_known
    assert facts(split, asset)["d_prime"] == {"calibrated": 0.0, "bare": 0.0}


def test_the_run_of_a_damaged_wing_says_that_it_is_sound(asset, tmp_path):
    strains = {}
    for kind in ("own", "damaged", "warm", "other wing"):
        write_run(tmp_path / f"{kind}.csv", asset, 3, kind)
        header, *rows = csv.reader((tmp_path / f"{kind}.csv").read_text().splitlines())
        assert {(row[2], row[3]) for row in rows} == {("0", "0")}
        last = np.array([row[header.index("g01") :] for row in rows if row[1] == "3"], dtype=float)
        strains[kind] = last.mean(axis=0)
    apart = {kind: np.abs(strain - strains["own"]).max() for kind, strain in strains.items() if kind != "own"}
    assert all(distance > 25.0 for distance in apart.values())


def test_every_effect_of_the_library_is_compared_with_what_no_library_holds(asset):
    assert {truth.name for truth in singles(asset)} == {name for name in SINGLES if asset.n_places.get(name) != 0}


# The benchmark of sound assets by kind of noise


def test_every_kind_of_noise_is_drawn_and_one_line_holds_its_figures():
    assert all(gap_noise.drawn(kind, 0).readings.shape == (200, gap_noise.N_GAUGES) for kind in gap_noise.KINDS)
    line = gap_noise.alarms("white", 2)
    assert line["alarms"] == 0.0
    assert "| white | 0.00 |" in gap_noise.summary([line])
