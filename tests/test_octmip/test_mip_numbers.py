"""Weights, costs, penalties and features of any size: what HiGHS says of them must hold in the problem's own units."""

import math
from dataclasses import asdict, replace
from fractions import Fraction
from io import BytesIO
from threading import Lock
from types import SimpleNamespace

import highspy
import numpy as np
import pytest

from octmip import Leaf, Limits, Problem, Stop, certify
from octmip.trees.mip import prices
from octmip.trees.mip.blocks.hyperplanes import space_of
from octmip.trees.mip.flow import solve_flow
from octmip.trees.mip.highs import claims, highs, worker
from octmip.trees.mip.oct import solve_oct
from octmip.trees.mip.oct_h import solve_oct_h
from octmip.trees.mip.rows import Rows
from octmip.trees.nodes.tree import HyperplaneSplit, Split
from octmip.trees.question.losses import ClassCosts
from tests.oracles.enumeration import optimum
from tests.oracles.rational import least_cost

SIZES = {
    "large": lambda rng, n: rng.integers(10**11, 10**12, n).astype(float),
    "tiny": lambda rng, n: rng.random(n) * 10.0 ** rng.choice([-6, -9, -12]),
    "spread": lambda rng, n: 10.0 ** rng.uniform(-12, 12, n),
    "few decades": lambda rng, n: 10.0 ** rng.uniform(-2, 2, n),
}
EXTREME = [5e-324, -5e-324, 0.0, 1e-300, np.nextafter(1.0, 0.0), 1.0, 1e300, -1e300, 1.7976931348623157e308]


