"""Formulas mean trees, and proofs of them hold: replayed here, by veripb where it is installed, and never for more."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import Bounds, LinearConstraint, milp

from benchmarks.data import uci
from benchmarks.oracles.cutting_planes import read_formula, verified_bounds
from benchmarks.oracles.enumeration import optimum
from benchmarks.oracles.strategies import random_problem
from octmip.encoding import cut_as_split, rank_features
from octmip.errors import CertificateError, DataError, ProblemError, SolverError
from octmip.methods.exact import branch_and_bound
from octmip.methods.two_feature import two_feature_branch_and_bound
from octmip.problem import Problem
from octmip.pseudo_boolean import check_with_veripb, write_proof
from octmip.pseudo_boolean.formula import Formula
from octmip.pseudo_boolean.question import question_of
from octmip.pseudo_boolean.witness import true_variables
from octmip.regression.exact import exact_regression
from octmip.regression.problem import RegressionProblem
from octmip.tree import Leaf, features_used, leaf_index, without_empty_sides

BLOCK = 25
needs_veripb = pytest.mark.skipif(shutil.which("veripb") is None, reason="the program veripb is not installed")


def problems(first, n, salt=77):
    """Yield random problems that have formulas."""
    for seed in range(first, first + n):
        problem = random_problem(np.random.default_rng([salt, seed]), max_depth=2, max_samples=12)
        try:
            question_of(problem)
        except ProblemError:
            continue
        yield seed, problem


def random_tree(rng, problem, ranks, depth):
    """Return a tree of cuts between ranks of the data, labels as they come."""
    columns = [j for j in range(ranks.n_columns) if len(ranks.values[j]) > 1 and problem.is_allowed((j,))]
    if depth == 0 or not columns or rng.random() < 0.2:
        return Leaf(int(rng.integers(problem.n_classes)))
    column = int(rng.choice(columns))
    cut = int(rng.integers(len(ranks.values[column]) - 1))
    return cut_as_split(ranks, column, cut, *(random_tree(rng, problem, ranks, depth - 1) for _ in range(2)))


def is_tree_of(problem, tree):
    """Whether a tree keeps leaf size and budget."""
    sizes = np.bincount(leaf_index(tree, problem.features))
    return sizes[sizes > 0].min() >= problem.leaf_size and problem.sensor_cost_of(tree) <= problem.sensor_limit


def test_every_tree_is_an_assignment_of_its_cost_and_others_are_none():
    rng, seen = np.random.default_rng(5), {True: 0, False: 0}
    for seed, problem in problems(0, 80):
        question, costs, ranks = question_of(problem)
        formula = Formula(question)
        objective, constraints = read_formula(formula.opb())
        for _ in range(20):
            tree = without_empty_sides(random_tree(rng, problem, ranks, problem.depth), problem.features)
            kept = is_tree_of(problem, tree)
            seen[kept] += 1
            if set(features_used(tree)) - {ranks.feature(column) for column in question.columns}:
                continue  # a sensor that alone is above the budget has no variable
            true = true_variables(formula, tree, ranks)
            assert all(constraint.holds(true) for constraint in constraints) == kept, f"seed {seed}"
            paid = sum(factor for name, factor in objective.terms if name in true)
            assert paid == costs.whole_objective(problem, tree), f"seed {seed}"
    assert seen[True] > 500


def least_of(formula):
    """Return the least objective of a formula, by mixed-integer programming."""
    objective, constraints = read_formula(formula)
    names = sorted({literal.lstrip("~") for c in constraints for literal, _ in c.terms})
    place = {name: k for k, name in enumerate(names)}
    rows, least = np.zeros((len(constraints), len(names))), np.zeros(len(constraints))
    for k, constraint in enumerate(constraints):
        least[k] = constraint.least
        for literal, factor in constraint.terms:
            rows[k, place[literal.lstrip("~")]] += -factor if literal[0] == "~" else factor
            least[k] -= factor if literal[0] == "~" else 0
    price = np.zeros(len(names))
    for name, factor in objective.terms:
        price[place[name]] = factor
    scale = price.max()
    rule = LinearConstraint(rows, lb=least)
    found = milp(price / scale, constraints=rule, integrality=np.ones(len(names)), bounds=Bounds(0, 1))
    return round(found.fun * scale)


def test_the_least_objective_of_a_formula_is_that_of_the_best_tree():
    n_tried = 0
    for seed, problem in problems(100, 40):
        question, costs, _ = question_of(problem)
        if max(*question.prices.tolist(), *question.sensor_prices) > 1000:
            continue  # beyond the tolerances of the mixed-integer solver
        n_tried += 1
        best = optimum(problem).tree
        assert least_of(Formula(question).opb()) == costs.whole_objective(problem, best), f"seed {seed}"
    assert n_tried > 8


@pytest.mark.parametrize("first", range(0, 200, BLOCK))
def test_proofs_replay_to_the_optimum(first, tmp_path):
    for seed, problem in problems(first, BLOCK):
        path = tmp_path / "proof.pbp"
        solution = branch_and_bound(problem, proof=path)
        _, costs, _ = question_of(problem)
        whole = costs.whole_objective(problem, optimum(problem).tree)
        found = verified_bounds(path.with_suffix(".opb").read_text(), path.read_text())
        assert found == (whole, whole), f"seed {seed}"
        assert solution.bound == solution.objective, f"seed {seed}"


def larger_problem(seed, depth=2, **options):
    """Return a problem on which proofs need lemmas, blocks of ranks and intervals that end inside them."""
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(70, 3)).round(2)
    labels = (features @ [1.0, 0.7, 0.0] + rng.normal(scale=0.4, size=70) > 0).astype(int) + (features[:, 2] > 0.8)
    weights = rng.integers(1, 4, 70).astype(float)
    return Problem(features, labels, depth=depth, weights=weights, leaf_penalty=float(seed % 3), **options)


LARGER = ({}, {"leaf_size": 9}, {"sensor_budget": 2.0}, {"leaf_size": 5, "sensor_budget": 1.0}, {"depth": 1})


@pytest.mark.parametrize("options", LARGER, ids=str)
@pytest.mark.parametrize("seed", range(2))
def test_larger_proofs_replay_too(seed, options, tmp_path):
    problem, path = larger_problem(seed, **options), tmp_path / "proof.pbp"
    solution = branch_and_bound(problem, proof=path)
    found = verified_bounds(path.with_suffix(".opb").read_text(), path.read_text())
    assert found == (solution.objective, solution.objective)


@pytest.fixture(scope="module")
def proven(tmp_path_factory):
    """Return a problem, its solution, formula and proof."""
    problem, path = larger_problem(1), tmp_path_factory.mktemp("proof") / "proof.pbp"
    solution = branch_and_bound(problem, proof=path)
    return problem, solution, path


def corrupted(proof, rng):
    """Return a proof with one line dropped, or one number in it raised by one."""
    lines = proof.splitlines()
    place = int(rng.integers(1, len(lines) - 3))
    if rng.random() < 0.5:
        return "\n".join([*lines[:place], *lines[place + 1 :], ""])
    numbers = list(re.finditer(r"(?<= )\d+(?= |;|$)", lines[place]))
    if not numbers:
        return proof
    found = numbers[int(rng.integers(len(numbers)))]
    changed = f"{lines[place][: found.start()]}{int(found[0]) + 1}{lines[place][found.end() :]}"
    return "\n".join([*lines[:place], changed, *lines[place + 1 :], ""])


def test_no_corruption_raises_what_is_proven(proven):
    _, solution, path = proven
    formula, proof, rng = path.with_suffix(".opb").read_text(), path.read_text(), np.random.default_rng(3)
    refused = 0
    for _ in range(8):
        try:
            low, _ = verified_bounds(formula, corrupted(proof, rng))
            assert low <= solution.bound
        except (ValueError, KeyError, IndexError, AssertionError) as error:
            refused += not isinstance(error, AssertionError)
    assert refused >= 4


def raised(proof, whole):
    """Return a proof that claims one more, of tree and bound."""
    return proof.replace(f"BOUNDS {whole} :", f"BOUNDS {whole + 1} :")


def test_a_raised_claim_is_refused(proven):
    _, solution, path = proven
    proof = raised(path.read_text(), int(solution.objective))
    with pytest.raises(ValueError, match="is not the bound"):
        verified_bounds(path.with_suffix(".opb").read_text(), proof)


def test_a_proof_that_is_interrupted_is_not_written(tmp_path, monkeypatch):
    def interrupted(formula, bound):
        raise KeyboardInterrupt

    monkeypatch.setattr("octmip.pseudo_boolean.files.prove", interrupted)
    with pytest.raises(SolverError, match="was interrupted"):
        branch_and_bound(larger_problem(0), proof=tmp_path / "x.pbp")


def test_other_trees_write_no_log_of_their_own_under_that_name(tmp_path):
    problem, path = larger_problem(0), tmp_path / "x.pbp"
    with pytest.raises(ProblemError, match="axis"):
        two_feature_branch_and_bound(replace(problem, split="hyperplane", split_size=2), proof=path)
    numbers = RegressionProblem(problem.features, problem.features[:, 0], depth=1)
    with pytest.raises(ProblemError, match="for classes"):
        exact_regression(numbers, proof=path)
    assert not list(tmp_path.iterdir())


def test_a_bound_above_the_optimum_is_not_written(proven, tmp_path):
    problem, solution, _ = proven
    worse = Leaf(0)
    with pytest.raises(SolverError, match="second search finds a tree below the bound"):
        write_proof(tmp_path / "x.pbp", problem, worse, solution.objective + 1)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("depth", [1, 2])
def test_a_bound_below_the_optimum_is_proven_beside_any_tree(depth, tmp_path):
    problem, path = larger_problem(2, depth), tmp_path / "x.pbp"
    tree, path = branch_and_bound(replace(problem, depth=1)).tree, tmp_path / "x.pbp"
    bound = branch_and_bound(problem).objective - 3.5
    assert write_proof(path, problem, tree, bound) == np.ceil(bound)
    found = verified_bounds(path.with_suffix(".opb").read_text(), path.read_text())
    assert found == (np.ceil(bound), problem.objective(tree))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"depth": 3}, "depth 3 with split 'axis' has no pseudo-Boolean proof"),
        ({"weights": np.linspace(0.1, 0.9, 70)}, "a pseudo-Boolean proof does not round"),
        ({"costs": [[0.0, 1, 2], [1, 0, 1], [1, 1, 0]]}, "needs 0 for the right label and one price"),
        ({"costs": np.zeros((3, 3))}, "no error costs anything"),
    ],
)
def test_what_has_no_formula_is_refused_in_a_sentence(changes, reason, tmp_path):
    problem = replace(larger_problem(0), **changes)
    with pytest.raises(ProblemError, match=reason):
        branch_and_bound(problem, proof=tmp_path / "x.pbp")
    assert not list(tmp_path.iterdir())


def test_another_problems_formula_is_refused_before_the_checker_is_asked(proven):
    problem, solution, path = proven
    other = replace(problem, weights=problem.weights + 1)
    with pytest.raises(CertificateError, match="is not the formula of this problem"):
        check_with_veripb(other, path, solution.tree, solution.bound)


def test_without_the_checker_a_sentence_says_how_to_install_it(proven, monkeypatch):
    problem, solution, path = proven
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(SolverError, match="cargo install veripb --version"):
        check_with_veripb(problem, path, solution.tree, solution.bound)


def test_a_proof_without_its_formula_is_refused(proven, tmp_path):
    problem, solution, path = proven
    alone = tmp_path / "alone.pbp"
    alone.write_text(path.read_text())
    with pytest.raises(DataError, match=r"alone\.opb cannot be read"):
        check_with_veripb(problem, alone, solution.tree, solution.bound)


def stand_in(tmp_path, monkeypatch, output):
    """Put a program of the checker's name on the path that only prints."""
    program = tmp_path / "veripb"
    program.write_text(f"#!/bin/sh\nprintf '{output}'\n")
    program.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda name: str(program))


