"""The reduced model is the full model within its bound, and never outside it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from femlib.components import PortFlexibility, port_flexibility
from femlib.errors import InputError
from femlib.rom import ReducedModel, ReductionSettings, reduce_ports, reduce_structure
from femlib.wing import ReducedWing, Wing, reduce_wing

MICRO = 1e6
QUICK = ReductionSettings(n_states=100, n_dual_states=6)
"""Enough for two regions."""


@pytest.fixture(scope="module")
def ports(coarser: Wing) -> PortFlexibility:
    return port_flexibility(coarser.structure, coarser.lift, MICRO * coarser.strain_rows, coarser.gauges.names)


@pytest.fixture(scope="module")
def reduced(coarser: Wing) -> ReducedWing:
    return reduce_wing(coarser, QUICK)


@pytest.fixture(scope="module")
def model(reduced: ReducedWing) -> ReducedModel:
    return reduced.model


@pytest.fixture(scope="module")
def many(all_regions: Wing) -> PortFlexibility:
    wing = all_regions
    return port_flexibility(wing.structure, wing.lift, MICRO * wing.strain_rows, wing.gauges.names)


@pytest.fixture(scope="module")
def many_reduced(many: PortFlexibility) -> ReducedModel:
    return reduce_ports(many, ReductionSettings(n_states=300, n_dual_states=8))


def random_states(n: int, n_regions: int = 2, n_damaged: int | None = None, most: float = 0.95) -> np.ndarray:
    rng = np.random.default_rng(3)
    states = rng.uniform(0.0, most, (n, n_regions))
    damaged = n_regions if n_damaged is None else n_damaged
    for state in states:
        state[rng.choice(n_regions, n_regions - damaged, replace=False)] = 0.0
    states[0] = 0.0
    return states


def test_the_bound_is_never_below_the_true_error(coarser: Wing, reduced: ReducedWing) -> None:
    states = np.concatenate([random_states(150), random_states(50, n_damaged=1)])
    error = np.abs(reduced.strains_microstrain(states, -2.0) - coarser.strains_microstrain(states, -2.0))
    assert (error <= reduced.error_bound_microstrain(states, -2.0)).all()
    assert error.max() < 0.02


@pytest.mark.long("1-0.1")
@pytest.mark.parametrize(("n_damaged", "aim"), [(1, 0.1), (3, 0.1), (8, 1.0), (28, 1.0)])
def test_28_regions_are_within_their_aim_and_their_bound(
    many: PortFlexibility, many_reduced: ReducedModel, n_damaged: int, aim: float
) -> None:
    assert many_reduced.n_modes > many_reduced.n_leading  # so that the rest has to follow
    states = random_states(25, 28, n_damaged, most=0.8)
    error = 3.0 * np.abs(many_reduced.solve(states) - many.solve(states))
    assert (error <= 3.0 * many_reduced.error_bound(states)).all()
    assert error.max() < aim


@pytest.mark.parametrize("n_damaged", [1, 2, 3])
def test_few_regions_have_a_bound_near_their_error(
    many: PortFlexibility, many_reduced: ReducedModel, n_damaged: int
) -> None:
    states = random_states(25, 28, n_damaged)[1:]
    error, bound = np.abs(many_reduced.solve(states) - many.solve(states)), many_reduced.error_bound(states)
    assert (error <= bound).all()
    assert np.median(bound / error) < 20.0


def test_couplings_bound_the_exact_ones(many: PortFlexibility, many_reduced: ReducedModel) -> None:
    for damage in random_states(6, 28, 4)[1:]:
        mu = damage[many.owner]
        on = mu > 0.0
        root = 1.0 / np.sqrt(1.0 / mu[on] - many.own[on])
        exact = np.linalg.eigvalsh(root[:, None] * many.across[np.ix_(on, on)] * root).max()
        assert exact <= many_reduced.bound.coupling(damage) < 1.0
    assert many_reduced.bound.coupling(np.full(28, 0.999)) == np.inf


def test_the_exact_model_of_28_regions_is_a_factorisation_of_its_own(many: PortFlexibility, all_regions: Wing) -> None:
    wing = all_regions
    states = random_states(3, 28)
    full = MICRO * wing.structure.solve_outputs(states, wing.lift, wing.strain_rows)
    assert many.solve(states) == pytest.approx(full, abs=1e-5)


def test_the_bound_holds_where_the_model_is_poor(ports: PortFlexibility) -> None:
    poor = reduce_ports(ports, ReductionSettings(tolerance=0.1, n_states=3, n_dual_states=1, most_damage=0.3))
    states = random_states(50, most=0.99)
    error = np.abs(poor.solve(states) - ports.solve(states))
    assert error.max() > 1.0
    assert (error <= poor.error_bound(states)).all()


def test_more_modes_are_better(ports: PortFlexibility) -> None:
    states = random_states(50)
    full = ports.solve(states)
    errors = [np.abs(reduce_ports(ports, replace(QUICK, tolerance=t)).solve(states) - full).max() for t in (1e-2, 1e-5)]
    assert errors[0] > 10 * errors[1]


def test_displacements_are_those_of_the_full_model(coarser: Wing, reduced: ReducedWing) -> None:
    for state in ({}, {"mu1": 0.7}, {"mu1": 0.4, "mu2": 0.8}):
        full = coarser.solve(state, 3.0)
        error = np.abs(reduced.solve(state, 3.0) - full)
        assert error[:, :3].max() < 1e-5 * np.abs(full[:, :3]).max()
        # 4.5e-5: rotations within region 1, a whole rib bay of skin that no gauge but g17 reads
        assert error[:, 3:].max() < 1e-4 * np.abs(full[:, 3:]).max()


@pytest.mark.parametrize("which", ["model", "many_reduced"])
def test_a_batch_is_its_single_queries(which: str, request: pytest.FixtureRequest) -> None:
    model: ReducedModel = request.getfixturevalue(which)
    states = random_states(700 if which == "model" else 20, len(model.parameters))
    single = np.array([model.query(mu) for mu in states])
    assert model.solve(states) == pytest.approx(single, rel=1e-8, abs=1e-8)
    assert model.solve(states[5:6])[0] == pytest.approx(single[5], rel=1e-8)


def test_turns_that_do_not_settle_are_solved_together(ports: PortFlexibility, monkeypatch: pytest.MonkeyPatch) -> None:
    model = reduce_ports(ports, QUICK)
    states = random_states(20)
    settled = model.solve(states)
    monkeypatch.setattr("femlib.rom.sweeps.MOST_TURNS", 1)
    assert model.solve(states) == pytest.approx(settled, rel=1e-8)


def test_a_load_of_ones_own_is_reduced(coarser: Wing) -> None:
    load = np.roll(coarser.lift, 6)  # another load, to the next node
    state = {"mu1": 0.6}
    row = np.array([[0.6, 0.0]])
    full = MICRO * coarser.structure.solve_outputs(row, 2.0 * load, coarser.strain_rows)[0]
    own = reduce_wing(coarser, QUICK, load)
    assert own.strain_microstrain(state, 2.0) == pytest.approx(full, abs=0.01)
    assert np.abs(coarser.strain_microstrain(state, 2.0) - full).max() > 1.0
    with pytest.raises(InputError, match=r"lift has shape \(3,\)"):
        reduce_wing(coarser, QUICK, np.zeros(3))


def test_a_model_comes_back_from_its_file(reduced: ReducedWing, coarser: Wing, tmp_path: Path) -> None:
    path = tmp_path / "wing.npz"
    reduced.save(path)
    again = ReducedWing.load_file(path)
    states = random_states(5)
    assert np.array_equal(again.strains_microstrain(states, 3.0), reduced.strains_microstrain(states, 3.0))
    assert np.array_equal(again.error_bound_microstrain(states, 3.0), reduced.error_bound_microstrain(states, 3.0))
    assert np.array_equal(again.solve({"mu1": 0.5}, 1.0), reduced.solve({"mu1": 0.5}, 1.0))
    assert again.provenance == reduced.provenance
    assert again.provenance["model"] == coarser.model_hash
    assert again.parameters == ("mu1", "mu2")
    assert again.gauges == reduced.gauges
    assert [p.name for p in tmp_path.iterdir()] == ["wing.npz"]


def test_a_model_without_its_motion_says_so(coarser: Wing, tmp_path: Path) -> None:
    bare = reduce_structure(coarser.structure, coarser.lift, coarser.strain_rows, coarser.gauges.names, QUICK)
    bare.save(tmp_path / "bare.npz")
    with pytest.raises(InputError, match="holds no displacements"):
        ReducedModel.load_file(tmp_path / "bare.npz").displacements(np.zeros((1, 2)))
    with pytest.raises(InputError, match="a reduced model of 82 outputs is not that of a wing"):
        ReducedWing.load_file(tmp_path / "bare.npz")


def test_a_place_that_holds_no_model_gets_a_sentence(model: ReducedModel, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"ends in '.bin'; expected .npz"):
        model.save(tmp_path / "wing.bin")
    with pytest.raises(InputError, match=r"cannot be written .*expected a writable folder"):
        model.save(tmp_path / "nowhere" / "wing.npz")
