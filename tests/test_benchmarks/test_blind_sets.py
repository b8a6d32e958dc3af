"""The noises, the sets of sound assets, and the tables that stand families side by side."""

import csv

import numpy as np
import pytest

from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.springs import loads
from benchmarks.blind.assets.springs.asset import SpringsAsset
from benchmarks.blind.assets.springs.solids import LINES, Shape, loop, solids
from benchmarks.blind.cases import ALL_LOADS, SOUND, draw_cases, write_run
from benchmarks.blind.noises import GROWN, NOISES
from benchmarks.blind.sealing import facts
from benchmarks.blind.singles import singles
from benchmarks.blind.truths import SINGLES
from benchmarks.cases import gap_noise
from benchmarks.ccx import has_ccx
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


# The family of bricks and springs: its geometry, its loads, and CalculiX's strains beside those of the strips


HEALTHY = (0.0, 0.0)
SHAPE = Shape(refinement=0.5)


@pytest.fixture(scope="module")
def wing():
    return solids(SHAPE, (0.24, 0.39))


def volumes(wing):
    """Return the volume of each brick (n_bricks,) from the middles of opposite faces."""
    corner = wing.nodes[wing.bricks]
    sign = np.array(
        [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
    )
    return np.linalg.det(np.einsum("eni,nj->eij", corner, sign / 8.0)) * 8.0


def test_all_bricks_are_right_handed_and_the_skin_is_as_thick_as_drawn(wing):
    size = volumes(wing)
    skin = np.array([part == "skin" for part in wing.part])
    eta = np.linspace(0.0, 1.0, 401)
    ring = np.linalg.norm(loop() - np.roll(loop(), 1, axis=0), axis=1).sum()
    thick = SHAPE.skin * (1.0 - (1.0 - SHAPE.taper) * eta)
    expected = np.trapezoid(ring * SHAPE.chord(eta) * thick, eta) * SHAPE.span
    assert size.min() > 0.0
    assert size[skin].sum() == pytest.approx(expected, rel=0.02)  # the corners overlap by a little


def test_the_lift_is_the_weight_at_the_quarter_chord(wing):
    force = loads.lift(wing, SHAPE)
    assert force.sum() == pytest.approx(loads.WEIGHT, rel=1e-3)
    assert loads.pressure() @ np.array(LINES) == pytest.approx(0.25)
    assert loads.pressure(0.01) @ np.array(LINES) == pytest.approx(0.26)


@pytest.mark.parametrize("kind", loads.LIFT_KINDS)
def test_other_lifts_add_a_hundredth_of_the_root_moment_and_no_lift(wing, kind):
    own, other = loads.lift(wing, SHAPE), loads.force(wing, SHAPE, f"lift_distribution:{kind}")
    y = wing.nodes[:, 1]
    assert other.sum() == pytest.approx(0.0, abs=1e-9)
    assert other @ y == pytest.approx(0.01 * (own @ y), rel=1e-3)


class Short(SpringsAsset):
    """The family with its sound lift alone."""

    def _decks(self):
        return {key: make for key, make in super()._decks().items() if key == "lift 0 0"}


@pytest.mark.skipif(not has_ccx(), reason="ccx is not installed")
def test_bricks_in_calculix_strain_as_the_strips_do(tmp_path):
    store = tmp_path / "strains.json"
    asset = Short(1, store, refinement=0.5)
    ratio = asset.strain(HEALTHY) / BeamAsset(1).strain(HEALTHY)
    assert ratio == pytest.approx(1.0, abs=0.12)
    assert 1.2 < asset.turned(3) < 1.4
    again = Short(1, store, refinement=0.5)  # ccx is not run again
    assert again.strain(HEALTHY) == pytest.approx(asset.strain(HEALTHY))
