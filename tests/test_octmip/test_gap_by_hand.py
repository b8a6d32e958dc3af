"""The small formulas of evidence, noise and outliers, each against its definition or a value worked by hand."""

import dataclasses
import itertools
import math
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import log_ndtr
from scipy.stats import multivariate_normal, norm, truncnorm

from octmip.errors import DataError
from octmip.gap import CHAIN
from octmip.gap.campaign.campaign import Cell, Fault
from octmip.gap.campaign.display import left_by, levels_of, step_of, steps_of
from octmip.gap.campaign.noise import JUMP_SD, Noise, NoisePart, given_noise, least_moment
from octmip.gap.campaign.noise_estimate import _moderated, _scales, _Scatter
from octmip.gap.campaign.spectrum import WHITE
from octmip.gap.channels.outliers import _far, _is_skewed, _scale
from octmip.gap.inference.candidates import SCALES, Priors
from octmip.gap.inference.confounding import _distances, conditional_gram
from octmip.gap.inference.evidence import _between, alike, extensions, fits_of, log_between
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import linearise
from tests.test_octmip.beam_twin import Beam, measured


def priors(mean=(0.0,), sd=(2.0,), low=-np.inf, high=np.inf, is_discrete=(False,)):
    n = len(mean)
    bounds = np.array([[low] * n, [high] * n])
    return Priors(np.array(mean), np.array(sd), bounds, np.array(is_discrete), np.zeros(n), np.arange(n), n)


@pytest.mark.parametrize(("low", "high"), [(-1.0, 3.0), (0.5, np.inf), (-np.inf, -2.0), (3.0, 4.0), (-6.0, -5.0)])
def test_the_share_between_bounds_and_what_it_leaves_are_those_of_a_cut_normal(low, high):
    mean, sd, bounds = np.array(0.5), np.array(1.5), np.array([low, high])
    ends = (low - 0.5) / 1.5, (high - 0.5) / 1.5
    assert log_between(mean, sd, bounds) == pytest.approx(np.log(norm.cdf(ends[1]) - norm.cdf(ends[0])), rel=1e-9)
    cut = truncnorm(*ends, loc=0.5, scale=1.5)
    size, spread = _between(mean, sd, bounds)
    assert float(size) == pytest.approx(cut.mean(), rel=1e-6)
    assert float(spread) == pytest.approx(cut.std(), rel=1e-5)


def test_evidence_of_one_size_is_the_mean_of_three_gaussians():
    gram, gain, sd = 0.7, 1.9, 2.0
    own = [0.5 * (gain**2 / (gram + (s * sd) ** -2) - np.log1p(gram * (s * sd) ** 2)) for s in SCALES]
    (fit,) = fits_of(priors(), [(0,)], np.array([[[gram]]]), np.array([[gain]]))
    assert fit.log_factor == pytest.approx(np.logaddexp.reduce(own) - np.log(3.0))
    share = np.exp(own) / np.exp(own).sum()
    sizes = np.array([gain / (gram + (s * sd) ** -2) for s in SCALES])
    assert fit.size[0] == pytest.approx(share @ sizes)
    spread = share @ (sizes**2 + [1.0 / (gram + (s * sd) ** -2) for s in SCALES]) - (share @ sizes) ** 2
    assert fit.covariance[0, 0] == pytest.approx(spread)


def test_a_size_of_one_side_has_the_evidence_the_mean_and_the_variance_of_its_integral():
    size = np.linspace(0.0, 60.0, 400_001)
    density = np.mean([2.0 * norm.pdf(size, scale=2.0 * s) for s in SCALES], axis=0)
    (fit,) = fits_of(priors(low=0.0), [(0,)], np.array([[[0.7]]]), np.array([[-0.4]]))
    weight = np.exp(-0.4 * size - 0.35 * size**2) * density
    integral, first, second = (np.trapezoid(weight * size**power, size) for power in range(3))
    assert fit.log_factor == pytest.approx(np.log(integral), abs=1e-6)
    assert fit.size[0] == pytest.approx(first / integral, rel=1e-6)
    assert fit.covariance[0, 0] == pytest.approx(second / integral - (first / integral) ** 2, rel=1e-6)


