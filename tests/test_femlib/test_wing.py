"""The wing: geometry, loads, linearity, and its distance from the published table."""

import numpy as np
import pytest

from femlib.dataset import Dataset, MeanStrains, build_dataset
from femlib.mesh import DOFS_PER_NODE
from femlib.wing import Wing, tapered_wing, uav_twin, uav_wing


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def state(means: MeanStrains, mu1: int, mu2: int) -> np.ndarray:
    return means.strain_microstrain[(means.states_percent == [mu1, mu2]).all(axis=1)][0]


def test_gauges_lie_where_the_wing_has_them(coarser: Wing) -> None:
    gauges = coarser.gauges
    assert gauges.names[:24] == tuple(f"g{k:02d}" for k in range(1, 25))
    assert gauges.names[24:] == tuple(f"c{k:02d}" for k in range(1, 59))
    assert gauges.eta[[0, 7, 8, 15, 16, 19, 20, 23]] == pytest.approx(
        [0.28979, 0.40989, 0.59215, 0.71225, 0.3, 0.40294, 0.59937, 0.70231], abs=1e-5
    )
    assert gauges.chord_fraction[[0, 15, 16, 23]] == pytest.approx([0.22163, 0.22163, 0.34586, 0.34586])
    assert gauges.position[:, 1] == pytest.approx(coarser.span * gauges.eta)
    assert (gauges.position[:, 2] > 0).all()


def test_region_edges_and_the_front_row_lie_on_grid_lines(coarser: Wing) -> None:
    for region in coarser.regions:
        assert np.isclose(coarser.grid.eta[:, None], [region.eta_min, region.eta_max]).any(axis=0).all()
        assert np.isclose(coarser.grid.chord[:, None], [region.chord_min, region.chord_max]).any(axis=0).all()
    assert np.isclose(coarser.grid.eta[:, None], coarser.gauges.eta[:16]).any(axis=0).all()


def test_the_lift_has_its_total_its_ellipse_and_its_quarter_chord(coarser: Wing) -> None:
    force = coarser.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    x, y, _ = coarser.structure.shells.mesh.nodes.T
    assert force.sum() == pytest.approx(32.357 * 9.81 / 2.0, rel=1e-12)
    assert force @ y == pytest.approx(force.sum() * 4.0 / (3.0 * np.pi) * coarser.span, rel=1e-12)
    taper = np.interp(y, [0.0, coarser.span], [0.43561, 0.261112])
    assert force @ (x / taper + 0.30) == pytest.approx(0.25 * force.sum(), rel=1e-9)
    assert (force >= 0).all()


def test_the_skins_look_outward_and_close_the_wing(coarser: Wing) -> None:
    mesh = coarser.structure.shells.mesh
    vectors = mesh.area_vectors()
    top = np.concatenate([mesh.elements_in(p) for p in ("top", "R1", "R2")])
    assert (vectors[top, 2] > 0).all()
    assert (vectors[mesh.elements_in("bottom"), 2] < 0).all()
    used = np.unique(np.concatenate([mesh.quads.ravel(), mesh.trias.ravel()]))
    assert np.array_equal(used, np.arange(len(mesh.nodes)))


def test_the_tip_stiffness_is_the_published_one(wing: Wing) -> None:
    assert wing.tip_stiffness() == pytest.approx(677.0, rel=1e-3)


def test_pristine_strains_are_those_of_the_published_table(simulated: MeanStrains, published: MeanStrains) -> None:
    usable = published.is_usable
    assert np.array_equal(simulated.is_usable, usable)
    ratio = state(simulated, 0, 0) / state(published, 0, 0) - 1.0
    assert rms(ratio[usable]) < 0.04


