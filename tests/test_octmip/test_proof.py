"""Proof logs: what the checker accepts is true, what it refuses it refuses with a place and a reason.

The logs are written by `tests/oracles/proof_log.py`, which knows no solver.
"""

import json
import shutil

import numpy as np
import pytest

from benchmarks.cases.fuzz import check_command
from benchmarks.cases.fuzz.proofs import KINDS, corrupted
from octmip import ExactOptions, Leaf, Limits, Problem, Split, solve
from octmip.errors import CertificateError
from octmip.trees.evidence.proof import check_proof, checker_question
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem_file import data_digest, encode, question_digest
from tests.oracles.enumeration import optimum
from tests.oracles.proof_log import proof_log
from tests.oracles.strategies import random_problem
from tests.oracles.two_feature_problems import random_two_feature_problem

STRIPES = Problem([[0.0], [1.0], [2.0], [3.0], [4.0], [5.0]], [0, 1, 0, 1, 0, 1], depth=2)


def whole_problems(stream, count, **limits):
    """Return random problems whose weights and costs are whole numbers."""
    found, seed = [], 0
    while len(found) < count:
        problem = random_problem(np.random.default_rng([stream, seed]), **limits)
        found += [problem] if problem.has_integer_costs else []
        seed += 1
    return found


@pytest.fixture
def log(tmp_path):
    """Return a function that writes a text as a log file."""

    def write(text):
        path = tmp_path / "proof.log"
        path.write_text(text)
        return path

    return write


def test_no_log_proves_more_than_the_optimum(log):
    """Cuts left out at random: some logs still prove the optimum, none proves one more."""
    proven = 0
    for number, problem in enumerate(whole_problems(32, 30, max_samples=9)):
        best = int(optimum(problem).objective)
        for keep in (1.0, 0.5, 0.1):
            text = proof_log(problem, keep=keep, seed=number)
            proven += accepted(problem, log(text))
            more = text.replace(f"claim {best}", f"claim {best + 1}")
            for leaf in {1, problem.shape.leaf_size}:
                node = f"\nN {problem.shape.depth} {leaf} "
                more = more.replace(f"{node}{best}\n", f"{node}{best + 1}\n")
            assert not accepted(problem, log(more))
    assert 30 < proven < 90


def test_rows_are_counted_as_they_are_where_equal_ones_are_merged(log):
    features = np.array([0.0, 0, 0, 1, 2, 2, 3])[:, None]
    problem = Problem(features, np.array([0, 0, 0, 1, 0, 1, 1]), depth=2)
    text = proof_log(problem)
    assert "\nF 0 3 1 2\n" in text
    assert [check_proof(problem, log(text), n_jobs=n_jobs).bound for n_jobs in (1, 2)] == [1, 1]
    for inside in ("2 2 2", "3 1 1", "1 3 2", "3 1 3"):
        with pytest.raises(CertificateError, match="line 7: feature 0 has no cut"):
            check_proof(problem, log(text.replace("F 0 3 1 2", f"F 0 {inside}")))


def accepted(problem, path):
    try:
        check_proof(problem, path)
    except CertificateError:
        return False
    return True


def test_real_weights_are_rounded_down_on_the_grid_of_the_header(log):
    problem = STRIPES.replace(depth=2, weights=[0.7, 0.3, 0.9, 1.0, 0.4, 0.2])
    on_grid = problem.replace(weights=np.floor(problem.samples.weights * 16))
    data = [line for line in proof_log(problem).splitlines() if line.startswith(("data", "question"))]
    lines = proof_log(on_grid).splitlines()
    lines[1:3], lines[3] = data, "grid 4 0"
    bound = check_proof(problem, log("\n".join([*lines, ""]))).bound
    assert bound == optimum(on_grid).objective / 16 <= optimum(problem).objective


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda lines: "x", 'line 1: got "x", expected "octmip-proof 3"'),
        (lambda lines: "octmip-proof 2", "line 1: .* was written by an older octmip; write the log again"),
        (lambda lines: "\n".join(lines[:-1]), "expected end"),
        (lambda lines: "\n".join([*lines[:5], "N 2 1 2", *lines[6:]]), "line 6: cut 2 of feature 0: 1, not 2"),
    ],
)
def test_a_log_that_proves_nothing_is_refused_with_line_and_reason(log, change, complaint):
    lines = proof_log(STRIPES).splitlines()
    assert accepted(STRIPES, log("\n".join(lines)))
    with pytest.raises(CertificateError, match=complaint):
        check_proof(STRIPES, log(change(lines)))


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"targets": [0, 1, 0, 1, 0, 0]}, 2),
        ({"features": [[0.0], [1.0], [2.0], [3.0], [4.0], [5.000001]]}, 2),
        ({"weights": [1, 1, 1, 1, 1, 2]}, 2),
        ({"leaf_size": 2}, 3),
        ({"leaf_penalty": 1.0}, 3),
        ({"depth": 3}, 3),
        ({"loss": ClassCosts([[0, 2], [1, 0]])}, 3),
        ({"sensor_budget": 0}, 3),
    ],
)
def test_a_log_of_another_problem_is_refused(log, options, line):
    path = log(proof_log(STRIPES))
    changed = {"features": STRIPES.samples.features, "targets": STRIPES.samples.targets, "depth": 2} | options
    problem = Problem(changed.pop("features"), changed.pop("targets"), **changed)
    with pytest.raises(CertificateError, match=f"line {line}: "):
        check_proof(problem, path)


