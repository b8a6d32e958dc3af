"""The checker with a theorem: it is built, its theorem rests on no axiom, and it says what octmip-check says.

Skipped where Coq, OCaml or Zarith is missing.
"""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cases.fuzz.verified import PROGRAM, agree, compared, verdict
from octmip import Problem
from octmip.errors import CertificateError
from octmip.trees.evidence.proof import check_proof, proof_header
from octmip.trees.question.problem_file import write_problem_file

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "octmip" / "trees" / "verified"


def missing() -> str:
    """Return the tools that are not there."""
    tools = [tool for tool in ("coqc", "ocamlfind", "make") if shutil.which(tool) is None]
    if not tools and subprocess.run(["ocamlfind", "query", "zarith"], capture_output=True, check=False).returncode:
        tools = ["zarith"]
    return ", ".join(tools)


pytestmark = pytest.mark.skipif(bool(missing()), reason=f"not installed: {missing()}")


@pytest.fixture(scope="module", autouse=True)
def build() -> str:
    """Build the checker, and return what the build says."""
    done = subprocess.run(["make", "-C", FOLDER], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def stripes(n: int, depth: int, **options: object) -> Problem:
    """Return samples in the order of one feature, of classes 0 and 1 in turn."""
    return Problem(np.arange(n, dtype=float)[:, None], np.arange(n) % 2, depth=depth, **options)


def two_sensors() -> Problem:
    """Return four stripes and a feature of one value; one of their two sensors can be paid for."""
    features = [[float(i), 0.0] for i in range(4)]
    return Problem(features, [0, 1, 0, 1], depth=1, sensor_budget=1.0)


SIDES = "L|N 2 1 1|F 0 2 1|E|R|N 2 1 1|F 0 2 1|E"
HALVES = {"leaf_penalty": 1.5}
TWOS = {"leaf_size": 2}
# Problem, claim, body of the log, and whether it proves the claim: docs/theory/proof.md has the inequalities.
WRITTEN = [
    (stripes(4, 1), 1, "N 1 1 1|E", True),
    (stripes(4, 1), 2, "N 1 1 2|E", False),
    (stripes(4, 1), 1, "N 1 1 0|E", False),
    (stripes(4, 1), 1, "N 1 1 1", False),
    (stripes(4, 1), 1, "N 1 1 1|E|E", False),
    (stripes(4, 1, **TWOS), 2, "N 1 2 2|E", True),
    (stripes(4, 1, **HALVES), 1, "N 1 1 1|E", True),
    (stripes(6, 2), 1, "N 2 1 1|F 0 3|E", True),
    (stripes(6, 2), 1, "N 2 1 1|F 0 2 1 1|E", True),
    (stripes(6, 2), 2, "N 2 1 2|F 0 3|E", False),
    (stripes(6, 2), 1, "N 2 1 1|E", False),
    (stripes(6, 2), 1, "N 2 1 1|F 7 3|E", False),
    (stripes(6, 2), 1, "N 2 1 1|F 0 6|E", False),
    (stripes(6, 2), 1, f"N 2 1 1|F 0 3 {2**63 - 1}|E", False),
    (stripes(10, 3), 1, f"N 3 1 1|K 0 5|{SIDES}|E", True),
    (stripes(10, 3), 1, f"N 3 1 1|B|N 2 1 1|F 0 3|E|K 0 5|{SIDES}|E", True),
    (stripes(10, 3), 1, "N 3 1 1|K 0 5|L|N 2 1 1|F 0 2 1|E|E", False),
    (two_sensors(), 1, "S 0|N 1 1 2|E|N 1 1 1|E", True),
    (two_sensors(), 1, "S 0|S 0", False),
    (two_sensors(), 1, "S 2", False),
    (two_sensors(), 1, "S 0|N 1 1 2|E", False),
    (two_sensors(), 2, "N 1 1 2|E", False),
]


@pytest.mark.parametrize(("problem", "claim", "body", "is_good"), WRITTEN)
def test_logs_written_by_hand_are_judged_as_octmip_check_does(problem, claim, body, is_good, tmp_path):
    log = tmp_path / "proof.log"
    log.write_text(proof_header(problem, (0, 0), claim) + body.replace("|", "\n") + "\nend\n")
    own = verdict(problem, log)
    assert own.is_accepted == is_good
    if is_good:
        assert own.words == repr(check_proof(problem, log).bound)
    else:
        with pytest.raises(CertificateError, match=re.escape(own.words)):
            check_proof(problem, log)


def test_both_checkers_say_the_same_of_forty_logs():
    pairs = [compared(seed) for seed in range(40)]
    assert not [pair for pair in pairs if not agree(pair)]
    assert 8 < sum(one.is_accepted for _, one, _ in pairs) < 32


@pytest.mark.parametrize("seed", [863, 1930, 1935])
def test_logs_that_need_sets_of_labels_are_accepted(seed):
    kind, one, other = compared(seed)
    assert kind == "whole"
    assert one.is_accepted
    assert one == other


def test_the_theorem_rests_on_no_axiom():
    text = "\n".join(file.read_text() for file in sorted(FOLDER.rglob("*/*.v")) if "build" not in file.parts)
    assert "Theorem accepted_bounds_hold" in text
    assert not re.findall(r"\b(?:Admitted|admit|Axiom|Axioms|Parameter|Conjecture|give_up)\b", text)
    asked = "From octmip Require Import Soundness. Print Assumptions accepted_bounds_hold."
    (FOLDER / "build" / "asked.v").write_text(asked)
    done = subprocess.run(
        ["coqc", "-Q", ".", "octmip", "asked.v"], cwd=FOLDER / "build", capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "Closed under the global context"


def test_the_page_states_the_theorem_as_it_stands_in_the_source():
    page = (ROOT / "docs" / "theory" / "proofs" / "verified.md").read_text()
    stated = re.findall(r"```coq\n(.*?)```", page, flags=re.DOTALL)
    text = "\n".join(file.read_text() for file in sorted(FOLDER.rglob("*/*.v")))
    assert len(stated) == 3
    assert all(part.strip() in text for part in stated)


def test_files_that_cannot_be_used_end_with_2(tmp_path):
    log, file = tmp_path / "proof.log", tmp_path / "problem.json"
    log.write_text("end\n")
    write_problem_file(file, Problem([[0.0], [1.0]], [0, 1], depth=1, split="hyperplane"))
    runs = [
        ([log], "got 1 arguments, expected 2; usage: octmip-verified LOG PROBLEM.json"),
        ([tmp_path / "none.log", file], "expected a proof log of octmip solve --proof; check the path"),
        ([log, log], "expected a problem file; write it again with octmip solve --write-problem"),
        ([log, file], "the trees have hyperplane splits"),
    ]
    for arguments, words in runs:
        done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout) == (2, "")
        assert words in done.stderr
