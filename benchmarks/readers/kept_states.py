"""The readers of what a search keeps: checkpoints, and the proof logs of regression trees."""

import hashlib
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.readers.file_reader import Reader, run
from benchmarks.readers.mangling import Generator, mangled_bytes, mangled_json, mangled_tokens
from octmip.certificate import certify
from octmip.methods.checkpoint import FIRST
from octmip.methods.exact import branch_and_bound
from octmip.problem import Problem
from octmip.proof import check_proof
from octmip.regression.exact import exact_regression
from octmip.regression.problem import RegressionProblem
from octmip.solution import Limits


def _searched(number: int) -> Problem:
    """Return a problem whose search does not end at its first node: odd numbers have sensors and a budget."""
    rng = np.random.default_rng([93, number])
    features, labels = rng.integers(0, 40, (60, 4)).astype(float), rng.integers(0, 3, 60)
    if number % 2 == 0:
        return Problem(features, labels, depth=2)
    return Problem(features, labels, depth=2, sensor_cost=[1, 1, 1, 1], sensor_budget=2)


def make_checkpoint(number: int, folder: Path) -> None:
    """Write the checkpoint of a search that a limit ended."""
    branch_and_bound(_searched(number), limits=Limits(seconds=0), checkpoint=folder / f"{number}.kept")
    (folder / f"{number}.kept").rename(folder / "search.kept")
    (folder / "number").write_text(str(number))


def mangled_checkpoint(rng: Generator, content: bytes) -> bytes:
    """Return a checkpoint with entries of its second line changed: by accident, or by somebody who corrects the sum."""
    first, _, line = content.removesuffix(b"\n").partition(b"\n")
    changed = mangled_json(rng, line) if rng.random() < 0.8 else mangled_bytes(rng, line)
    if rng.random() < 0.8:
        first = f"{FIRST} {hashlib.sha256(changed).hexdigest()}".encode()
    return first + b"\n" + changed + b"\n"


def read_kept(rng: Generator, folder: Path) -> None:
    """Go on from a checkpoint to the end, and certify what is found; a forger's bound is believed, as its docs say."""
    problem = _searched(int((folder / "number").read_text()))
    certify(problem, branch_and_bound(problem, limits=Limits(seconds=2), checkpoint=folder / "search.kept"))


def make_regression_log(number: int, folder: Path) -> None:
    """Write a regression tree, the log of its bound and its table; odd numbers count absolute errors."""
    rng = np.random.default_rng([94, number])
    frame = pd.DataFrame(rng.normal(size=(16, 2)).round(2), columns=["a", "b"]).assign(y=rng.integers(0, 5, 16))
    frame.to_csv(folder / "table.csv", index=False)
    words = ("--target", "y", "--depth", 2, "--loss", "absolute" if number % 2 else "squared")
    run("solve", folder / "table.csv", *words, "--out", folder / "tree.json", "--proof", folder / "proof.log")
    (folder / "number").write_text(str(number))


def read_regression_log(rng: Generator, folder: Path) -> None:
    """Check a log, or have it checked by the command: what is accepted is below the least loss."""
    if rng.random() < 0.1:
        run("certify", folder / "tree.json", folder / "table.csv", "--proof", folder / "proof.log")
    frame = pd.read_csv(folder / "table.csv")
    features, targets = frame[["a", "b"]].to_numpy(), frame["y"].to_numpy()
    is_odd = int((folder / "number").read_text()) % 2
    problem = RegressionProblem(features, targets, depth=2, loss="absolute" if is_odd else "squared")
    bound = check_proof(problem, folder / "proof.log").bound
    assert bound <= exact_regression(problem).objective * (1 + 1e-12)


KEPT = {
    "checkpoint": Reader(make_checkpoint, "search.kept", mangled_checkpoint, read_kept),
    "regression proof log": Reader(make_regression_log, "proof.log", mangled_tokens, read_regression_log),
}
