"""What a killed process leaves: proofs that go on from their checkpoints, files that are whole or not there.

Runs: `octmip solve --checkpoint` of each of `RUNS` (a proof, a two-feature proof) is killed (SIGKILL) at a
random moment of its life, started again, killed again, five times, and then left to its end: tree, objective, bound and
stop must be those of a run that nobody killed. Ten such chains of the proof are fifty kills, four of the other
twenty. Files: a process that writes one kind of file again and again is killed at a random moment, fifty times a kind:
the file must be whole, as a reader finds it, or not be there.
"""

import contextlib
import json
import multiprocessing
import random
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from benchmarks.data import uci
from benchmarks.readers.femlib import make_stream
from benchmarks.tables import Line
from femlib.files import whole_file
from octmip.formats.table import read_table
from octmip.formats.tree_file import read_tree_file, record_tree, write_tree_file
from octmip.input.files import write_bytes
from octmip.interfaces.cli import main
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.methods.checkpoint.file import CheckpointFile
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve

KILLS_A_CHAIN, N_KILLS = 5, 50


class Case(NamedTuple):
    """A run that is killed: its name, set, arguments, and number of chains of kills."""

    name: str
    data: str
    words: tuple[str, ...]
    n_chains: int


LINES = ("--split", "hyperplane", "--split-size", "2")
RUNS = (
    Case("proof of mammography, depth 4", "mammography", ("--depth", "4"), 10),
    Case(
        "two-feature proof of blood-transfusion", "blood-transfusion", (*LINES, "--depth", "2", "--method", "exact"), 4
    ),
)

FORK = multiprocessing.get_context("fork")
"""Processes that have imported all: a kill shall meet the work, not the start."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chain of kills, and for each kind of file; there is no limit, one process at a time."""
    for case in RUNS:
        yield from chains(case)
    for kind in WRITERS:
        bad = [seed for seed in range(N_KILLS) if not is_whole_or_absent(kind, seed)]
        yield {"size": f"file: {kind}", "seed": 0, "kills": N_KILLS, "bad": len(bad), "seeds": bad}


