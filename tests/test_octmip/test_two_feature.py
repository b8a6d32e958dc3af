"""Two-feature splits: what the returned tree must hold, and stops. The fuzz holds the optimum against enumeration."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from octmip import ClassCosts, Limits, Problem, Stop, certify
from octmip.errors import CertificateError, ProblemError
from octmip.trees import _native
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.native_call import without
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.nodes.tree import HyperplaneSplit, Split, splits
from octmip.trees.solver import solve
from tests.oracles.rational import least_cost
from tests.oracles.two_feature_problems import clouds, random_two_feature_problem


def solve_and_certify(problem: Problem, **options: object) -> float:
    solution = two_feature_branch_and_bound(problem, **options)
    certify(problem, solution)
    assert solution.is_optimal, solution
    return solution.objective


def test_a_point_one_unit_in_the_last_place_off_a_line_counts_as_off_it() -> None:
    # The middle point lies above the diagonal by 2^-52: exact arithmetic parts it, and so does a float64 line.
    options: dict[str, Any] = {"depth": 1, "split": "hyperplane", "leaf_penalty": 0.1}
    problem = Problem([[0, 0], [1, np.nextafter(1, 2)], [2, 2]], [0, 1, 0], **options)
    on_line = Problem([[0, 0], [1, 1], [2, 2]], [0, 1, 0], **options)
    assert float(least_cost(problem)) < float(least_cost(on_line)) == solve_and_certify(on_line)
    assert two_feature_branch_and_bound(problem).bound == pytest.approx(float(least_cost(problem)), abs=1e-6)


def test_the_line_is_the_one_with_the_widest_margin() -> None:
    problem = Problem([[0, 0], [0, 2], [4, 0], [4, 2]], [0, 0, 1, 1], depth=1, split="hyperplane")
    tree = two_feature_branch_and_bound(problem).tree
    assert tree is not None
    (split,) = splits(tree)
    assert isinstance(split, Split)
    assert (split.feature, split.threshold) == (0, 2.0)
    # Stretched to a range of 1, the classes are a segment from (0, 0) to (0, 1/3) and a triangle beyond x + y = 1. The
    # widest gap is from (0, 1/3) to that edge: the line is x + y = 2/3 there, x + y/3 = 2/3 here.
    tilted = Problem([[0, 0], [1, 0], [0, 3], [1, 3], [0, 1], [1, 2]], [0, 1, 1, 1, 0, 1], depth=1, split="hyperplane")
    tree = two_feature_branch_and_bound(tilted).tree
    assert tree is not None
    (split,) = splits(tree)
    assert isinstance(split, HyperplaneSplit)
    assert np.array(split.coefficients) / split.offset == pytest.approx([1.5, 0.5])
    assert solve_and_certify(tilted) == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"depth": 4, "split_size": 2}, "depth is 4 but two-feature trees are proven to depth 3"),
        ({"depth": 1, "split_size": 3}, "3 features"),
        ({"depth": 3, "split_size": 2, "sensor_budget": 2.0}, "sensor.budget"),
        ({"depth": 3, "split_size": 2, "integer_normals": 4}, "whole coefficients|integer_normals"),
    ],
)
def test_what_is_not_proven_is_refused(options: dict[str, Any], message: str) -> None:
    problem = Problem(np.eye(4), [0, 1, 0, 1], split="hyperplane", **options)
    with pytest.raises(ProblemError, match=message):
        two_feature_branch_and_bound(problem)
    with pytest.raises(ProblemError, match=message):
        solve(problem, "exact")


def test_no_log_is_promised_at_depth_three(tmp_path: Path) -> None:
    problem = clouds(1).replace(depth=3)
    for ask in (two_feature_branch_and_bound, lambda *given, **options: solve(*given, "exact", **options)):
        with pytest.raises(ProblemError, match="proof"):
            ask(problem, options=ExactOptions(proof=tmp_path / "log"))


@pytest.mark.long(*map(str, [*range(6, 12), 173]))
@pytest.mark.parametrize("seed", [*range(12), 104, 173])
def test_depth_three_is_the_best_of_all_trees_and_its_bound_holds_wherever_it_stops(seed: int) -> None:
    rng = np.random.default_rng([993 if seed < 12 else 994, seed])
    problem = random_two_feature_problem(rng, depth=3, max_samples=8 if seed < 12 else 9).replace(sensor_budget=None)
    problem = problem if seed < 12 else problem.replace(leaf_size=2)  # open samples make up for what a leaf lacks
    least = float(least_cost(problem))
    assert solve_and_certify(problem) == pytest.approx(least, abs=1e-9)
    for nodes in (1, 30, 200):
        bounded = two_feature_branch_and_bound(problem, limits=Limits(nodes=nodes))
        assert bounded.bound <= least * (1 + 1e-12)
        assert bounded.is_optimal <= (bounded.objective == pytest.approx(least, abs=1e-9))


def test_depth_three_of_a_cloud_costs_no_more_than_depth_two_and_search_finds_no_better_tree() -> None:
    problem = clouds(4, most_samples=100)
    deeper = problem.replace(depth=3)
    solution = two_feature_branch_and_bound(deeper, n_jobs=2)
    certify(deeper, solution)
    found = solve(deeper, "search")
    assert solution.is_optimal
    assert solution.objective <= min(found.objective, two_feature_branch_and_bound(problem).objective)


def published_like(n: int, p: int) -> Problem:
    """Return a problem of five overlapping classes, like the strains' damage levels."""
    rng = np.random.default_rng(5)
    level = rng.integers(0, 5, n)
    gains = np.linspace(2.0, 0.5, p)
    features = level[:, None] * gains + rng.normal(scale=1.5, size=(n, p))
    return Problem(features, level, depth=2, split="hyperplane", split_size=2)


