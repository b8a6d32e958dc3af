"""The reduced model is the full model within its bound, and never outside it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from femlib.errors import InputError
from femlib.rom import ReducedModel, ReductionSettings, reduce_structure
from femlib.wing import Wing

MICRO = 1e6


def reduced(wing: Wing, settings: ReductionSettings) -> ReducedModel:
    rows = MICRO * wing.strain_rows
    return reduce_structure(wing.structure, wing.lift, rows, wing.gauges.names, settings, {"wing": wing.model_hash})


@pytest.fixture(scope="module")
def model(coarse: Wing) -> ReducedModel:
    return reduced(coarse, ReductionSettings())


def random_states(n: int) -> np.ndarray:
    rng = np.random.default_rng(3)
    states = rng.uniform(0.0, 0.95, (n, 2))
    states[rng.uniform(size=(n, 2)) < 0.2] = 0.0
    return states


def test_the_bound_is_never_below_the_true_error(coarse: Wing, model: ReducedModel) -> None:
    states = random_states(200)
    error = np.abs(model.solve(states) - coarse.strains_microstrain(states, 1.0))
    assert (error <= model.error_bound(states)).all()
    assert error[:, coarse.gauges.is_usable].max() < 0.01  # microstrain at load factor 1


def test_more_modes_are_better(coarse: Wing) -> None:
    states = random_states(50)
    full = coarse.strains_microstrain(states, 1.0)
    errors = [np.abs(reduced(coarse, ReductionSettings(tolerance=t)).solve(states) - full).max() for t in (1e-2, 1e-4)]
    assert errors[0] > 10 * errors[1]


def test_without_damage_the_reduced_model_is_exact(coarse: Wing, model: ReducedModel) -> None:
    pristine = coarse.strain_microstrain({}, 1.0)
    assert model.solve(np.zeros((1, 2)))[0] == pytest.approx(pristine, rel=1e-9)
    assert model.query(np.zeros(2)) == pytest.approx(pristine, rel=1e-9)
    assert model.error_bound(np.zeros((1, 2))).max() < 1e-4


def test_a_batch_is_its_single_queries(model: ReducedModel) -> None:
    states = random_states(700)
    batch = model.solve(states)
    single = np.array([model.query(mu) for mu in states])
    assert batch == pytest.approx(single, rel=1e-8)


def test_a_model_comes_back_from_its_file(model: ReducedModel, tmp_path: Path) -> None:
    path = tmp_path / "wing.npz"
    model.save(path)
    again = ReducedModel.load_file(path)
    states = random_states(5)
    assert np.array_equal(again.solve(states), model.solve(states))
    assert np.array_equal(again.error_bound(states), model.error_bound(states))
    assert again.provenance == model.provenance and again.provenance["wing"]
    assert again.parameters == ("mu1", "mu2") and again.outputs == model.outputs
    assert [p.name for p in tmp_path.iterdir()] == ["wing.npz"]


def test_bad_files_states_and_settings_get_a_sentence(model: ReducedModel, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"ends in '.bin'; expected .npz"):
        model.save(tmp_path / "wing.bin")
    (tmp_path / "wing.npz").write_text("nothing")
    with pytest.raises(InputError, match=r"wing.npz is not a reduced model"):
        ReducedModel.load_file(tmp_path / "wing.npz")
    with pytest.raises(InputError, match="state 0 has mu1 = 1; expected a loss of stiffness"):
        model.solve(np.array([[1.0, 0.0]]))
    with pytest.raises(InputError, match=r"tolerance 2\.0"):
        ReductionSettings(tolerance=2.0)
    with pytest.raises(InputError, match=r"reduced model load has shape \(1,\)"):
        replace(model, load=np.zeros(1))
