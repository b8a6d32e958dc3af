"""The linear model is read only, an inference keeps what it was asked, and the next test goes by what is seen."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from octmip.errors import DataError, TwinError
from octmip.gap import CHAIN, CachedTwin, diagnose
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import linearise
from tests.test_octmip.beam_twin import Beam, measured

TWIN = Beam()
COMMISSIONING = measured(1000)
SETS = [(), (0,), (3, 40), (21,), (2, 30, 60)]


@pytest.fixture(scope="module")
def model():
    campaign = measured(3, lambda state, load, time: np.full(20, -25.0))
    inputs, _ = prepare(campaign, TWIN, {**CHAIN, **TWIN.effects}, COMMISSIONING)
    return linearise(inputs, np.array([cell.state for cell in campaign.cells]))


def test_nothing_of_a_linear_model_can_be_written(model):
    with pytest.raises(FrozenInstanceError):
        model.residual = model.residual
    for array in (model.states, model.residual, model.covariance, model.signatures, model.white):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_an_answer_does_not_hang_on_what_was_asked_before(model):
    asked = Inference(model)
    asked.fits(SETS)
    asked.allowing(SETS[2])
    for members in reversed(SETS):
        fresh = Inference(model)
        one, other = asked.fit(members), fresh.fit(members)
        assert one.log_factor == pytest.approx(other.log_factor, rel=1e-9, abs=1e-9)
        assert np.allclose(one.size, other.size, rtol=1e-9)
        assert asked.identifiable(members) == fresh.identifiable(members)
        assert asked.fit(members) is one
        assert asked.allowing(members) is asked.allowing(members)


def test_an_inference_allows_for_nothing_by_itself(model):
    inference = Inference(model)
    assert inference.allowing(()) is inference


@pytest.mark.parametrize("quantities", [("deflection",), ("thermal_zero", "frequency"), ()])
def test_tests_are_proposed_for_what_shows_an_effect_whatever_its_name(quantities):
    softer = replace(TWIN.effects["modulus"], name="wet_wood", seen_by=quantities)
    hidden = {name: CHAIN[name] for name in ("load_factor_error", "common_gain")}
    change = 2.0 * softer.shape

    campaign = measured(5, lambda state, load, time: change * TWIN.predict(state, load))
    found = diagnose(campaign, TWIN, {**hidden, softer.name: softer}, commissioning=COMMISSIONING)
    proposed = {test.name for test in found.next_test if not test.is_strain_test}
    by_quantity = {"deflection": "tip_deflection", "thermal_zero": "thermal_soak", "frequency": "frequency"}
    assert proposed == {"load_cell", "shunt_calibration", *(by_quantity[q] for q in quantities)}


def test_a_twin_is_asked_once_for_each_state_and_load():
    class Counted(Beam):
        asked = 0

        def predict(self, state, load_factor):
            self.asked += 1
            return super().predict(state, load_factor)

    counted = Counted()
    cached = CachedTwin(counted)
    first = cached.predict({"mu1": 0.2, "mu2": 0.0}, 2.0)
    assert cached.predict({"mu1": 0.2}, 2.0) is first
    assert counted.asked == 1
    assert np.array_equal(cached.predict_states(np.array([[0.2, 0.0], [0.3, 0.0]]), 2.0)[0], first)
    assert counted.asked == 2


class Loaded(Beam):
    """A twin that refuses to be without load."""

    def predict(self, state, load_factor):
        if load_factor == 0:
            raise TwinError("the load is 0")
        return super().predict(state, load_factor)


@pytest.mark.parametrize(
    ("twin", "limits", "proposed"),
    [
        (Beam(), None, {"load_0", "load_3", "load_-1"}),
        (Loaded(), None, {"load_3", "load_-1"}),
        (Beam(), (0.0, 2.5), {"load_0", "load_2.5"}),
        (Beam(), (0.5, 2.0), set()),
    ],
)
def test_no_load_beyond_the_limits_is_proposed(twin, limits, proposed):
    gain = lambda state, load, time: 0.06 * (np.arange(20) == 4) * Beam().predict(state, load)  # noqa: E731
    found = diagnose(
        measured(21, gain, loads=(2.0,)), twin, commissioning=measured(1000, loads=(2.0,)), load_limits=limits
    )
    assert {test.name for test in found.next_test if test.is_strain_test} == proposed
    assert any("if the structure allows it" in test.words for test in found.next_test) == (limits is None)


def test_limits_of_the_load_in_the_wrong_order_are_refused():
    with pytest.raises(DataError, match="the lowest first"):
        diagnose(measured(21, loads=(2.0,)), Beam(), commissioning=COMMISSIONING, load_limits=(3.5, -1.0))


@pytest.mark.parametrize("level", [0.5, 4.0])
def test_columns_are_good_for_every_level(level):
    campaign = measured(3, states=((0.4, 0.2),))  # how wrong a damage is known depends on the level
    inputs, _ = prepare(campaign, TWIN, {**CHAIN, **TWIN.effects}, COMMISSIONING)
    states = np.array([cell.state for cell in campaign.cells])
    usual, made = linearise(inputs, states), linearise(inputs, states, level)
    moved = usual.under(level)
    assert moved.log_none == pytest.approx(made.log_none, abs=1e-9)
    assert np.allclose(moved.residual, made.residual)
    assert moved.log_none != pytest.approx(linearise(inputs, states).log_none, abs=1e-3)


def test_a_covariance_that_is_added_has_the_dense_gaussian_density(model):
    root = np.random.default_rng(0).standard_normal((model.n, 3))
    under = model.with_covariance(root @ root.T)
    dense = multivariate_normal.logpdf(model.residual, cov=model.covariance + root @ root.T)
    assert under.log_none - under.given.log_run == pytest.approx(dense, abs=1e-6)
