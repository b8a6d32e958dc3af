"""The readers of what a search keeps: checkpoints, and the proof logs of regression trees."""

import base64
import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.readers.file_reader import Reader, run
from benchmarks.readers.mangling import Generator, mangled_bytes, mangled_json, mangled_tokens
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Limits
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.checkpoint.file import summed
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.losses import AbsoluteError, SquaredError
from octmip.trees.question.problem import Problem
from octmip.trees.regression.exact import exact_regression
from octmip.trees.solver import solve

N_AXIS = 4
"""Problems of axis-aligned trees; as many are over lines."""


def _problem(number: int) -> Problem:
    """Return a problem whose search does not end at its first node: over lines from 4 on, odd ones with a budget."""
    rng = np.random.default_rng([93, number])
    budget: dict[str, Any] = {"sensor_budget": 2} if number % 2 else {}
    if number < N_AXIS:
        return Problem(rng.integers(0, 40, (60, 4)).astype(float), rng.integers(0, 3, 60), depth=3, **budget)
    lines: dict[str, Any] = {"depth": 2, "split": "hyperplane", "split_size": 2, "leaf_penalty": 0.5 * (number % 2)}
    return Problem(rng.normal(size=(40, 3)).round(2), rng.integers(0, 3, 40), **lines, **budget)


def make_checkpoint(number: int, folder: Path) -> None:
    """Write the checkpoint of a search that a limit ended."""
    limits = Limits(seconds=0) if number < N_AXIS else Limits(nodes=130)
    solve(_problem(number), "exact", limits, options=ExactOptions(checkpoint=folder / "search.kept"))
    (folder / "number").write_text(str(number))


def mangled_checkpoint(rng: Generator, content: bytes) -> bytes:
    """Return a checkpoint with entries or packed nodes changed: by accident, or by somebody who corrects the sum."""
    first, line, _ = content.split(b"\n")
    _, asked, entry = line.split(b" ", 2)
    packed = json.loads(entry)["state"].get("packed")
    if packed is not None and rng.random() < 0.6:
        state = zlib.compress(mangled_bytes(rng, zlib.decompress(base64.b85decode(packed))))
        entry = entry.replace(packed.encode(), base64.b85encode(state))
    else:
        entry = mangled_json(rng, entry) if rng.random() < 0.8 else mangled_bytes(rng, entry)
    rest = asked + b" " + entry.replace(b"\n", b"")
    if rng.random() < 0.8:
        line = summed(rest)
    return b"\n".join([first, line, b""])


def read_kept(rng: Generator, folder: Path) -> None:
    """Go on from a checkpoint to the end, and certify what is found; a forger's bound is believed, as its docs say."""
    problem = _problem(int((folder / "number").read_text()))
    options = ExactOptions(checkpoint=folder / "search.kept")
    certify(problem, solve(problem, "exact", Limits(seconds=2), options=options))


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
    problem = Problem(features, targets, depth=2, loss=AbsoluteError() if is_odd else SquaredError())
    bound = check_proof(problem, folder / "proof.log").bound
    assert bound <= exact_regression(problem).objective * (1 + 1e-12)


KEPT = {
    "checkpoint": Reader(make_checkpoint, "search.kept", mangled_checkpoint, read_kept, n_made=2 * N_AXIS),
    "regression proof log": Reader(make_regression_log, "proof.log", mangled_tokens, read_regression_log),
}
