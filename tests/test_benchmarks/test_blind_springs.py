"""The family of bricks and springs: its geometry, its loads, and CalculiX's strains beside those of the strips."""

import numpy as np
import pytest

from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.springs import loads
from benchmarks.blind.assets.springs.asset import SpringsAsset
from benchmarks.blind.assets.springs.solids import LINES, Shape, loop, solids
from benchmarks.ccx import has_ccx

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