def wild(seed: int, size: str, split: str = "axis") -> Problem:
    """Return a small problem with weights of a size, and sometimes costs and a penalty of another."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    labels = rng.integers(0, 2 + seed % 2, n)
    labels[:2] = 0, 1
    options: dict[str, object] = {"weights": SIZES[size](rng, n)}
    if rng.random() < 0.4:
        options["loss"] = ClassCosts(SIZES[rng.choice(list(SIZES))](rng, (3, 3)) * (1 - np.eye(3)))
    if rng.random() < 0.3:
        options["leaf_penalty"] = float(SIZES[rng.choice(list(SIZES))](rng, 1)[0])
    features = rng.integers(0, 4, (n, 2)).astype(float)
    return Problem(features, labels, depth=1 + seed % 2, split=split, class_names=(0, 1, 2), **options)


def holds(problem: Problem, solution, best: float) -> None:
    """Assert that a solution claims nothing that the true optimum, rounded once, refutes."""
    certify(problem, solution)
    room = Fraction(solution.tolerance) + Fraction(best) / 10**14
    assert Fraction(solution.bound) <= Fraction(best) + room
    if solution.stop is Stop.OPTIMAL:
        assert Fraction(solution.objective) <= Fraction(best) + room
    assert solution.stop in (Stop.OPTIMAL, Stop.NUMERICS)


@pytest.mark.parametrize("size", SIZES)
def test_what_flow_claims_of_hyperplane_trees_holds_at_any_size(size):
    for seed in range(0, 10, 2):  # depth 1: the printed form takes seconds at depth 2; the fuzz asks the others
        problem = wild(seed, size, "hyperplane")
        holds(problem, solve_flow(problem), float(least_cost(problem)))


def test_whole_weights_of_one_large_unit_are_proven_outright():
    problem = Problem([[0.0], [1.0], [2.0], [3.0]], [0, 1, 0, 1], depth=1, weights=1e12 * np.array([1, 2, 2, 3]))
    for solver in (solve_oct, solve_flow):
        solution = solver(problem)
        assert (solution.objective, solution.bound, solution.tolerance) == (2e12, 2e12, 0.0)
        assert solution.stop is Stop.OPTIMAL


def test_a_bound_that_weights_leave_no_room_to_prove_ends_in_numerics():
    features, labels = [[0.0], [0.0], [1.0], [1.0]], [0, 1, 0, 1]  # of each two the lighter is paid: math.pi + 1e-9
    problem = Problem(features, labels, depth=1, weights=[math.pi, 7.1, 5.3, 1e-9])
    solution = solve_oct(problem)
    holds(problem, solution, optimum(problem).objective)
    assert solution.stop is Stop.NUMERICS
    assert 0 < solution.bound < solution.objective
    assert solution.tolerance == 0


def test_prices_bound_the_true_objective_on_both_sides():
    for seed in range(40):
        problem = wild(seed, list(SIZES)[seed % 4])
        known = problem.baseline
        priced = prices.whole_prices(problem, known)
        assert priced.worst <= prices.LARGEST * problem.samples.n_samples * 2
        assert (priced.costs == np.round(priced.costs)).all()
        assert (priced.weights == np.round(priced.weights)).all()
        for tree in (Leaf(0), Leaf(1), Split(0, 0.5, Leaf(0), Leaf(1)), Split(1, 1.5, Leaf(2), Leaf(0))):
            true, price = Fraction(problem.objective(tree)), int(priced.of_tree(problem, tree))
            room = true / 10**14
            assert true >= min(Fraction(known), priced.lower_bound(price)) - room
            if true <= known:
                assert true <= priced.unit * price + priced.below + room


def test_small_whole_problems_are_priced_as_they_stand():
    samples = wild(1, "large").samples
    small = Problem(samples.features, samples.targets, depth=1, weights=np.arange(1, samples.n_samples + 1))
    priced = prices.whole_prices(small, 3.0)
    assert (priced.unit, priced.above, priced.below) == (1, 0, 0)
    assert priced.weights is small.samples.weights


def test_decimal_weights_are_whole_in_their_last_digit():
    problem = Problem([[0.0], [1.0], [2.0]], [0, 1, 0], depth=1, weights=[0.1, 0.7, 0.3])
    priced = prices.whole_prices(problem, 0.4)
    assert priced.unit == Fraction(1, 10)
    assert priced.weights.tolist() == [1, 6, 3]
    assert priced.above + priced.below < Fraction(1, 10**15)
    problem = Problem([[0.0], [1.0]], [0, 1], depth=1, weights=[3, 3 * prices.LARGEST - 3])
    priced = prices.whole_prices(problem, 3.0 * prices.LARGEST)
    assert (priced.unit, priced.above, priced.below) == (3, 0, 0)


def test_a_bound_is_lowered_by_the_gap_and_by_what_reduced_costs_allow():
    exact = claims.Accuracy(tolerance=1e-6, dual_tolerance=1e-7, error=0.04)
    ended = {"values": None, "n_nodes": 1, "seconds": 0.0, "first_incumbent": 7.0, "root_bound": 0.0, "status": ""}
    for objective, bound, believed in ((7.0, 7.0, 7), (7.0, 6.07, 7), (7.0, 6.03, 6), (7.0, -math.inf, 0), (7, 5.0, 5)):
        outcome = highs.Outcome(objective=objective, claimed=objective, bound=bound, stop=Stop.OPTIMAL, **ended)
        assert exact.bound(outcome) == believed


def test_a_bound_that_a_known_tree_contradicts_is_not_believed(monkeypatch):
    problem = wild(3, "large")
    monkeypatch.setattr(claims.Accuracy, "bound", lambda self, outcome: 10**9)
    solution = solve_oct(problem)
    certify(problem, solution)
    assert solution.stop is Stop.NUMERICS
    assert solution.bound == 0 < solution.objective
    assert "its own costs" in solution.details["numerics"]


def test_an_objective_is_counted_from_the_values_and_a_start_that_is_mispriced_is_left_out(monkeypatch):
    problem, starts, run = Problem([[0.0], [1.0], [2.0]], [0, 1, 0], depth=1), [], highs.run

    def says_zero_where_a_start_is_given(rows, options, *, start, **more):
        starts.append(start)
        outcome = run(rows, options, start=start, **more)
        return outcome if start is None else replace(outcome, claimed=0.0, bound=0.0)

    monkeypatch.setattr(highs, "run", says_zero_where_a_start_is_given)
    solution = solve_oct(problem)
    assert (solution.objective, solution.bound, solution.stop) == (1, 1, Stop.OPTIMAL)
    assert starts[0] is not None
    assert starts[1:] == [None]


def test_what_highs_says_of_a_solution_is_not_what_it_costs(monkeypatch):
    rows = Rows()
    rows.columns("x", (range(2),), cost=1.0)
    supervisor = highs._Supervisor(None, rows, Limits(), None)
    supervisor._note(("incumbent", -5.0, np.array([3.0, 1.0])))
    supervisor._note(("incumbent", -9.0, np.array([4.0, 1.0])))
    assert (supervisor.objective, supervisor.claimed) == (4.0, -5.0)
    ended = {"values": np.array([1.0, 0.0]), "objective": 0.0, "bound": 0.0, "n_nodes": 1, "status": "kOptimal"}
    outcome = supervisor._done(ended | {"state": asdict(supervisor.state)})
    assert (outcome.objective, outcome.claimed, outcome.bound) == (1.0, 0.0, 0.0)
    exact = claims.Accuracy(tolerance=1e-6, dual_tolerance=1e-7, error=0.0)
    assert exact.bound(outcome) == 0


@pytest.mark.parametrize(("said", "n_nodes", "root_bound"), [(-1, 0, 3.0), (0, 0, 3.0), (1, 1, 3.0), (2, 2, 2.0)])
def test_the_bound_of_the_root_is_that_before_a_second_node(said, n_nodes, root_bound):
    """HiGHS says -1 where it had no search at all."""
    run = worker.Run({}, worker.Commands(), BytesIO(), Lock())
    for count, bound in ((0, 1.0), (1, 2.0), (2, 2.5)):
        run._report(
            SimpleNamespace(data_out=SimpleNamespace(mip_primal_bound=9, mip_dual_bound=bound, mip_node_count=count))
        )
    info = SimpleNamespace(primal_solution_status=0, objective_function_value=9, mip_dual_bound=3, mip_node_count=said)
    end = run._end(SimpleNamespace(getInfo=lambda: info, getModelStatus=lambda: highspy.HighsModelStatus.kOptimal))
    outcome = highs._Supervisor(None, Rows(), Limits(), None)._done(end)
    assert (outcome.n_nodes, outcome.root_bound, outcome.bound) == (n_nodes, root_bound, 3.0)


def test_a_failure_of_highs_leaves_the_start_and_says_so(monkeypatch):
    problem = wild(3, "large")
    monkeypatch.setitem(highs._STOPS, "kOptimal", Stop.NUMERICS)
    solution = solve_oct(problem)
    certify(problem, solution)
    assert solution.stop is Stop.NUMERICS
    assert solution.details["numerics"] == "HiGHS ended with kOptimal"


@pytest.mark.parametrize("seed", range(6))
def test_features_of_extreme_size_make_no_wrong_claim_and_no_warning(seed):
    rng = np.random.default_rng(seed)
    features = rng.choice(EXTREME, (7, 2))
    labels = rng.integers(0, 2, 7)
    labels[:2] = 0, 1
    axis = Problem(features, labels, depth=1)
    holds(axis, solve_oct(axis), optimum(axis).objective)
    for normals in (None, 2):
        plane = Problem(features, labels, depth=1, split="hyperplane", integer_normals=normals)
        for solver in (solve_oct_h, solve_flow):
            solution = solver(plane, incumbent=Leaf(0), limits=Limits(seconds=20))
            assert "mu-separated" in certify(plane, solution).scope


def test_scaled_features_lie_in_the_unit_range_at_any_size():
    columns = [[-1.7e308, 1.7e308, 0.0], [5e-324, 0.0, 1e-323], [1.0, 1.0 + 2**-52, 1.0], [1e300, -1e300, 1e-300]]
    problem = Problem(np.array(columns).T, [0, 1, 0], depth=1, split="hyperplane")
    space = space_of(problem, centred=False)
    assert space.x.min(axis=0).tolist() == [0.0] * 4
    assert space.x.max(axis=0).tolist() == [1.0] * 4
    assert space.x[:, 1].tolist() == [0.5, 0.0, 1.0]


def test_a_normal_goes_through_features_of_extreme_size_and_back():
    problem = Problem([[-1e300, 1.0], [1e300, 2.0], [0.0, 1.5]], [0, 1, 0], depth=1, split="hyperplane")
    space = space_of(problem)
    normal = np.array([0.25, -0.75])
    coefficients = space.coefficients_of(normal)
    split = HyperplaneSplit((0, 1), tuple(coefficients.tolist()), 0.0, Leaf(0), Leaf(1))
    assert np.allclose(space.normal_of(split), normal, rtol=1e-14)


def test_sensors_are_kept_within_a_budget_of_any_unit():
    for unit in (1e-12, 1e12):
        cost = [3 * unit, 2 * unit]
        problem = Problem(
            [[0, 0], [0, 1], [1, 0], [1, 1]], [0, 1, 1, 0], depth=2, sensor_cost=cost, sensor_budget=4 * unit
        )
        solution = solve_oct(problem)
        assert solution.objective == optimum(problem).objective
        assert solution.is_optimal
