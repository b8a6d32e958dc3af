"""The closed-form evidence against two independent integrators, and against the dense Gaussian density."""

from functools import cache

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from octmip.gap import CHAIN
from octmip.gap.inference.candidates import SCALES
from octmip.gap.inference.evidence import extensions
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import linearise
from tests.test_octmip.beam_twin import Beam, measured

TWIN = Beam()
EFFECTS = {**CHAIN, **TWIN.effects}
del EFFECTS["swapped_pair"]
COMMISSIONING = measured(1000)


@cache
def inference_of(seed, size=2.0, sd=120.0):
    """A noisy campaign with a weak effect: evidences of a few nats, which nested sampling finds exactly and fast."""

    def change(state, load, time):
        return size * TWIN.effects["temperature_uniform"].signature(TWIN, state, load)

    campaign = measured(seed, change, sd=sd, loads=(0.0, 2.0))
    inputs, _ = prepare(campaign, TWIN, EFFECTS, COMMISSIONING)
    return Inference(linearise(inputs, np.array([cell.state for cell in campaign.cells])))


def candidate(inference, name, place=""):
    candidates = inference.model.inputs.candidates
    return next(j for j, c in enumerate(candidates) if (c.name, c.place) == (name, place))


ALONE = [
    ("temperature_uniform", ""),
    ("modulus", ""),
    ("gauge_bias", "g04"),
    ("gauge_gain", "g02"),
    ("misalignment", "g02"),
    ("temperature_gradient", ""),
    ("lift_distribution", ""),
]


@pytest.mark.parametrize("chosen", ALONE, ids=[name for name, _ in ALONE])
def test_evidence_of_one_effect_equals_its_integral_within_a_tenth(chosen):
    inference = inference_of(3)
    member = candidate(inference, *chosen)
    effect, model = inference.model.inputs.candidates[member].effect, inference.model
    size = effect.prior_sd * np.linspace(0.0 if effect.is_one_sided else -30.0, 30.0, 200_001)
    density = np.mean([norm.pdf(size, scale=scale * effect.prior_sd) for scale in SCALES], axis=0)
    log_likelihood = model.projection[member] * size - 0.5 * model.gram_rows([member])[0, member] * size**2
    most = float(log_likelihood.max())
    integral = np.trapezoid(np.exp(log_likelihood - most) * density, size) * (2.0 if effect.is_one_sided else 1.0)
    assert inference.fit([member]).log_factor == pytest.approx(most + float(np.log(integral)), abs=0.1)


@pytest.mark.parametrize("seed", range(3))
def test_evidence_equals_the_dense_gaussian_density(seed):
    inference = inference_of(seed)
    model = inference.model
    members = [
        candidate(inference, "temperature_uniform"),
        candidate(inference, "gauge_bias", "g04"),
        candidate(inference, "gauge_gain", "g02"),
    ]
    columns = model.signatures[:, members]
    sd = np.array([model.inputs.candidates[j].effect.prior_sd for j in members])
    logs = []
    for a in SCALES:
        for b in SCALES:
            for c in SCALES:
                covariance = model.covariance + columns @ np.diag((sd * [a, b, c]) ** 2) @ columns.T
                logs.append(multivariate_normal.logpdf(model.residual, cov=covariance))
    dense = float(np.logaddexp.reduce(logs)) - np.log(27)
    assert (model.log_none - model.given.log_run) + inference.fit(members).log_factor == pytest.approx(dense, abs=1e-6)
    none = multivariate_normal.logpdf(model.residual, cov=model.covariance)
    assert (model.log_none - model.given.log_run) == pytest.approx(none, abs=1e-6)


def test_the_quick_extension_of_nothing_is_the_exact_evidence_of_every_single_candidate():
    inference = inference_of(1)
    quick, new = extensions(inference.model, ())
    assert np.allclose(new, 1.0)
    exact = [inference.fit([j]).log_factor for j in range(len(quick))]
    assert np.allclose(quick, exact, atol=1e-8)


def test_the_quick_extension_of_a_set_is_the_evidence_of_one_more_column_of_a_covariance():
    inference = inference_of(1)
    model = inference.model
    held, more = candidate(inference, "temperature_uniform"), candidate(inference, "gauge_gain", "g02")
    effects = [model.inputs.candidates[j].effect for j in (held, more)]
    held_columns = np.outer(*[effects[0].prior_sd * model.white[:, held]] * 2)
    logs = []
    for scale in SCALES:
        own = np.outer(*[scale * effects[1].prior_sd * model.white[:, more]] * 2)
        logs.append(multivariate_normal.logpdf(model.left, cov=np.eye(model.n) + held_columns + own))
    none = multivariate_normal.logpdf(model.left, cov=np.eye(model.n))
    dense = float(np.logaddexp.reduce(logs)) - np.log(3) - none
    quick, new = extensions(model, (held,))
    assert quick[more] == pytest.approx(dense, abs=1e-6)
    assert quick[held] == -np.inf
    assert 0.0 < new[more] <= 1.0
    some, left = extensions(model, (held,), np.array([held, more]))
    assert np.flatnonzero(np.isfinite(some)).tolist() == [more]
    assert (some[more], left[more]) == (pytest.approx(quick[more]), pytest.approx(new[more]))


def test_the_order_of_a_set_does_not_matter():
    inference = inference_of(1)
    one, two = candidate(inference, "temperature_uniform"), candidate(inference, "modulus")
    assert inference.fit([one, two]).log_factor == pytest.approx(inference.fit([two, one]).log_factor, abs=1e-10)