def test_a_discrete_effect_has_one_scale_and_shares_its_group_with_its_like():
    prior = priors((1.0, 0.0, 1.0), (0.1, 2.0, 0.1), is_discrete=(True, False, True))
    assert alike(prior, [(0,), (1,), (2,), (0, 1), (1, 2)]) == [[(0,), (2,)], [(1,)], [(0, 1)], [(1, 2)]]
    (fit,) = fits_of(prior, [(0,)], np.array([[[0.7]]]), np.array([[1.9]]))
    eta, precision = 1.0 / 0.1**2 + 1.9, 0.7 + 0.1**-2
    assert fit.log_factor == pytest.approx(0.5 * (eta**2 / precision - 1.0 / 0.1**2 - np.log(precision * 0.1**2)))


@pytest.mark.parametrize(
    ("one", "other"),
    [([1, 2, 3], [4, 6]), ([4, 6], [1, 2, 3]), ([1, 4, 5], [2, 3, 7]), ([2, 2], [2, 2]), ([1, 9], [3])],
)
def test_what_a_walk_shares_between_two_averages_is_the_mean_of_the_earlier_moments(one, other):
    pairs = [min(s, t) for s, t in itertools.product(one, other)]
    assert least_moment(np.array(one, float), np.array(other, float)) == pytest.approx(np.mean(pairs))


def test_means_of_white_noise_have_its_variance_over_their_repeats():
    noise = given_noise(("a", "b"), {"a": 2.0, "b": 3.0})
    assert noise.of_mean(np.array([4, 9]), 1.0) == pytest.approx(np.diag([1.0, 1.0]))
    shared = Noise(("a", "b"), (NoisePart(np.array([[4.0, 1.0], [1.0, 9.0]]), WHITE),), scale={2.0: 3.0})
    assert shared.of_mean(np.array([4, 2]), 1.0)[0, 1] == pytest.approx(1.0 / 4)  # two readings of four are of both
    assert shared.of_mean(np.array([4, 4]), 2.0)[0, 0] == pytest.approx(3.0)
    for wrong in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(DataError, match="expected a positive number"):
            given_noise(("a",), wrong)


def test_the_offset_of_a_jump_acts_from_its_first_row_on():
    noise = Noise(
        ("a", "b"), (NoisePart(np.diag([4.0, 9.0]), WHITE),), faults=(Fault("jump", "b", np.zeros(0, int), "", 1.0, 3),)
    )
    rows = [np.array([0, 1, 2]), np.array([2, 3]), np.array([3, 4])]
    zero = np.zeros(2)
    cells = [Cell("T", 1.0, zero, r, zero, np.full(2, len(r)), 0.0, r + 1.0, k) for k, r in enumerate(rows)]
    at = [cells, np.array([0, 1, 2, 2]), np.array([1, 1, 1, 0])]
    assert noise.of_jumps(*at) == pytest.approx(JUMP_SD**2 * 9.0 * np.outer([0.0, 0.5, 1.0, 0.0], [0.0, 0.5, 1.0, 0.0]))


@pytest.mark.parametrize(
    ("readings", "step"),
    [
        ([0.0, 0.5, 1.5, -2.0], 0.5),
        ([0.0, 0.5], 0.0),  # two values are multiples of whatever lies between them
        ([0.0, 0.5, 1.25], 0.25),
        ([0.0, 0.0, 0.0], 0.0),
        (np.round(np.array([3, 5, 6, 8, 11, 12, 17]) * 0.3052, 3), 0.3052),  # counts of a converter, in printed mm
        (np.random.default_rng(0).standard_normal(50), 0.0),
        ([1e3, 1e3 + 0.25, np.nan, 1e3 + 1.0], 0.25),
    ],
)
def test_a_step_is_what_all_readings_are_whole_multiples_of(readings, step):
    assert step_of(levels_of(np.array(readings))) == pytest.approx(step, rel=1e-3)


@pytest.mark.parametrize(("others", "own"), [(1.0, 600.0), (100.0, 100.0)])
def test_a_gauge_that_never_scatters_has_the_step_of_the_others_unless_that_would_show(others, own):
    campaign = measured(0)  # noise of 31.6
    readings = np.round(campaign.readings / others) * others
    readings[:, 6] = np.repeat([0.0, 600.0, 1200.0, 2400.0], 50)
    steps = steps_of(dataclasses.replace(campaign, readings=readings))
    assert steps == pytest.approx(np.where(np.arange(20) == 6, own, others))


