"""Two-feature trees and their logs over the whole range of float64: bounds that were wrong, logs that were refused."""

from pathlib import Path
from typing import Any

import pytest

from octmip import Problem, Stop, certify
from octmip.errors import CertificateError
from octmip.interfaces.cli import main
from octmip.trees.answer.solution import ProofError
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from tests.oracles.rational import least_cost

# Features, labels, options of small problems; the name says what was wrong.
CASES: dict[str, tuple[list[list[float]], list[int], dict[str, Any]]] = {
    # An empty side was learnt to cost as much as was asked of it, and with it every set of samples.
    "one split is the optimum but two were proven": (
        [
            [1.7976931348623157e308, 0.10000000000000002],
            [1e-13, -0.0],
            [0.9999999999999999, 2.0],
            [0.9999999999999999, 2.0],
            [5e-324, 0.09999999999999999],
            [1e-300, -5e-324],
            [-1e300, 2.0000000000000004],
        ],
        [0, 0, 0, 1, 1, 1, 1],
        {"weights": [7.0, 6.0, 10.0, 9.0, 6.0, 7.0, 8.0], "leaf_penalty": 0.5, "class_names": (0, 1)},
    ),
    "values from 1e-190 to 1e141": (
        [
            [4.0, -6.716626944277633e-87],
            [1.0, -1.1172399968126179e83],
            [5.0, -1.3237868910387924e-184],
            [5.0, 9.289304146671652e92],
            [3.0, 8.075412053833495e141],
            [0.0, 8.832015700196747e-191],
        ],
        [0, 2, 1, 2, 3, 0],
        {},
    ),
    "the least numbers there are": (
        [[-1e-323, -5e-324], [2e-323, 1e-323], [1e-323, 5e-324], [-2e-323, -1e-323], [3e-323, 1.5e-323], [0, 0]],
        [0, 2, 0, 2, 1, 1],
        {},
    ),
    "thirty points on one line, half of them of each class": (
        [[k / 8, 1e-200 * k] for k in range(30)],
        [k % 2 for k in range(30)],
        {"depth": 1},
    ),
}


UNPROVEN = (
    "one split is the optimum but two were proven",
    "values from 1e-190 to 1e141",
    "thirty points on one line, half of them of each class",
)


def problem_of(case: str) -> Problem:
    features, labels, options = CASES[case]
    options = {"depth": 2, "split": "hyperplane", "split_size": 2, "class_names": tuple(range(5))} | options
    return Problem(features, labels, **options)


@pytest.mark.parametrize("case", CASES)
def test_the_bound_is_true_and_its_log_is_accepted(case: str, tmp_path: Path) -> None:
    problem = problem_of(case)
    solution = two_feature_branch_and_bound(problem, options=ExactOptions(proof=tmp_path / "log"))
    certify(problem, solution)
    optimum = float(least_cost(problem)) if problem.samples.n_samples < 20 else 14.0
    assert solution.bound <= optimum <= solution.objective
    assert solution.stop is (Stop.NUMERICS if case in UNPROVEN else Stop.OPTIMAL)
    assert solution.details["numerically_undecided"] == (case in UNPROVEN)
    assert check_proof(problem, tmp_path / "log", bound=solution.bound).bound == solution.bound


def test_a_tolerance_that_a_sample_could_hide_in_proves_nothing() -> None:
    problem = Problem(
        [[0, 0], [1, 1], [2, 0], [3, 1]], [0, 1, 0, 1], weights=[1e17, 1e-9, 3e17, 0.1], depth=1, split="hyperplane"
    )
    solution = two_feature_branch_and_bound(problem)
    certify(problem, solution)
    assert (solution.is_optimal, solution.tolerance) == (True, 0)


def test_a_bound_of_more_digits_than_float64_holds_is_rounded_down() -> None:
    # One leaf is wrong by 2^54 + 2 + 1, which float64 would round up.
    problem = Problem(
        [[0, 0], [0, 0], [0, 0], [1, 1]],
        [0, 1, 1, 1],
        weights=[2.0**55, 2.0**54 + 4, 3.0, 0.5],
        depth=1,
        split="hyperplane",
        leaf_penalty=2.0**56,
    )
    solution = two_feature_branch_and_bound(problem)
    assert int(2 * solution.bound) <= 2 * (2**54 + 4 + 3) + 1


def test_a_log_that_the_checker_refuses_is_not_written_and_the_solution_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise CertificateError("line 7: a child is not proven to cost 5")

    monkeypatch.setattr("octmip.trees.methods.two_feature.check_proof", refuse)
    problem = problem_of("the least numbers there are")
    path = tmp_path / "proof.log"
    with pytest.raises(ProofError, match=r"not written: expected a log of the bound .*not proven to cost 5"):
        two_feature_branch_and_bound(problem, options=ExactOptions(proof=path))
    assert list(tmp_path.iterdir()) == []
    table, tree = tmp_path / "data.csv", tmp_path / "tree.json"
    table.write_text("a,b,y\n0,0,x\n1,0,z\n0,1,z\n1,1,x\n")
    words = ["--label", "y", "--depth", "1", "--split", "hyperplane", "--split-size", "2", "--method", "exact"]
    code = main(["solve", str(table), *words, "--proof", str(path), "--out", str(tree)])
    said = capsys.readouterr()
    assert code == 1
    assert tree.exists()
    assert not path.exists()
    assert "samples wrong" in said.out
    assert "proof.log is not written" in said.err