def test_the_bound_rises_and_stays_below_the_optimum_when_nodes_run_out() -> None:
    problem = published_like(150, 3)
    optimum = two_feature_branch_and_bound(problem).objective
    solutions = [two_feature_branch_and_bound(problem, limits=Limits(nodes=n)) for n in (1, 300, 1000)]
    bounds = [solution.bound for solution in solutions]
    assert bounds == sorted(bounds)
    assert not any(solution.details["numerically_undecided"] for solution in solutions)
    assert all(bound <= optimum for bound in bounds)


@pytest.mark.parametrize("seed", range(3))
def test_a_stop_while_the_tables_are_made_leaves_a_valid_bound_and_no_log(seed: int, tmp_path: Path) -> None:
    problem = random_two_feature_problem(np.random.default_rng([63, seed]), depth=2, max_samples=12)
    least = float(least_cost(problem))
    for k, seconds in enumerate(np.geomspace(1e-6, 1e-2, 50)):
        log = tmp_path / f"{k}.log"
        solution = two_feature_branch_and_bound(
            problem, limits=Limits(seconds=float(seconds)), options=ExactOptions(proof=log)
        )
        assert solution.bound <= least * (1 + 1e-12), seconds
        assert solution.is_optimal <= (solution.objective == pytest.approx(least)), seconds


def parted_by(seed: int) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any], int]:
    """Return samples, their sides of a line with whole-numbered coefficients, and the limit of these."""
    rng = np.random.default_rng([80, seed])
    most, n = int(rng.integers(1, 12)), int(rng.integers(4, 200))
    features = rng.normal(size=(n, 2)) * rng.uniform(0.1, 100, 2)
    reach = features @ rng.choice([-1, 1], 2) * most if seed % 9 == 0 else features @ rng.integers(-most, most + 1, 2)
    return features, (reach > 0.3 * rng.normal() * np.abs(reach).mean()).astype(int), most


def test_whole_numbered_coefficients_are_found_wherever_some_part_the_samples_alike() -> None:
    asked = 0
    for seed in range(60):
        features, labels, most = parted_by(seed)
        if len(set(labels.tolist())) == 2:
            asked += 1
            problem = Problem(features, labels, depth=1, split="hyperplane", integer_normals=most)
            assert solve_and_certify(problem) == 0, f"seed {seed}"
    assert asked > 50


def test_where_no_whole_numbered_coefficients_do_the_bound_is_that_of_real_ones() -> None:
    features, labels, most = parted_by(3)
    assert most > 1
    solution = two_feature_branch_and_bound(
        Problem(features, labels, depth=1, split="hyperplane", integer_normals=1, leaf_penalty=0)
    )
    assert solution.bound == 0 < solution.objective
    assert solution.stop is Stop.FINISHED
    assert solution.details["coefficients"] == "whole; the bound is that of real ones"