@pytest.mark.parametrize(
    ("output", "reason"),
    [
        ("s VERIFIED BOUNDS {0} <= obj <= {0}\\nWarning: The proof used unchecked assumptions.\\n", "refuses"),
        ("s VERIFIED BOUNDS {1} <= obj <= {0}\\n", "proves the bound"),
        ("s VERIFIED BOUNDS {0} <= obj <= {2}\\n", "holds a tree of cost"),
        ("s VERIFIED NO CONCLUSION\\n", "refuses"),
    ],
)
def test_only_an_unreserved_verdict_on_bound_and_tree_is_taken(output, reason, proven, tmp_path, monkeypatch):
    problem, solution, path = proven
    whole = int(solution.objective)
    stand_in(tmp_path, monkeypatch, output.format(whole, whole - 1, whole + 1))
    with pytest.raises(CertificateError, match=reason):
        check_with_veripb(problem, path, solution.tree, solution.bound)


@needs_veripb
def test_veripb_accepts_iris_and_random_problems(tmp_path):
    table = uci("iris")
    small = [problem for _, problem in problems(300, 30)]
    larger = [larger_problem(2, **options) for options in LARGER]
    for problem in [Problem(table.features, table.labels, depth=2), *larger, *small]:
        solution = branch_and_bound(problem, proof=tmp_path / "x.pbp")
        report = check_with_veripb(problem, tmp_path / "x.pbp", solution.tree, solution.bound)
        assert report.bound == report.objective == solution.objective


@needs_veripb
def test_veripb_refuses_a_raised_claim_an_assumption_and_a_dropped_line(proven, tmp_path):
    problem, solution, path = proven
    proof, copy = path.read_text(), tmp_path / "x.pbp"
    copy.with_suffix(".opb").write_text(path.with_suffix(".opb").read_text())
    lines = proof.splitlines()
    assumed = f"a {' '.join(f'1 w0_{i}' for i in range(3))} >= 3;"
    for changed in (
        raised(proof, int(solution.objective)),
        "\n".join([*lines[:200], *lines[201:], ""]),
        "\n".join([lines[0], assumed, *lines[1:], ""]),
    ):
        copy.write_text(changed)
        with pytest.raises(CertificateError, match="refuses"):
            check_with_veripb(problem, copy, solution.tree, solution.bound)


def test_ranks_of_a_formula_are_those_of_the_samples_that_cost_something():
    problem = Problem([[0.0], [1.0], [2.0]], [0, 1, 1], depth=1, weights=[1.0, 0.0, 2.0])
    question, _, ranks = question_of(problem)
    assert question.ranks.tolist() == [[0, 2]]
    assert question.n_ranks.tolist() == [len(rank_features(problem).values[0])] == [len(ranks.values[0])]
