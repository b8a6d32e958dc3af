"""Frequencies of the reduced model lie above the full model's, and the bounds below."""

import numpy as np
import pytest

from femlib.errors import InputError
from femlib.rom import ReducedModes, reduce_modes
from femlib.wing import Wing, mass_matrix, vibrate

STATES = np.array([[0.3, 0.9], [0.97, 0.2]])
N_MODES = 2


@pytest.fixture(scope="module")
def truth(tiny: Wing) -> np.ndarray:
    """Frequencies (n_states, n_modes) by the full model."""
    states = [dict(zip(tiny.parameters, row, strict=True)) for row in STATES.tolist()]
    return np.array([[mode.frequency for mode in vibrate(tiny, state, N_MODES)] for state in states])


@pytest.fixture(scope="module")
def model(tiny: Wing) -> ReducedModes:
    return reduce_modes(tiny.structure, mass_matrix(tiny), N_MODES, n_joint=0)


def test_the_full_models_frequencies_lie_between_the_bounds(model: ReducedModes, truth: np.ndarray) -> None:
    above, below = model.frequencies(STATES), model.lower_bounds(STATES)
    assert (below <= truth * (1.0 + 1e-8)).all()
    assert (truth <= above * (1.0 + 1e-8)).all()
    assert above == pytest.approx(truth, rel=1e-4)
    assert below[0] == pytest.approx(truth[0], rel=1e-3)


@pytest.mark.long
def test_a_poor_basis_is_still_bounded(tiny: Wing, truth: np.ndarray) -> None:
    poor = reduce_modes(tiny.structure, mass_matrix(tiny), N_MODES, tolerance=0.3, n_joint=0)
    above, below = poor.frequencies(STATES), poor.lower_bounds(STATES)
    assert (above / truth).max() > 1.0 + 1e-4
    assert (below <= truth * (1.0 + 1e-8)).all()
    assert (truth <= above * (1.0 + 1e-8)).all()


def test_shapes_are_modes_of_the_full_model(tiny: Wing, model: ReducedModes) -> None:
    shapes, mass = model.shapes(STATES[0]), mass_matrix(tiny)
    assert shapes @ (mass @ shapes.T) == pytest.approx(np.eye(N_MODES), abs=1e-8)
    full = vibrate(tiny, {"mu1": 0.3, "mu2": 0.9}, 1)[0].shape
    assert abs(shapes[0] @ (mass @ full)) == pytest.approx(1.0, abs=1e-4)


def test_wrong_requests_get_their_sentence(tiny: Wing, model: ReducedModes) -> None:
    with pytest.raises(InputError, match="expected a loss of stiffness from 0 to below 1"):
        model.frequencies(np.array([[1.0, 0.0]]))
    with pytest.raises(InputError, match="n_joint -1"):
        reduce_modes(tiny.structure, mass_matrix(tiny), n_joint=-1)