def test_a_memory_limit_stops_the_search_with_a_tree_and_a_bound() -> None:
    problem = published_like(400, 6)
    solution = two_feature_branch_and_bound(problem, limits=Limits(memory=2e6))
    certify(problem, solution)
    assert solution.stop is Stop.MEMORY


def test_logs_of_larger_problems_are_checked_on_several_threads(tmp_path: Path) -> None:
    path = tmp_path / "proof.log"
    for seed in (2, 6, 9):
        problem = clouds(seed, most_samples=140)
        solution = two_feature_branch_and_bound(problem, options=ExactOptions(proof=path), n_jobs=2)
        assert check_proof(problem, path, n_jobs=2).bound == solution.objective


def log_of(problem: Problem, path: Path) -> list[str]:
    two_feature_branch_and_bound(problem, options=ExactOptions(proof=path))
    return path.read_text().split("\n")


def test_a_log_is_bound_to_its_samples_and_its_question(tmp_path: Path) -> None:
    problem = clouds(2, most_samples=100)
    path = tmp_path / "proof.log"
    log_of(problem, path)
    other = problem.replace(features=problem.samples.features * 2)
    with pytest.raises(CertificateError, match="line 2"):
        check_proof(other, path)
    with pytest.raises(CertificateError, match="line 3"):
        check_proof(problem.replace(leaf_penalty=1), path)


def test_deeper_trees_have_no_logs() -> None:
    problem = Problem(np.eye(4), [0, 1, 0, 1], depth=3, split="hyperplane", split_size=2)
    with pytest.raises(ProblemError, match="depth 3 with 2 features per split has no proof log"):
        check_proof(problem, "nowhere.log")


PRUNES = _native.two_feature_prunes()


def optimum(problem: Problem, off: list[str]) -> float:
    with without(*off):
        solution = two_feature_branch_and_bound(problem)
    assert solution.is_optimal
    return solution.objective


def variants(problem: Problem) -> list[Problem]:
    """Return the problem with weights, graded costs, and leaf size and penalty."""
    rng = np.random.default_rng(0)
    k = problem.samples.n_classes
    return [
        problem.replace(weights=rng.integers(1, 4, problem.samples.n_samples).astype(float)),
        problem.replace(loss=ClassCosts(np.abs(np.subtract.outer(np.arange(k), np.arange(k))).astype(float))),
        problem.replace(leaf_size=9, leaf_penalty=2.0),
    ]


@pytest.mark.parametrize("off", PRUNES)
def test_the_optimum_stays_without(off: str) -> None:
    for seed in (4, 355):
        problem = clouds(seed, most_samples=130)
        for variant in [problem, *variants(problem)]:
            assert optimum(variant, [off]) == optimum(variant, [])


def test_the_optimum_stays_without_any_of_many_together() -> None:
    rng = np.random.default_rng(7)
    for seed in range(6):
        problem = clouds(seed, most_samples=110)
        off = [name for name in PRUNES if name != "narrow" and rng.random() < 0.5]
        assert optimum(problem, off) == optimum(problem, []), off


@pytest.mark.parametrize(("seed", "best"), [(177, 14), (98, 39), (355, 4), (279, 59)])
def test_what_more_samples_teach_about_a_strip_is_not_held_against_fewer(seed: int, best: int) -> None:
    """Slope intervals bounded with open samples once counted as bounded without: these optima came out too high."""
    problem = clouds(seed)
    assert optimum(problem, []) == optimum(problem, ["wide"]) == best


@pytest.mark.parametrize("seed", [0, 4, 8, 21])
def test_what_one_set_of_sensors_teaches_is_not_used_under_another(seed: int) -> None:
    """Good lines of other nodes once served sets that may not read their sensors: the tree was over its budget."""
    problem = clouds(seed, most_samples=130)
    budget = problem.replace(sensor_budget=problem.samples.n_features - 1.0)
    solution = two_feature_branch_and_bound(budget)
    certify(budget, solution)
    assert solution.is_optimal
    assert solution.objective >= optimum(problem, [])