def test_a_log_that_proves_less_than_is_claimed_for_a_tree_is_refused(log):
    with pytest.raises(CertificateError, match=r"line 5: the log proves 1\.0 but 2\.0 is claimed"):
        check_proof(STRIPES, log(proof_log(STRIPES)), bound=2.0)


def test_a_log_proves_the_bound_where_labels_would_prove_more(tmp_path):
    features = np.random.default_rng(0).normal(size=(40, 2))
    problem = Problem(features, np.arange(40) % 5, depth=1, split="hyperplane", split_size=2, leaf_penalty=1.0)
    log = tmp_path / "stopped.log"
    stopped = solve(problem, "exact", Limits(seconds=0), options=ExactOptions(proof=log))
    assert stopped.bound < problem.bound_by_labels
    assert check_proof(problem, log, bound=stopped.bound).bound == stopped.bound


@pytest.mark.parametrize("first", [2000, 2010])
@pytest.mark.parametrize("kind", KINDS)
def test_a_log_of_a_solver_proves_its_bound_and_no_corruption_that_changes_the_claim_is_accepted(kind, first):
    assert not [seed for seed in range(first, first + 10) if corrupted(kind, seed)[1] == "wrong"]


def problems() -> list[Problem]:
    """Return random problems of both kinds of splits, with every complication."""
    streams = [np.random.default_rng([91, seed]) for seed in range(30)]
    return [random_problem(rng) for rng in streams] + [
        random_two_feature_problem(rng, depth=2, max_samples=9) for rng in streams
    ]


def test_the_checker_computes_the_digests_that_a_log_names() -> None:
    for problem in problems():
        assert checker_question(problem).digests() == (data_digest(problem), question_digest(problem))


def test_every_limit_of_the_trees_is_part_of_what_is_asked() -> None:
    old = {"old_tree": Split(0, 0.5, Leaf(0), Leaf(1))}
    limits = [{}, {"leaf_weight": 2.0}, {"max_splits": 1}, old | {"max_changes": 0}, old | {"max_changes": 1}]
    asked = [Problem([[0.0], [1.0], [2.0]], [0, 1, 0], depth=2, **some) for some in limits]
    assert len(set(map(question_digest, asked))) == len(asked)


def test_a_file_holds_every_number_to_the_last_bit() -> None:
    for problem in problems():
        file = json.loads(json.dumps(encode(problem), allow_nan=False))
        assert np.array_equal(file["features"], problem.samples.features)
        assert np.array_equal(file["weights"], problem.samples.weights)
        assert np.array_equal(file["costs"], problem.costs)
        assert file["labels"] == problem.samples.codes.tolist()
        assert file["sensor_limit"] == (problem.shape.sensor_limit if np.isfinite(problem.shape.sensor_limit) else None)


@pytest.mark.skipif(shutil.which("cargo") is None, reason="cargo, which builds octmip-check, is missing")
def test_no_mangled_pair_of_files_is_accepted_for_more_than_is_true():
    command = check_command.built()
    outcomes = {seed: check_command.corrupted(seed, command)[1] for seed in range(5)}
    assert not {seed: outcome for seed, outcome in outcomes.items() if outcome not in ("refused", "true")}
