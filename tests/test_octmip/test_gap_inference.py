"""Numbers of the inference, each beside its definition: states, places, held-out rows, sizes, the next test."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2, norm

from octmip.errors import DataError
from octmip.gap import Differences, Odds, diagnose
from octmip.gap.inference.inference import Inference
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import OPEN_STATE, linearise
from octmip.gap.inference.posterior import attribute
from octmip.gap.inference.signatures import load_steps
from octmip.gap.inference.states import LINES, _changes, grid, joint_covariance, state_posterior
from octmip.gap.location import flips, localise
from octmip.gap.next_test import _answer_entropy, _loads_to_test, _new_settings, _overlap
from octmip.gap.shrinkage import _closed, _held_out, _residuals
from octmip.gap.sizes import _mixture
from octmip.trees.nodes.tree import Leaf, Split
from tests.test_octmip.beam_twin import Beam, Field, measured, own_gains
from tests.test_octmip.test_gap_built import SPRINGS, read, under
from tests.test_octmip.test_gap_loads import shaken


def test_an_unknown_damage_changes_each_load_by_what_the_twin_says():
    twin = Beam()
    inputs = prepare(measured(1, known=False), twin, twin.effects, measured(1000))[0]
    model, nodes = linearise(inputs, np.zeros((4, 2))), np.array([[0.3, 0.0], [0.1, 0.6]])
    rows = np.arange(0, len(model.gauge), 7)
    for node, found in zip(nodes, _changes(model, rows, nodes), strict=True):
        state = dict(zip(twin.parameters, node, strict=True))
        true = [twin.predict(state, model.loads[k]) - twin.predict({}, model.loads[k]) for k in rows]
        gauges = [inputs.order[k] for k in model.gauge[rows]]
        assert found == pytest.approx([row[k] for row, k in zip(true, gauges, strict=True)])


def test_a_set_stands_as_far_from_its_model_as_its_states_move():
    twin = Beam()
    inputs = prepare(measured(1, states=((0.3, 0.1),), known=False), twin, twin.effects, measured(1000))[0]
    start = np.tile([0.2, 0.2], (4, 1))
    inference = Inference(linearise(inputs, start))
    away, log_evidence = inference.stand(())
    moved = inference.moved(())
    assert moved[0] == pytest.approx([0.3, 0.1], abs=0.06)
    assert away == pytest.approx(np.abs(moved - start).max())
    none = inference.model.log_none + inference.log_box(())
    assert (away > 0.04, log_evidence) == (True, pytest.approx(none))


def test_a_set_without_errors_weighs_what_errors_too_small_to_count_leave():
    twin = Beam()
    inputs = prepare(measured(1), twin, twin.effects, measured(1000))[0]
    inference = Inference(linearise(inputs, np.zeros((4, 2))))
    faint = 1e-12 * np.diag(np.diag(inference.model.covariance))
    for one, other in zip(inference._reduced((0, 1), None), inference._reduced((0, 1), faint), strict=True):
        assert one == pytest.approx(other, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("n_exact", [3, 60])
def test_what_has_no_odds_is_never_the_unknown(n_exact, monkeypatch):
    monkeypatch.setattr("octmip.gap.inference.posterior.N_EXACT", n_exact)
    twin = Beam()
    inputs = prepare(measured(1), twin, twin.effects, measured(1000), odds=Odds(unknown=(0.0, 0.0, 0.0)))[0]
    assert attribute(inputs).unknown_probability < 1e-100


def test_open_states_and_sizes_have_their_joint_posterior():
    """The states given the sizes are Gaussian; the spread of the sizes goes on into them."""
    twin = Beam()
    inputs = prepare(measured(1, known=False), twin, twin.effects, measured(1000))[0]
    model = linearise(inputs, np.zeros((4, 2)))
    fit = SimpleNamespace(members=(2, 0), size=np.array([0.4, -1.0]), covariance=np.array([[0.5, 0.1], [0.1, 0.3]]))
    seen, shown = model.tangents, model.signatures[:, [2, 0]]
    noise = np.linalg.inv(model.covariance - OPEN_STATE**2 * seen @ seen.T)
    own = np.linalg.inv(np.eye(seen.shape[1]) / OPEN_STATE**2 + seen.T @ noise @ seen)
    cross = own @ seen.T @ noise @ shown
    joint = np.block(
        [[own + cross @ fit.covariance @ cross.T, -cross @ fit.covariance], [np.zeros((2, 2)), fit.covariance]]
    )
    joint[2:, :2] = joint[:2, 2:].T
    assert joint_covariance(model, fit) == pytest.approx(joint, rel=1e-5, abs=1e-12)
    mean, covariance = state_posterior(model, fit)
    assert covariance == pytest.approx(joint[:2, :2], rel=1e-5)
    assert mean == pytest.approx(own @ seen.T @ noise @ (model.residual - shown @ fit.size), rel=1e-5)


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_a_grid_of_states_has_every_parameter_and_every_pair(n):
    nodes = grid(n)
    assert (
        len(np.unique(nodes, axis=0)) == len(nodes) == (LINES[n] ** n if n in LINES else 1 + 4 * (n + n * (n - 1) // 2))
    )
    assert {tuple(np.flatnonzero(node)) for node in nodes if np.count_nonzero(node) < 3} == {
        (),
        *((a,) for a in range(n)),
        *((a, b) for b in range(n) for a in range(b)),
    }
    assert (nodes.min(), 0.7 <= nodes.max() <= 0.85) == (0.0, True)


class Drifts(Field):
    """A field that goes with time, so that cells are averaged in halves."""

    uses_time = True


def test_where_a_gap_lies_is_as_defined():
    twin = Beam(effects={"drift": Drifts("drift", np.linspace(-2.0, 2.0, 20), 0, 5.0)})
    campaign = measured(1, lambda state, load, time: 30.0 * load * (np.arange(20) == 4), states=((0, 0), (0.2, 0)))
    readings = np.where(np.random.default_rng(2).random(campaign.readings.shape) < 0.2, np.nan, campaign.readings)
    inputs = prepare(replace(campaign, readings=readings), twin, twin.effects, measured(1000))[0]
    model = linearise(inputs, np.array([cell.state for cell in inputs.campaign.cells]))
    where, halves = localise(model, ()), {}
    for row, place in enumerate(zip(model.cells.tolist(), model.gauge.tolist(), strict=True)):
        halves.setdefault(place, []).append(row)
    mix = np.zeros((len(halves), model.n))
    for k, ((_, gauge), rows) in enumerate(halves.items()):
        count = [inputs.averages[model.average[row]].count[gauge] for row in rows]
        mix[k, rows] = np.array(count) / sum(count)
    gap, covariance = mix @ model.residual, mix @ model.covariance @ mix.T
    excess = gap**2 - np.diag(mix @ model.scatter @ mix.T)
    cells = [inputs.campaign.cells[cell] for cell, _ in halves]
    gauges = [inputs.campaign.gauges[gauge] for _, gauge in halves]
    p_values = 2.0 * norm.sf(np.abs(gap) / np.sqrt(np.diag(covariance)))
    by_p = np.sort(p_values)
    limit = max([p for k, p in enumerate(by_p) if p <= 0.05 * (k + 1) / len(by_p)], default=-1.0)
    names = [f"{gauge}, {cell.name}" for gauge, cell in zip(gauges, cells, strict=True)]
    found = {place.name: place for place in where.entries}
    assert [place.p_value for place in where.entries] == pytest.approx(by_p)
    for k, name in enumerate(names):
        place, z = found[name], gap[k] / np.sqrt(covariance[k, k])
        assert (place.gap, place.z, place.share) == pytest.approx((gap[k], z, excess[k] / excess.sum()))
        assert place.is_significant == (p_values[k] <= limit)
    assert where.rms == pytest.approx(np.sqrt(excess.mean()))
    groups = (gauges, [cell.load_words for cell in cells], [cell.test for cell in cells])
    for places, group in zip((where.gauges, where.loads, where.tests), groups, strict=True):
        assert [place.share for place in places] == sorted((place.share for place in places), reverse=True)
        for place in places:
            rows = np.flatnonzero(np.array(group) == place.name)
            squared = gap[rows] @ np.linalg.inv(covariance[np.ix_(rows, rows)]) @ gap[rows]
            assert (place.gap, place.share) == pytest.approx((gap[rows].mean(), excess[rows].sum() / excess.sum()))
            assert place.z == pytest.approx(np.sqrt(squared / len(rows)))
            assert place.p_value == pytest.approx(chi2.sf(squared, len(rows)))
            assert place.is_significant == (place.p_value < 0.05 / len(places))


def test_a_node_flips_as_many_decisions_as_more_readings_pass_it_than_the_twins():
    """The shares are those of the normal distribution about each mean, whose noise is 31.6 microstrain a load."""
    twin, loads = Beam(), (0.0, 1.0, 2.0)
    campaign = measured(3, lambda state, load, time: 40.0 * load, loads=loads, repeats=400)
    inputs = prepare(campaign, twin, twin.effects, measured(1000, repeats=400))[0]
    model = linearise(inputs, np.zeros((3, 2)))
    level, far = float(own_gains()[7] * twin.predict({}, 1.0)[7]), float(own_gains()[3] * twin.predict({}, 1.0)[3])
    tree = Split(1, level, Split(0, far, Leaf(0), Leaf(1)), Leaf(1))
    found = flips(model, tree, ["g04", "g08"])
    by_path = {flip.path: flip for flip in found}
    assert [flip.share for flip in found] == sorted((flip.share for flip in found), reverse=True)

    def below(shift: float) -> float:
        return float(np.mean([norm.cdf(-shift * load / 31.6) for load in loads[1:]]))

    for path in ("", "L"):
        assert by_path[path].simulated == pytest.approx(below(0.0), abs=0.04)
        assert by_path[path].real == pytest.approx(below(40.0), abs=0.08)
    assert by_path[""].share == pytest.approx(by_path[""].simulated - by_path[""].real)
    reached = by_path[""].real * (by_path["L"].simulated - by_path["L"].real)
    assert by_path["L"].share == pytest.approx(reached)
    with pytest.raises(DataError, match="reads 'other', which is no gauge"):
        flips(model, Split(1, 0.0, Leaf(0), Leaf(1)), ["g04", "other"])


@pytest.mark.parametrize(
    ("limits", "tests"),
    [
        (None, [(0.0, 0.5), (-1.0, 3.0), (3.0, 1.0), (4.5, 2.0)]),
        ((-0.5, 3.5), [(0.0, 0.5), (-0.5, 3.0), (3.0, 1.0), (3.5, 2.0)]),
        ((-2.0, 9.0), [(0.0, 0.5), (-1.0, 3.0), (3.0, 1.0), (4.5, 2.0)]),
        ((0.0, 3.0), [(0.0, 0.5), (3.0, 1.0)]),
        ((-0.5, 0.0), [(0.0, 0.5), (-0.5, 3.0)]),
        ((0.5, 2.0), []),
    ],
)
def test_loads_worth_a_test_lie_within_the_limits(limits, tests):
    assert [(load, cost) for load, _, cost in _loads_to_test(measured(1, repeats=2), limits)] == tests


def test_new_settings_are_corners_of_what_was_applied_and_half_of_the_least():
    campaign = shaken(0, 0.0)  # frequencies 1, 2, 4 and amplitudes 0.5, 1, 2: all corners were read
    assert [tuple(load.values()) for load in _new_settings(campaign)] == [(0.5, 0.25)]
    last = {k for k, cell in enumerate(campaign.cells) if tuple(cell.load.values()) == (4.0, 2.0)}
    tests = _loads_to_test(campaign.without(last), None)
    found = [(tuple(load.values()), cost) for load, _, cost in tests]
    assert found[-2:] == [((4.0, 2.0), 2.0), ((0.5, 0.25), 2.0)]
    assert {cost for _, cost in found[:-2]} == {1.0}


def test_the_overlap_of_two_answers_is_the_integral_of_the_root_of_their_densities():
    x = np.linspace(-30.0, 30.0, 20001)
    one, other = norm.pdf(x, 1.0, 2.0), norm.pdf(x, 4.0, 3.0)
    spreads = [np.diag([4.0]), np.diag([9.0])]
    found = _overlap([np.array([1.0]), np.array([4.0])], spreads, [np.log(4.0), np.log(9.0)], 0, 1)
    assert found == pytest.approx(np.trapezoid(np.sqrt(one * other), x))
    weight = np.array([0.5, 0.3, 0.2, 0.0])
    answers = [frozenset("a"), frozenset("b"), frozenset("a"), frozenset("c")]
    assert _answer_entropy(answers, weight) == pytest.approx(-0.7 * np.log(0.7) - 0.3 * np.log(0.3))


def test_a_constant_that_changed_had_another_value_before():
    found = diagnose(read(SPRINGS, under(), 7, k1=7.5), SPRINGS, odds=Odds(differences=Differences(constants=0.02)))
    changed, same = found.constants[:2]
    assert (changed.sound, changed.mean) == (pytest.approx(10.0, abs=0.6), pytest.approx(7.5, abs=0.2))
    assert same.sound == pytest.approx(same.mean, abs=0.1)


@pytest.mark.parametrize("is_known", [True, False])
def test_what_is_held_out_is_predicted_from_the_rest_alone(is_known):
    """Sizes by least squares beside their priors, three times as wide; open states go with the rest of the readings."""
    twin = Beam()
    campaign = measured(1, lambda state, load, time: -25.0, known=is_known)
    inputs = prepare(campaign, twin, twin.effects, measured(1000))[0]
    model, members = linearise(inputs, np.zeros((4, 2))), [1, 3]
    held = np.flatnonzero([load == 2.0 for load in model.loads])
    rest = np.setdiff1d(np.arange(model.n), held)
    root = np.linalg.cholesky(model.covariance[np.ix_(rest, rest)])
    wide, mean = 3.0 * inputs.priors.sd[members], inputs.priors.mean[members]
    stacked = np.vstack([np.linalg.solve(root, model.signatures[np.ix_(rest, members)]), np.diag(1.0 / wide)])
    size = np.linalg.lstsq(stacked, np.append(np.linalg.solve(root, model.residual[rest]), mean / wide), rcond=None)[0]
    through = OPEN_STATE**2 * model.tangents[held] @ model.tangents[rest].T @ np.linalg.inv(root @ root.T)
    expected = []
    for z in (np.zeros(2), size):
        left = model.residual - model.signatures[:, members] @ z
        expected.append(left[held] - through @ left[rest])
    assert _residuals(model, members, held) == pytest.approx(np.array(expected), rel=1e-6, abs=1e-9)


def test_the_share_that_is_closed_is_of_squares_with_noise_and_floor_taken_off():
    rng = np.random.default_rng(0)
    before, after, noise = rng.normal(9.0, 1.0, 400), rng.normal(3.0, 1.0, 400), np.ones(400)
    left = np.stack([before, after, noise, 2.0 * noise])
    share = 1.0 - (np.mean(after**2) - 3.0) / (np.mean(before**2) - 3.0)
    assert _held_out("all", left).closed == pytest.approx(share)
    draws = rng.normal(0.0, 1.0, (500, 400))
    closed, low, high = _closed(left, draws)
    noisy = [np.mean((part + draws) ** 2, axis=1) - 4.0 for part in (before, after)]
    assert closed == pytest.approx(share)
    assert (low, high) == pytest.approx(tuple(np.quantile(1.0 - noisy[1] / noisy[0], [0.05, 0.95])))
    assert np.isnan(_closed(np.stack([noise, noise, noise, 0.0 * noise]), draws)).all()
    assert _closed(np.stack([before, 0.0 * after, noise, noise]), draws)[0] == 1.0


def test_a_step_of_the_load_is_its_change_at_the_time_of_its_first_reading():
    campaign = measured(1, loads=(1.0, 3.0, 0.5), repeats=5)
    assert load_steps(campaign) == [(1.0, 0.0), (2.0, 30.0), (-2.5, 60.0)]
    assert load_steps(replace(campaign, time=np.full(15, np.nan))) == []


def test_a_size_is_the_mean_over_the_hypotheses_that_hold_its_effect_once():
    inputs = SimpleNamespace(priors=SimpleNamespace(name=[0, 0, 1]))
    rows = [
        ((0,), [2.0], 0.5, 0.6, False),
        ((1, 2), [4.0, 9.0], 0.25, 0.2, False),
        ((0, 1), [7.0, 8.0], 1.0, 0.1, False),
    ]
    rows.append(((1,), [90.0], 1.0, 0.1, True))
    judged = [
        SimpleNamespace(
            members=members, has_unknown=unknown, probability=share, model=SimpleNamespace(inputs=inputs),
            fit=SimpleNamespace(size=np.array(size), covariance=variance * np.eye(len(size))),
        )
        for members, size, variance, share, unknown in rows
    ]  # fmt: skip
    mean, variance = _mixture(judged[0], 0, judged)
    assert mean == pytest.approx(0.75 * 2.0 + 0.25 * 4.0)
    assert variance == pytest.approx(0.75 * (0.5 + 0.25) + 0.25 * (0.25 + 2.25))
