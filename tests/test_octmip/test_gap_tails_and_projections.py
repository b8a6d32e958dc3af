"""The evidence in its tails and under bounds, and what is left of a signature beside others, by other arithmetic."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import log_ndtr

from octmip.gap.inference.confounding import _distances, conditional_gram
from octmip.gap.inference.evidence import _gaussians, log_between
from tests.test_octmip.test_gap_evidence import inference_of


def test_the_share_beyond_a_far_bound_keeps_its_logarithm():
    above = np.array([[0.0], [math.inf]])
    below = np.array([[-math.inf], [0.0]])
    for sd in (1.0, 3.0):
        expected = pytest.approx(float(log_ndtr(-40.0)), rel=1e-12)
        assert log_between(np.array([-40.0 * sd]), np.array([sd]), above)[0] == expected
        assert log_between(np.array([40.0 * sd]), np.array([sd]), below)[0] == expected


def test_a_size_that_cannot_be_negative_has_the_variance_of_half_a_normal():
    one = np.ones((1, 1))
    bounds = np.array([[[0.0]], [[math.inf]]])
    _, size, covariance = _gaussians(one[None], 0 * one, 0 * one, one, bounds)
    assert size[0, 0] == pytest.approx(math.sqrt(0.5 * 2 / math.pi))
    assert covariance[0, 0, 0] == pytest.approx(0.5 * (1 - 2 / math.pi))


def test_what_is_left_of_a_signature_beside_another_is_a_residual_of_least_squares():
    model = inference_of(3).model
    signatures, sd = model.white, model.inputs.priors.sd
    member, other = np.argsort(-np.abs(signatures.T @ signatures[:, 0]))[:2].tolist()
    rows = np.append(signatures[:, other], 1 / (3 * sd[other]))
    share = np.linalg.lstsq(rows[:, None], np.append(signatures[:, member], 0.0), rcond=None)[0][0]
    left = signatures[:, member] - share * signatures[:, other]
    cross, _ = conditional_gram(model, (other,), member)
    assert cross == pytest.approx(signatures.T @ left, rel=1e-6, abs=1e-9 * np.abs(signatures.T @ left).max())
    assert np.abs(cross - signatures.T @ signatures[:, member]).max() > 0.01 * np.abs(cross).max()


def test_no_effect_imitates_another_with_a_sign_that_it_cannot_have():
    bounds = np.array([[-math.inf, 0.0], [math.inf, math.inf]])
    priors = SimpleNamespace(is_discrete=np.zeros(2, bool), mean=np.zeros(2), sd=np.ones(2), bounds=bounds)
    model = SimpleNamespace(inputs=SimpleNamespace(priors=priors))
    distances, needed = _distances(model, (np.array([1.0, -0.9]), np.ones(2)), 0, 1.0)
    assert needed[1] == 0.0
    assert distances[1] == 1.0
