"""The wing that one would build: real materials, no saw-tooth, the published strains, buckling beyond what is flown."""

import numpy as np
import pytest

from femlib.dataset import MeanStrains
from femlib.rom.capability import full_limits
from femlib.wing import Wing
from femlib.wing.built import ROOT, built_library, built_materials, built_wing
from femlib.wing.strength import wing_limits


@pytest.fixture(scope="module")
def built() -> Wing:
    return built_wing(refinement=0.4)


def test_its_materials_are_those_of_carbon_and_plywood_and_its_skin_only_steps_down(built):
    cards = built_materials()
    for factor in (cards.web_factor, cards.rib_factor):
        assert 4e9 <= cards.modulus_scale * cards.wood_young * factor <= 9e9
    shells, mesh = built.structure.shells, built.structure.shells.mesh
    eta = mesh.centroids()[:, 1] / built.span
    skin = (shells.section == 0) & (mesh.patch_of_element < 2)
    order = np.argsort(eta[skin], kind="stable")
    assert (np.diff(shells.scale[skin][order]) <= 1e-12).all()
    assert shells.scale[skin].max() == pytest.approx(ROOT)
    faces = 0.5 * cards.skin_young * cards.skin_thickness  # E t of one face
    assert 16e9 * 0.03e-3 < cards.skin_step * faces < faces < 16e9 * 0.2e-3


def test_it_is_near_the_published_strains(built, published: MeanStrains):
    rows = {
        tuple(state): strain
        for state, strain in zip(published.states_percent, published.strain_microstrain, strict=True)
    }
    usable, sound = published.is_usable, rows[0, 0]
    own = built.strain_microstrain({}, 3.0)
    assert np.sqrt(np.mean((own / sound - 1.0)[usable] ** 2)) < 0.05
    for name, state, most in (("mu1", (80, 0), 0.08), ("mu2", (0, 80), 0.18)):
        increment = (rows[state] - sound)[usable]
        found = (built.strain_microstrain({name: 0.8}, 3.0) - own)[usable]
        assert np.sqrt(np.mean((found - increment) ** 2)) < most * np.abs(increment).max()


@pytest.mark.long
def test_it_bears_three_g_sound_buckles_far_above_and_less_with_damage(built):
    limits, mu1 = wing_limits(built), np.array([name == "mu1" for name in built.parameters])
    sound, damaged = (full_limits(built.structure, limits, built.lift, mu * mu1) for mu in (0.0, 0.8))
    assert 3.0 < sound.min() < 4.5
    assert damaged.min() < 0.9 * sound.min()
    assert min(sound[1], damaged[1]) > 6.0


def test_its_library_has_the_28_regions(built):
    library = built_library()
    assert len(library) == 28
    assert library[:2] == built.regions
    assert [region.name for region in library] == [f"R{k}" for k in range(1, 29)]
