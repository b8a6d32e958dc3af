"""octmip solve --proof FILE.pbp and octmip certify --veripb, with a stand-in for the checker where it matters."""

import json
import shutil

import pytest

from benchmarks.oracles.cutting_planes import verified_bounds


@pytest.fixture
def proven(data, run, tmp_path):
    """Return a tree file and the proof of its bound."""
    tree, proof = tmp_path / "tree.json", tmp_path / "proof.pbp"
    words = ("--label", "y", "--depth", 2, "--features", "a,b", "--leaf-penalty", 1, "--out", tree, "--proof", proof)
    code, out, err = run("solve", data, *words)
    assert code == 0, err
    assert "proven optimal" in out
    return tree, proof


def put_on_path(monkeypatch, tmp_path, output):
    """Put a program of the checker's name on the path that only prints."""
    program = tmp_path / "veripb"
    program.write_text(f"#!/bin/sh\nprintf '{output}'\n")
    program.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda name: str(program))


def test_the_command_writes_formula_and_proof(proven):
    tree, proof = proven
    solution = json.loads(tree.read_text())["solution"]
    found = verified_bounds(proof.with_suffix(".opb").read_text(), proof.read_text())
    assert found == (solution["objective"], solution["objective"])


def test_certify_reports_what_the_checker_verified(proven, data, run, tmp_path, monkeypatch):
    tree, proof = proven
    whole = int(json.loads(tree.read_text())["solution"]["objective"])
    verdict = f"Running VeriPB version 3.0.2\\ns VERIFIED BOUNDS {whole} <= obj <= {whole}\\n"
    put_on_path(monkeypatch, tmp_path, verdict)
    code, out, err = run("certify", tree, data, "--veripb", proof)
    assert code == 0, err
    assert f"veripb 3.0.2: no tree costs less than {whole}, and the tree costs {whole}" in out
    report = json.loads(run("certify", tree, data, "--veripb", proof, "--json")[1])["veripb"]
    assert (report["bound"], report["objective"], report["checker"]) == (whole, whole, "veripb 3.0.2")


def test_the_proof_of_another_table_is_refused(proven, data, run):
    tree, proof = proven
    formula = proof.with_suffix(".opb")
    formula.write_text(formula.read_text().replace("min: 1 w0_0", "min: 2 w0_0"))
    code, _, err = run("certify", tree, data, "--veripb", proof)
    assert code == 1
    assert "is not the formula of this problem; the proof is refused" in err


def test_without_the_checker_a_sentence_says_what_to_install(proven, data, run, monkeypatch):
    tree, proof = proven
    monkeypatch.setattr(shutil, "which", lambda name: None)
    code, _, err = run("certify", tree, data, "--veripb", proof)
    assert code != 0
    assert "install it by cargo install veripb --version 3.0.2" in err


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--label", "y", "--depth", 3), "depth 3 with split 'axis' has no pseudo-Boolean proof"),
        (("--label", "y", "--depth", 2, "--split", "hyperplane", "--method", "exact"), "has no pseudo-Boolean proof"),
        (("--target", "b", "--depth", 1), "is for classes, but --target asks for numbers"),
    ],
)
def test_what_has_no_such_proof_is_refused_before_the_search(words, reason, data, run, tmp_path):
    code, _, err = run("solve", data, *words, "--proof", tmp_path / "x.pbp")
    assert code == 2
    assert reason in err
    assert not list(tmp_path.glob("x.*"))