def test_variances_are_drawn_to_their_middle_and_equal_ones_become_one():
    degrees = np.full(6, 4.0)
    assert np.ptp(_moderated(np.array([0.8, 1.0, 1.2, 0.9, 1.1, 1.0]), degrees)) == 0.0
    own = np.array([1e-2, 0.1, 1.0, 1.0, 10.0, 1e2])
    drawn = _moderated(own, degrees)
    assert (np.diff(drawn) >= 0.0).all()
    assert 1.0 < drawn[-1] / drawn[0] < own[-1] / own[0]
    assert _moderated(own[:2], degrees[:2]) == pytest.approx(
        2.0 * own[:2]
    )  # two gauges say nothing of all: d / (d - 2)


def test_a_step_leaves_in_means_what_their_repeats_do_not_show():
    """Repeats of normal noise about values all over a step, rounded: the definition, drawn."""
    rng, n = np.random.default_rng(0), 6
    for ratio in (0.0, 0.1, 0.25, 0.4, 1.0):
        value = rng.uniform(-0.5, 0.5, 100_000)[:, None]
        shown = np.round(value + ratio * rng.standard_normal((100_000, n)))
        seen, whole = float(shown.var(axis=1, ddof=1).mean()), float(((shown.mean(axis=1) - value[:, 0]) ** 2).mean())
        left = float(left_by(np.array([3.0]), np.array([9.0 * seen]))[0]) / 9.0
        assert left == pytest.approx(whole - seen / n, abs=2e-3)
    assert left_by(np.zeros(2), np.array([0.0, 1.0])).tolist() == [0.0, 0.0]


def test_only_a_load_that_scatters_otherwise_has_a_scale_of_its_own():
    rng, loads = np.random.default_rng(0), (1.0, 2.0, 3.0)
    blocks = tuple(sd * rng.standard_normal((50, 20)) for sd in (1.0, 1.0, 2.0))
    every, ones = np.ones(20, dtype=bool), np.ones(20)
    scale = _scales(_Scatter((), loads, blocks, ones, ones, 147.0 * ones, every, 0.0 * ones, 0.0 * ones), 1.0)
    assert [scale[load] for load in (1.0, 2.0, 3.0)] == pytest.approx([0.5, 0.5, 2.0], rel=0.1)
    alike_blocks = tuple(block / sd for block, sd in zip(blocks, (1.0, 1.0, 2.0), strict=True))
    same = _scales(_Scatter((), loads, alike_blocks, ones, ones, 147.0 * ones, every, 0.0 * ones, 0.0 * ones), 1.0)
    assert set(same.values()) == {1.0}


def test_a_far_reading_is_far_from_its_neighbours_too():
    residual = np.random.default_rng(0).standard_normal((40, 2))
    residual[7, 0], residual[20:, 1] = -9.0, 9.0  # an outlier, and a gauge that has jumped
    far = _far(residual, np.zeros(40, dtype=np.int64))
    assert np.argwhere(far).tolist() == [[7, 0]]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_noise_leans_where_its_body_and_not_its_far_readings_lie_to_one_side(sign):
    body, far = np.concatenate([np.full(30, 3.0), np.full(10, -3.0)]), np.full(30, 6.0)
    assert _is_skewed(sign * body)
    assert not _is_skewed(sign * np.concatenate([body[10:30], body[30:], body[30:], far]))
    assert not _is_skewed(sign * np.full(8, 3.0))  # eight could be chance


def test_a_cell_that_scatters_three_times_as_much_has_three_times_the_scale():
    rng = np.random.default_rng(0)
    values = rng.standard_normal((3000, 4))
    values[2000:] *= 3.0
    found = _scale(values, np.repeat([0, 1, 2], 1000))
    assert found[[0, 1000, 2000]] == pytest.approx([1.0, 1.0, 3.0], rel=0.1)


def test_a_gauge_whose_readings_never_change_has_cells_of_one_scale():
    cell_of = np.repeat([0, 1], 4)
    values = np.full((8, 2), 3.0)
    assert np.array_equal(_scale(values, cell_of), np.ones(8))


def test_the_share_beyond_a_far_bound_keeps_its_logarithm():
    above = np.array([[0.0], [math.inf]])
    below = np.array([[-math.inf], [0.0]])
    for sd in (1.0, 3.0):
        expected = pytest.approx(float(log_ndtr(-40.0)), rel=1e-12)
        assert log_between(np.array([-40.0 * sd]), np.array([sd]), above)[0] == expected
        assert log_between(np.array([40.0 * sd]), np.array([sd]), below)[0] == expected


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