@pytest.mark.parametrize("damage", [(k, 0) for k in (20, 40, 60, 80)] + [(0, k) for k in (20, 40, 60, 80)])
def test_damage_increments_are_those_of_the_published_table(
    simulated: MeanStrains, published: MeanStrains, damage: tuple[int, int]
) -> None:
    ours, theirs = (state(m, *damage) - state(m, 0, 0) for m in (simulated, published))
    usable = published.is_usable
    assert rms((ours - theirs)[usable]) < 0.05 * np.abs(theirs[usable]).max()


def bayes_errors(data: Dataset) -> list[float]:
    """Share of rows that the rule which knows the 25 means gets wrong, for mu1 and mu2."""
    distance = np.square(data.features[:, None] - data.mean_features[None]).sum(axis=2)
    likely = np.exp(-0.5 * (distance - distance.min(axis=1, keepdims=True)) / data.noise_sd**2)
    wrong = []
    for label in data.states_percent.T:
        levels = np.unique(label)
        posterior = np.stack([likely[:, label == level].sum(axis=1) for level in levels], axis=1)
        wrong.append(float(np.mean(levels[posterior.argmax(axis=1)] != label[data.states])))
    return wrong


def test_best_possible_errors_are_those_of_the_table(simulated: MeanStrains, published: MeanStrains) -> None:
    ours, theirs = (bayes_errors(build_dataset(means)) for means in (simulated, published))
    assert theirs[0] < 0.01
    assert 0.5 < theirs[1] < 0.6
    assert ours == pytest.approx(theirs, abs=0.015)


def test_the_twin_answers_for_the_installed_gauges(tiny: Wing, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("femlib.wing.twin.uav_wing", lambda: tiny)
    twin = uav_twin()
    assert twin.gauges == tiny.gauges.names
    assert len(twin.gauges) == 24
    at = {"mu1": 0.2, "mu2": 0.0}
    assert twin.predict(at, 2.0) == pytest.approx(tiny.strain_microstrain(at, 2.0))


def test_a_gauges_distance_from_a_region_is_that_along_the_skin(coarser: Wing) -> None:
    gauges, region = coarser.gauges, coarser.regions[1]
    distance = dict(zip(gauges.names, gauges.distances(region, coarser.planform), strict=True))
    assert distance["c41"] == pytest.approx((2 / 3 - (0.19 + 10 * 0.6 / 13)) * coarser.span)
    assert distance["g14"] == pytest.approx((0.4 - 0.22163) * coarser.planform.chord(gauges.eta[13]))
    is_inside = [name == "R2" for name in gauges.regions]
    assert np.array_equal(np.array(list(distance.values())) == 0.0, is_inside)


def test_the_model_hash_tells_models_apart(tiny: Wing, coarser: Wing) -> None:
    assert tiny.model_hash == uav_wing(refinement=0.25).model_hash
    assert tiny.model_hash != uav_wing(refinement=0.25, effective_mass=24.0).model_hash
    assert tiny.model_hash != coarser.model_hash


def test_all_28_regions_lie_on_rib_bays(all_regions: Wing) -> None:
    ends = 12 * np.array([(r.eta_min, r.eta_max) for r in all_regions.regions])
    assert ends == pytest.approx(np.round(ends))
    assert all_regions.parameters == tuple(f"mu{k}" for k in range(1, 29))
    assert all_regions.gauges.is_usable.sum() == 20


def test_the_tapered_wing_is_another_one_of_the_same_names(tiny: Wing) -> None:
    tapered = tapered_wing(candidates=True, refinement=0.25)
    assert tapered.gauge_names[:24] == tiny.gauge_names
    assert tapered.parameters == tiny.parameters
    assert tapered.model_hash != tiny.model_hash
    assert np.array_equal(tapered.gauges.is_usable[:24], tiny.gauges.is_usable)
    assert tapered.gauges.is_usable.sum() == 67
    ratio = tapered.strain_microstrain({}, 1.0)[:24] / tiny.strain_microstrain({}, 1.0)
    assert rms(ratio - 1.0) < 0.1
    assert tapered.tip_stiffness() == pytest.approx(tiny.tip_stiffness(), rel=0.02)
