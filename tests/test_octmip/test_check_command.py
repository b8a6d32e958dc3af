"""`octmip-check` reads mangled logs and problem files: refused in one line, or accepted for what is true."""

import shutil

import pytest

from benchmarks.cases.fuzz.check_command import built, corrupted, run
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.problem_file import write_problem_file

pytestmark = pytest.mark.skipif(shutil.which("cargo") is None, reason="cargo, which builds octmip-check, is missing")

FEATURES, LABELS = [[0.0], [1.0], [2.0], [3.0]], ["a", "b", "a", "b"]


@pytest.fixture(scope="module")
def command():
    return built()


@pytest.mark.parametrize("first", [0])
def test_no_mangled_pair_of_files_is_accepted_for_more_than_is_true(first, command):
    outcomes = {seed: corrupted(seed, command)[1] for seed in range(first, first + 30)}
    assert not {seed: outcome for seed, outcome in outcomes.items() if outcome not in ("refused", "true")}


def test_a_log_of_a_million_nodes_within_nodes_is_refused_in_its_line(tmp_path, command):
    log, file = tmp_path / "proof.log", tmp_path / "problem.json"
    problem = Problem(FEATURES, LABELS, depth=30)
    branch_and_bound(Problem(FEATURES, LABELS, depth=1), options=ExactOptions(proof=log))
    write_problem_file(file, problem)
    lines = log.read_text().split("\n")
    lines[5:] = ["N 30 1 0", *["B"] * 1_000_000]
    log.write_text("\n".join(lines))
    code, out, _ = run(command, log, file)
    assert code == 1
    assert "line 3: got" in out
    digest = out.split('expected "')[1].split('"')[0]
    lines[2] = digest
    log.write_text("\n".join(lines))
    code, out, _ = run(command, log, file)
    assert code == 1
    assert 'line 8: got "B", expected N and 3 numbers' in out
