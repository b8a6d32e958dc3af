"""The noises, the sets of sound assets, and the tables that stand families side by side."""

import csv

import numpy as np
import pytest

from benchmarks.blind import reliability, tables
from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.calculix import CalculixAsset
from benchmarks.blind.assets.outside import OUTSIDE
from benchmarks.blind.assets.shells import FemlibAsset
from benchmarks.blind.assets.springs.asset import SpringsAsset
from benchmarks.blind.cases import ALL_LOADS, SOUND, draw_cases, write_run
from benchmarks.blind.noises import GROWN, NOISES
from benchmarks.blind.sealing import facts
from benchmarks.blind.singles import singles
from benchmarks.blind.sound import sound
from benchmarks.blind.truths import SINGLES
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


def test_every_family_brings_three_kinds_of_its_own():
    kinds = [family.outside for family in (FemlibAsset, CalculixAsset, SpringsAsset, BeamAsset)]
    assert [len(of) for of in kinds] == [3, 3, 3, 3]
    assert len({kind for of in kinds for kind in of}) == 12
    assert {kind for of in kinds for kind in of} <= set(OUTSIDE)


def found(stated, names, doubts=()):
    return {
        "name": "x", "calibrated": True, "seconds": 1.0,
        "which": [{"effects": names, "probability": stated, "parameters": []}],
        "names": [[[name] for name in names]], "credible": [[[name] for name in names]], "unknown_probability": 0.0,
        "findings": [], "stuck": [], "significant": [], "correction": [1.0], "doubts": list(doubts),
    }  # fmt: skip


def key(stratum, family, d_prime=9.0):
    truth = {"name": "modulus", "size": 2.0, "place": "", "extra": {}}
    truths = [truth] if stratum == "single" else []
    return {
        "case": {"name": "x", "stratum": stratum, "truths": truths, "states": [[0.0, 0.0]], "is_known": True,
                 "loads": list(ALL_LOADS), "noise": "white", "family": family, "is_split": False, "run": "own"},
        "d_prime": {"calibrated": d_prime, "bare": d_prime},
        "d_prime_of_parts": {"calibrated": [d_prime], "bare": [d_prime]},
        "held_change": [1.0], "entries": {}, "strain": [100.0], "gauges": ["g01"],
    }  # fmt: skip


def test_the_spread_is_the_foreign_figure_less_the_own_one():
    own = [(found(0.9, ["modulus"]), key("single", "femlib, other mesh"))] * 4
    other = [(found(0.9, [name]), key("single", "beam")) for name in ("modulus", "creep", "creep", "creep")]
    columns = tables.spread({"diagnosis": [*own, *other]})
    rows = {column: figures[0] for column, figures in columns.items() if figures}
    assert rows["own family"].value == 1.0
    assert rows["foreign families"].value == 0.25
    assert rows["foreign less own"].value == pytest.approx(-0.75)
    assert rows["largest less least of the families"].value == pytest.approx(0.75)


def test_reliability_counts_only_cases_in_which_something_acts_and_by_their_band(tmp_path):
    cases = [(found(0.9, ["modulus"]), key("single", "beam")), (found(0.9, []), key("none", "beam"))]
    assert reliability.in_band(cases, "above 5") == cases[:1]
    assert reliability.errors(cases)[2].value == pytest.approx(0.1)
    reliability.draw(tmp_path / "r.svg", "two", cases)
    assert "<svg" in (tmp_path / "r.svg").read_text()


def test_doubts_of_the_run_and_accusations_are_counted():
    wrong = key("run: warm", "beam")
    wrong["case"]["run"] = "warm"
    rows = {row.name: row for row in sound([(found(0.9, ["modulus"], ["too warm"]), wrong), (found(0.9, []), wrong)])}
    assert rows["run of a wing 10 K warmer doubted"].value == 0.5
    assert rows["asset accused beside the run of a wing 10 K warmer"].value == 0.5
