"""The family of bricks and springs: its geometry, its loads, and CalculiX's strains beside those of the strips."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.springs import loads
from benchmarks.blind.assets.springs.asset import SpringsAsset
from benchmarks.blind.assets.springs.solids import LINES, Shape, inward, loop, solids, without
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


def test_ties_join_nodes_at_one_place_so_that_no_turn_strains_them(wing):
    first, second = wing.nodes[wing.ties].transpose(1, 0, 2)
    assert np.abs(first - second).max() < 1e-12


def test_a_square_moved_inward_is_a_smaller_square():
    square = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    assert inward(square, 0.1) == pytest.approx(0.9 * square)


def test_ties_can_be_taken_out(wing):
    gone = np.array(wing.tie_of) == "upper"
    left = without(wing, gone)
    assert len(left.ties) == len(wing.ties) - gone.sum() > 0
    assert set(left.tie_of) == {"lower", "rib"}


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


def test_a_torque_turns_and_does_not_lift(wing):
    turn = loads.force(wing, SHAPE, "torsion")
    assert turn.sum() == pytest.approx(0.0, abs=1e-9)
    assert turn @ wing.nodes[:, 0] == pytest.approx(
        0.01 * loads.lift(wing, SHAPE) @ SHAPE.chord(wing.nodes[:, 1] / 1.8288)
    )


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


def test_every_run_has_a_name_and_a_deck_of_its_own():
    asset = object.__new__(SpringsAsset)
    asset._run = lambda store, jobs: {}
    asset.__init__(3, refinement=0.3)
    decks = asset._decks()
    assert 45 < len(decks) < 70
    softer = decks["slack_joint 0 0"]()
    assert softer.soft
    assert decks["bent 3 0 0"]().is_bent
    assert decks["temperature_gradient 0 0"]().warm.sum() == pytest.approx(0.0)
    assert replace(softer, soft={}).stiff.min() == 1.0
    assert decks["lift 0.6 0.2"]().stiff.min() == pytest.approx(0.4)
