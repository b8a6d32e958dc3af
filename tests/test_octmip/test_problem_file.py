"""Problem files and digests: what a program without Python reads is the problem that was asked."""

import json
from pathlib import Path

import numpy as np

from octmip import Leaf, Problem, Split
from octmip.interfaces.cli import main
from octmip.trees.problem_file import data_digest, encode, question_digest
from octmip.trees.proof import checker_question
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
        assert np.array_equal(file["features"], problem.features)
        assert np.array_equal(file["weights"], problem.weights)
        assert np.array_equal(file["costs"], problem.costs)
        assert file["labels"] == problem.codes.tolist()
        assert file["sensor_limit"] == (problem.sensor_limit if np.isfinite(problem.sensor_limit) else None)


def test_the_command_writes_problem_and_proof(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text("a,b,y\n0,0,x\n1,0,z\n0,1,z\n1,1,x\n")
    problem, log = tmp_path / "problem.json", tmp_path / "proof.log"
    words = ["--label", "y", "--depth", "1", "--proof", str(log), "--write-problem", str(problem)]
    assert main(["solve", str(tmp_path / "data.csv"), *words]) == 0
    file = json.loads(problem.read_text())
    asked = Problem([[0, 0], [1, 0], [0, 1], [1, 1]], ["x", "z", "z", "x"], depth=1, feature_names=("a", "b"))
    assert file == encode(asked)
    assert log.read_text().splitlines()[1:3] == [f"data {data_digest(asked)}", f"question {question_digest(asked)}"]
    assert main(["solve", str(tmp_path / "data.csv"), *words[:-1], str(tmp_path / "none" / "p.json")]) == 2
