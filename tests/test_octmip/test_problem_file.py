"""Problem files and digests: what a program without Python reads is the problem that was asked."""

import json

import numpy as np

from octmip import Leaf, Problem, Split
from octmip.trees.evidence.proof import checker_question
from octmip.trees.question.problem_file import data_digest, encode, question_digest
from tests.oracles.strategies import random_problem
from tests.oracles.two_feature_problems import random_two_feature_problem


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