def chains(case: Case) -> Iterator[Line]:
    """Yield a line for each chain of kills of a run, each within half of the life of one that nobody kills."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_data(case.data, folder / "data.csv")
        began = time.perf_counter()
        whole = Proof(folder, case.words).end()
        life = time.perf_counter() - began
        for chain in range(case.n_chains):
            proof = Proof(folder, case.words, folder / f"kept{chain}")
            rng = random.Random(chain)
            lived = [proof.killed_after(rng.uniform(0.0, life / 2)) for _ in range(KILLS_A_CHAIN)]
            last = proof.end()
            same = all(last[key] == whole[key] for key in ("tree", "objective", "bound", "stop"))
            yield {"size": case.name, "seed": chain, "kills": sum(lived), "bad": int(not same), "seconds": life}


def write_data(name: str, path: Path) -> None:
    """Write a public set as a table with the label column "label"."""
    table = uci(name)
    columns = [f"x{j}" for j in range(table.features.shape[1])]
    pd.DataFrame(table.features, columns=columns).assign(label=table.labels).to_csv(path, index=False)


class Proof:
    """A run of the command, in a process of its own."""

    def __init__(self, folder: Path, words: Sequence[str], kept: Path | None = None) -> None:
        checkpoint = [] if kept is None else ["--checkpoint", str(kept), "--option", "every=0.2"]
        data = str(folder / "data.csv")
        self._words = ["solve", data, "--label", "label", "--seconds", "3600", "--json", *words, *checkpoint]
        self._out = folder / "out.json"

    def _start(self) -> BaseProcess:
        running = FORK.Process(target=_command, args=(self._words, self._out))
        running.start()
        return running

    def killed_after(self, seconds: float) -> bool:
        """Start it and kill it so many seconds later; whether it still lived."""
        running = self._start()
        running.join(seconds)
        is_alive = running.is_alive()
        running.kill()
        running.join()
        return is_alive

    def end(self) -> dict[str, Any]:
        """Let it come to its end, and return what it prints."""
        self._start().join()
        found: dict[str, Any] = json.loads(self._out.read_text())
        return found


def _command(words: list[str], out: Path) -> None:
    with out.open("w") as file, contextlib.redirect_stdout(file):
        main(words)


# Kinds of files, and how they are written.


def _tree(path: Path, rng: Any) -> None:
    problem = Problem(rng.normal(size=(3000, 6)), rng.integers(0, 3, 3000), depth=8)
    write_tree_file(path, record_tree(problem, greedy_tree(problem), "y", None))


def _log(path: Path, rng: Any) -> None:
    branch_and_bound(
        Problem(rng.integers(0, 30, (80, 4)).astype(float), rng.integers(0, 3, 80), depth=2),
        options=ExactOptions(proof=path),
    )


def _checkpoint(path: Path, rng: Any) -> None:
    fixed = type(rng)(type(rng.bit_generator)(7))
    problem = Problem(fixed.integers(0, 90, (200, 5)).astype(float), fixed.integers(0, 3, 200), depth=3)
    solve(problem, "exact", options=ExactOptions(checkpoint=path, every=0.0))


def _dataset(path: Path, rng: Any) -> None:
    make_stream(0, path.parent)


def _page(path: Path, rng: Any) -> None:
    write_bytes(path, b"<html>" + rng.bytes(2_000_000).hex().encode() + b"</html>")


def _deck(path: Path, rng: Any) -> None:
    with whole_file(path) as temporary:
        temporary.write_bytes(b"x" * 1_000_000 + b"\n9999\n")


WRITERS: Mapping[str, Callable[[Path, Any], None]] = {
    "tree": _tree,
    "proof log": _log,
    "checkpoint": _checkpoint,
    "dataset": _dataset,
    "page": _page,
    "deck": _deck,
}


def _is_whole_page(path: Path) -> bool:
    content = path.read_bytes()
    return content.startswith(b"<html>") and content.endswith(b"</html>") and len(content) == 4_000_013


READERS: Mapping[str, Callable[[Path], object]] = {
    "tree": read_tree_file,
    "proof log": lambda path: path.read_text().endswith("end\n"),
    "checkpoint": lambda path: CheckpointFile(path, is_study=True).find({}) == {},
    "dataset": lambda path: read_table(path).columns,
    "page": _is_whole_page,
    "deck": lambda path: path.read_bytes().endswith(b"\n9999\n"),
}
NAMES = {"dataset": "data.parquet"}


def _write_forever(kind: str, path: Path) -> None:
    rng = np.random.default_rng(0)
    while True:
        WRITERS[kind](path, rng)


def is_whole_or_absent(kind: str, seed: int) -> bool:
    """Kill a process that writes files of a kind at a random moment; whether its file is whole or not there."""
    rng = random.Random(1000 + seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / NAMES.get(kind, "file")
        running = FORK.Process(target=_write_forever, args=(kind, path))
        running.start()
        running.join(rng.uniform(0.0, 0.5))
        running.kill()
        running.join()
        if not path.exists():
            return True
        try:
            return READERS[kind](path) is not False
        except Exception:  # whatever a reader says of half a file
            return False


def summary(lines: Sequence[Line]) -> str:
    """Return kills and what they broke, a row for each run and for each kind of file."""
    rows = []
    for case in RUNS:
        own = [line for line in lines if line["size"] == case.name]
        kills, bad = (sum(line[key] for line in own) for key in ("kills", "bad"))
        rows.append({"what": f"{case.name}, {len(own)} chains", "kills": kills, "bad": bad})
    files = [line for line in lines if line["size"].startswith("file: ")]
    rows += [{"what": line["size"], "kills": line["kills"], "bad": line["bad"]} for line in files]
    return markdown_table(rows)
