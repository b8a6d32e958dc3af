"""A large effect whose signature is not quite the library's: its name is right, and nothing else is dragged in."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from octmip.gap import CHAIN, diagnose
from octmip.gap.inference.candidates import SCALES
from octmip.gap.inference.inference import LEVELS, Inference
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import linearise
from octmip.gap.inference.posterior import log_prior
from octmip.gap.preparation import library_of
from tests.test_octmip.beam_twin import ETA, Asset, Beam, Bumps, Field, measured

COMMISSIONING = measured(1000)
SHAPE = -2.5 - 4.0 * np.linspace(-1, 1, 20) ** 2
SOAK = Field("soak", SHAPE, 1, 10.0, signature_error=0.03)
"""A field that the model knows to 3 % at each gauge."""


def twin_with(effect):
    return Beam(effects={**Beam().effects, effect.name: effect})


def inference_of(twin, campaign):
    inputs, _ = prepare(campaign, twin, {**CHAIN, **twin.effects}, COMMISSIONING)
    return Inference(linearise(inputs, np.array([cell.state for cell in campaign.cells])))


def candidate(model, name):
    return next(k for k, c in enumerate(model.inputs.candidates) if c.name == name)


OFF = SHAPE * (1.0 + 0.05 * np.random.default_rng(6).standard_normal(20))
SOAKED = measured(3, lambda state, load, time: 40.0 * load * OFF)


def test_the_model_that_allows_for_errors_of_signatures_has_the_dense_gaussian_density():
    inference = inference_of(twin_with(SOAK), SOAKED)
    model = inference.model
    j = candidate(model, "soak")
    error = inference.errors((j,))
    assert error is not None
    dense = multivariate_normal.logpdf(model.residual, cov=model.covariance + error)
    allowing = inference.allowing((j,)).model
    assert allowing.log_none - allowing.given.log_run == pytest.approx(dense, abs=1e-6)


def test_an_error_of_a_signature_is_a_share_of_it_at_each_gauge_and_grows_with_the_size():
    inference = inference_of(twin_with(SOAK), SOAKED)
    model = inference.model
    j = candidate(model, "soak")
    error, own = inference.errors((j,)), inference.fit((j,))
    last = model.loads.index(3.0)  # the constant course, along the load, bent over it: 1 + 1 + 1
    other = model.loads.index(3.0, last + 1)
    at = 0.03 * own.level * float(own.size[0]) * model.signatures[:, j]
    assert error[last, last] == pytest.approx(5.0 * at[last] ** 2)  # two of these also of the kind as a whole
    alike = model.inputs.difference.smooth[model.gauge[last], model.gauge[other]]
    assert error[last, other] == pytest.approx((2.0 + 1.5 * alike) * at[last] * at[other])  # half of it is smooth


def test_where_a_signature_changes_its_sign_it_is_no_better_known_than_beside():
    turning = replace(SOAK, name="turn", shape=np.linspace(-5.0, 5.0, 21)[:-1])  # 0 at the tenth gauge
    inference = inference_of(twin_with(turning), SOAKED)
    model = inference.model
    error = np.diag(inference.error_of(candidate(model, "turn"), 10.0)).reshape(-1, 20)[-1]
    assert model.signatures[:, candidate(model, "turn")].reshape(-1, 20)[-1, 10] == pytest.approx(0.0, abs=0.2)
    assert error[10] > 0.05 * error[0]


def test_a_member_that_is_no_more_than_the_error_of_a_large_one_leaves_its_set():
    other = Field("dent", np.eye(20)[4], 1, 10.0)
    beside = measured(3, lambda state, load, time: load * (120.0 * SHAPE + 9.0 * np.eye(20)[4]))
    twin = Beam(effects={**Beam().effects, "soak": SOAK, "dent": other})
    inference = inference_of(twin, beside)
    both = tuple(sorted((candidate(inference.model, "soak"), candidate(inference.model, "dent"))))
    assert inference.identifiable(both) == (candidate(inference.model, "soak"),)
    sure = Beam(effects={**Beam().effects, "soak": replace(SOAK, signature_error=0.0), "dent": other})
    assert len(inference_of(sure, beside).identifiable(both)) == 2


def test_an_offset_of_all_gauges_is_named_with_the_field_that_may_be_as_even():
    shape, even = 4.0 + 0.4 * np.sin(np.arange(20.0)), measured(3, lambda state, load, time: 40.0)
    for error in (0.1, 0.0):
        warm = Field("warm", shape, 0, 10.0, signature_error=error)
        first = diagnose(even, Beam(effects={"warm": warm}), commissioning=COMMISSIONING).which[0]
        assert "unit_steady_constant" in first.names[0]
        assert ("warm" in first.names[0]) == (error > 0.0)


def test_two_cells_without_names_are_no_explanation():
    inputs, _ = prepare(SOAKED, Beam(), library_of(Beam(), SOAKED), COMMISSIONING)
    nameless = [k for k, one in enumerate(inputs.candidates) if one.is_nameless]
    named = next(k for k, one in enumerate(inputs.candidates) if one.name == "gauge_gain")
    assert np.isfinite(log_prior(inputs, (named, nameless[0])))
    assert log_prior(inputs, tuple(nameless[:2])) == -np.inf


def test_levels_of_errors_are_summed_like_the_density_at_every_level():
    inference = inference_of(twin_with(SOAK), SOAKED)
    model = inference.model
    j = candidate(model, "soak")
    column, sd = model.signatures[:, j], model.inputs.priors.sd[j]
    size = inference.plain([(j,)])[0].size  # what the errors are as large as
    logs, weights = [], []
    for level, share in LEVELS.items():
        error = inference._errors((j,), size, level)[0]
        assert (error is None) == (level == 0.0)
        error = np.zeros((model.n, model.n)) if error is None else error
        for scale in SCALES:
            covariance = model.covariance + error + (scale * sd) ** 2 * np.outer(column, column)
            logs.append(multivariate_normal.logpdf(model.residual, cov=covariance))
            weights.append(share / len(SCALES))
    found = (model.log_none - model.given.log_run) + inference._over_levels([(j,)])[0].log_factor
    assert found == pytest.approx(logsumexp(logs, b=weights), abs=1e-6)


def test_errors_count_from_an_effect_that_stands_out_on():
    sound = measured(3)
    faint, large = (inference_of(twin_with(SOAK), one) for one in (sound, SOAKED))
    for inference, counts in ((faint, False), (large, True)):
        j = (candidate(inference.model, "soak"),)
        assert (inference.fit(j).log_factor != inference.plain([j])[0].log_factor) == counts
        assert inference.is_idle(j) != counts
        assert inference.identifiable(j) == (j if counts else ())


@pytest.mark.parametrize("knows", [True, False])
def test_a_shape_that_is_three_per_cent_off_drags_no_partner_in_when_its_error_is_known(knows):
    off = SHAPE * (1.0 + (0.03 if knows else 0.1) * np.random.default_rng(6).standard_normal(20))
    campaign = measured(3, lambda state, load, time: 40.0 * load * off)
    known = twin_with(replace(SOAK, signature_error=0.03 * knows))
    first = diagnose(campaign, known, commissioning=COMMISSIONING).which[0]
    assert (first.effects == ("soak",)) == knows


def test_an_effect_between_two_of_its_places_is_one_effect():
    twin = twin_with(Bumps("bump", ETA, 1, 40.0))
    campaign = measured(3, lambda state, load, time: 60.0 * Bumps.at(0.4, load))
    which = diagnose(campaign, twin, commissioning=COMMISSIONING).which
    assert (which[0].effects, which[0].probability > 0.9) == (("bump",), True)
    assert which[0].effects not in [cause.effects for cause in which[1:]]  # nor are two neighbouring places another


def test_what_a_swapped_pair_shows_of_another_effect_is_exchanged_too():
    def change(state, load, time):
        both = Asset().predict(state, load) + 12.0 * load * SHAPE
        both[[2, 15]] = both[[15, 2]]
        return both - Asset().predict(state, load)

    twin = twin_with(Field("soak", SHAPE, 1, 10.0))
    first = diagnose(measured(3, change), twin, commissioning=COMMISSIONING).which[0]
    assert set(first.effects) == {"soak", "swapped_pair"}
    assert {p.place for p in first.parameters} == {"", "g03/g16"}


class Lagging(Field):
    """A field that comes with the square root of the time under load."""

    uses_time = True
    superposes = True

    def signature(self, twin, state, load_factor, place="", time=0.0):
        return load_factor * (max(time, 0.0) / 3600.0) ** 0.5 * self.shape


def test_an_effect_that_superposes_answers_each_step_of_the_load_from_its_own_time_on():
    twin = twin_with(Lagging("lag", SHAPE, 1, 10.0))
    model = inference_of(twin, measured(3, loads=(2.0, 0.0, 3.0))).model
    signature = model.signatures[:, candidate(model, "lag")]
    last = model.average == len(model.inputs.averages) - 1
    time = model.inputs.averages[-1].time
    lags = [(2.0, time), (-2.0, time - 300.0), (3.0, time - 600.0)]  # 50 readings a load, 6 s each
    expected = sum(step * (lag / 3600.0) ** 0.5 for step, lag in lags) * SHAPE
    assert np.allclose(signature[last], expected, rtol=0.05)  # as much as asset and twin differ by
