"""The readers of what a search keeps: checkpoints, and the proof logs of regression trees."""

import base64
import hashlib
import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.readers.file_reader import Reader, run
from benchmarks.readers.mangling import Generator, mangled_bytes, mangled_json, mangled_tokens
from octmip.trees.certificate import certify
from octmip.trees.losses import AbsoluteError, SquaredError
from octmip.trees.methods.checkpoint.file import FIRST
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.problem import Problem
from octmip.trees.proof import check_proof
from octmip.trees.regression.exact import exact_regression
from octmip.trees.solution import Limits


def _searched(number: int) -> Problem:
    """Return a problem whose search does not end at its first node: odd numbers have sensors and a budget."""
    rng = np.random.default_rng([93, number])
    features, labels = rng.integers(0, 40, (60, 4)).astype(float), rng.integers(0, 3, 60)
    if number % 2 == 0:
        return Problem(features, labels, depth=2)
    return Problem(features, labels, depth=2, sensor_cost=[1, 1, 1, 1], sensor_budget=2)


def make_checkpoint(number: int, folder: Path) -> None:
    """Write the checkpoint of a search that a limit ended."""
    branch_and_bound(
        _searched(number), limits=Limits(seconds=0), options=ExactOptions(checkpoint=folder / f"{number}.kept")
    )
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
    certify(
        problem,
        branch_and_bound(problem, limits=Limits(seconds=2), options=ExactOptions(checkpoint=folder / "search.kept")),
    )


def _lined(number: int) -> Problem:
    """Return a problem over lines: odd numbers have prices and a budget."""
    rng = np.random.default_rng([95, number])
    features, labels = rng.normal(size=(40, 3)).round(2), rng.integers(0, 3, 40)
    options: dict[str, Any] = {"leaf_penalty": 0.5, "sensor_budget": 2} if number % 2 else {}
    return Problem(features, labels, depth=2, split="hyperplane", split_size=2, **options)


def make_lines_checkpoint(number: int, folder: Path) -> None:
    """Write the checkpoint of a two-feature proof that a limit ended."""
    two_feature_branch_and_bound(
        _lined(number), limits=Limits(nodes=130), options=ExactOptions(checkpoint=folder / "lines.kept")
    )
    (folder / "number").write_text(str(number))


def mangled_nodes(rng: Generator, content: bytes) -> bytes:
    """Return a checkpoint with bytes of its nodes changed by somebody who packs them again, or any other entry."""
    if rng.random() < 0.4:
        return mangled_checkpoint(rng, content)
    entries = json.loads(content.split(b"\n")[1])
    state = mangled_bytes(rng, zlib.decompress(base64.b85decode(entries["nodes"][0])))
    entries["nodes"][0] = base64.b85encode(zlib.compress(state)).decode("ascii")
    line = json.dumps(entries).encode()
    return f"{FIRST} {hashlib.sha256(line).hexdigest()}\n".encode() + line + b"\n"


def read_lines_kept(rng: Generator, folder: Path) -> None:
    """Go on from the checkpoint of a two-feature proof, and certify the tree."""
    problem = _lined(int((folder / "number").read_text()))
    certify(
        problem,
        two_feature_branch_and_bound(
            problem, limits=Limits(seconds=2), options=ExactOptions(checkpoint=folder / "lines.kept")
        ),
    )


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
    "checkpoint": Reader(make_checkpoint, "search.kept", mangled_checkpoint, read_kept),
    "regression proof log": Reader(make_regression_log, "proof.log", mangled_tokens, read_regression_log),
}
RESUMED = {"checkpoint of lines": Reader(make_lines_checkpoint, "lines.kept", mangled_nodes, read_lines_kept)}
"""Apart, as a reader's files are drawn by its place among all: this is the last."""
