"""The limit of information, the noises, the sets of sound assets, and the tables that stand families side by side."""

import csv

import numpy as np
import pytest

from benchmarks.blind import reliability, tables
from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.calculix import CalculixAsset
from benchmarks.blind.assets.outside import OUTSIDE
from benchmarks.blind.assets.shells import FemlibAsset
from benchmarks.blind.assets.springs.asset import SpringsAsset
from benchmarks.blind.cases import ALL_LOADS, SOUND, Case, draw_cases, mean_readings, moments, write_run
from benchmarks.blind.limit import selector
from benchmarks.blind.limit.candidates import singles
from benchmarks.blind.limit.evidence import Columns, integrate, pair_gains, pattern_evidence
from benchmarks.blind.limit.record import limit
from benchmarks.blind.noises import GROWN, NOISES
from benchmarks.blind.sealing import facts
from benchmarks.blind.sound import sound
from benchmarks.blind.truths import SINGLES, Truth
from benchmarks.noises import VARIANCE

HEALTHY = (0.0, 0.0)


@pytest.fixture(scope="module")
def asset():
    return BeamAsset(7, n_stations=41)


@pytest.fixture(autouse=True)
def few_pairs(monkeypatch):
    """Search few pairs: whether they are found among more is no matter of these tests."""
    monkeypatch.setattr(selector, "N_PAIRS", 15)
    monkeypatch.setattr(selector, "N_DISCRETE", 5)


def case(*truths):
    return Case("x", "single", truths, (HEALTHY,), True, ALL_LOADS, "white", BeamAsset.family)


def answered(asset, *truths):
    """Return the selector's answer to mean readings that white noise has moved."""
    drawn = case(*truths)
    means = np.array([mean_readings(truths, asset, moment).mean(axis=0) for moment in moments(drawn)])
    noise = np.random.default_rng(3).standard_normal(means.shape) * np.sqrt(VARIANCE / 50)
    return limit(drawn, asset, means + noise, True)


def test_the_selector_says_none_of_a_sound_asset(asset):
    found = answered(asset)
    assert found["which"][0]["effects"] == []
    assert found["which"][0]["probability"] > 0.5
    assert sum(cause["probability"] for cause in found["which"]) <= 1.0 + 1e-9


def test_the_selector_names_a_clear_effect_with_its_size_and_closes_it(asset):
    truth = Truth("gauge_bias", 40.0, "g05")
    found = answered(asset, truth)
    (parameter,) = found["which"][0]["parameters"]
    assert (parameter["effect"], parameter["place"]) == ("gauge_bias", "g05")
    assert parameter["low"] < 40.0 < parameter["high"]
    held = np.array(facts(case(truth), asset)["held_change"])
    assert np.linalg.norm(held - found["correction"]) < 0.2 * np.linalg.norm(held)


def test_the_selector_names_both_of_a_pair_of_which_one_hides_the_other(asset):
    found = answered(asset, Truth("dead_gauge", 1.0, "g04"), Truth("temperature_uniform", 12.0))
    assert any(
        {"dead_gauge"} <= set(a) and "temperature_uniform" in b
        for groups in found["names"][:1]
        for a, b in [groups, groups[::-1]]
    )


def test_the_selector_knows_what_is_outside_the_library(asset):
    found = answered(asset, Truth("outside", 2.0, "tip_cable", {"seed": 1, "spot": ""}))
    assert found["which"][0]["effects"] == ["unknown"]
    assert found["unknown_probability"] > 0.99


def test_priors_of_the_candidates_sum_to_one(asset):
    candidates = singles(asset)
    assert {c.truth.name for c in candidates} == {n for n in SINGLES if asset.n_places.get(n) != 0}
    assert np.sum(np.exp([c.log_prior for c in candidates])) == pytest.approx(1.0)


def test_evidence_of_a_change_is_the_integral_over_its_sizes():
    rng = np.random.default_rng(1)
    a, b, residual = rng.standard_normal((3, 6))
    columns = Columns(a[None], 0.1 * b[None], np.array([0.3]), np.array([3.0]), np.array([1.0]))
    sizes = np.exp(np.linspace(np.log(0.3), np.log(3.0), 20001))
    likelihood = [
        np.exp(residual @ c - 0.5 * c @ c) for s in (sizes, -sizes) for c in np.outer(s, a) + np.outer(s**2, 0.1 * b)
    ]
    assert integrate(columns, residual).log[0] == pytest.approx(np.log(np.mean(likelihood)), abs=0.02)


def test_a_pattern_is_a_normal_weight_for_each_column():
    columns, residual = np.array([[2.0, 0.0], [0.0, 1.0], [0.0, 0.0]]), np.array([1.0, -2.0, 0.5])
    covariance = np.eye(3) + columns @ columns.T
    log = -0.5 * (residual @ np.linalg.solve(covariance, residual) + np.linalg.slogdet(covariance)[1])
    assert pattern_evidence(columns, residual, np.ones(1)) == pytest.approx(log + 0.5 * residual @ residual)


def test_the_gain_of_a_pair_is_what_least_squares_take_away():
    rng = np.random.default_rng(2)
    columns, residual = rng.standard_normal((3, 8)), rng.standard_normal(8)
    pair = columns[[0, 2]].T
    left = residual - pair @ np.linalg.lstsq(pair, residual, rcond=None)[0]
    gain = 0.5 * (residual @ residual - left @ left)
    assert pair_gains(columns, residual)[0, 2] == pytest.approx(gain)


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
    columns = tables.spread({"diagnosis": [*own, *other]}, [])
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
