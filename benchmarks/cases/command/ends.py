"""Every command beside streams that are closed or full, and in little memory: `python -m benchmarks.run command_ends`.

What is asked of an end: all that was found is in its file, and one sentence and the exit code 1 say what failed. A
closed or full standard error takes the words alone. In too little memory a command has its result, or one sentence.
"""

import multiprocessing
import os
import resource
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.campaign_files import write_campaign
from benchmarks.tables import Line
from octmip.interfaces.cli import main
from octmip.interfaces.cli.program import COMMANDS
from octmip.interfaces.report.markdown import markdown_table

FORK = multiprocessing.get_context("fork")
"""Processes that have imported all: the ends are tried, not the start."""
DATA, DEPTH, OUT = "data.csv", ("--label", "y", "--depth", "1"), ("--out", "new/made")
WORDS: Mapping[str, tuple[str, ...]] = {
    "solve": (DATA, *DEPTH, *OUT),
    "certify": ("tree.json", DATA, "--proof", "proof.log"),
    "predict": ("tree.json", DATA, "--label", "y", *OUT),
    "compare": ("tables", "--depth", "1", "--methods", "exact", *OUT),
    "near-optimal": (DATA, *DEPTH),
    "sensors": (DATA, *DEPTH, "--out", "new/made.svg"),
    "frontier": (DATA, *DEPTH, "--over", "depth", "--out", "new/made.svg"),
    "diagnose": ("campaign.csv", "--twin", "asset:Asset", *OUT),
    "monitor": ("--twin", "asset:Cracked", "--noise", "2", "--depth", "1", *OUT),
    "report": ("tree.json", DATA, "--out", "new/made.html"),
    "doctor": (),
}
SAYS_BESIDE = ("predict", "report")
"""What they make is their file; nothing is left for standard output."""
CLOSED, FULL = "closed", "full"
CANNOT = "octmip: standard output cannot be written ("


MEGABYTES = (300, 450, 600, 700)
GIVEN_UP = 120.0  # seconds


def prepare(folder: Path) -> None:
    """Write a table, a folder of it, a tree with its proof, a campaign and its twin."""
    rng = np.random.default_rng(0)
    table = pd.DataFrame(rng.normal(size=(60, 2)).round(2), columns=["a", "b"]).assign(y=rng.integers(0, 2, 60))
    (folder / "tables").mkdir()
    for path in (folder / DATA, folder / "tables" / DATA):
        table.to_csv(path, index=False)
    kept = ["--out", str(folder / "tree.json"), "--proof", str(folder / "proof.log"), "--json"]
    assert main(["solve", str(folder / DATA), *DEPTH, *kept]) == 0
    write_campaign(folder, rng, repeats=1)
    (folder / "new").mkdir()


def _run(command: str, folder: Path, ends: Mapping[int, str]) -> None:
    """Be the program, with standard output (1) and standard error (2) as `ends` say, else in files."""
    os.chdir(folder)
    for descriptor in (1, 2):
        os.close(descriptor)
    for descriptor in (1, 2):
        place = {CLOSED: os.devnull, FULL: "/dev/full"}.get(ends.get(descriptor, ""), f"said{descriptor}")
        held = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        assert held == descriptor
    for descriptor in (1, 2):
        if ends.get(descriptor) == CLOSED:
            os.close(descriptor)
    # As Python finds them at its start.
    sys.stdout, sys.stderr = (None if ends.get(k) == CLOSED else open(k, "w", closefd=False) for k in (1, 2))  # noqa: SIM115
    sys.argv = ["octmip", command, *WORDS[command]]
    sys.exit(main())


def ended(command: str, folder: Path, ends: Mapping[int, str]) -> tuple[int | None, str, str, list[str]]:
    """Return exit code, standard output, standard error and the files of a command."""
    running = FORK.Process(target=_run, args=(command, folder, ends))
    running.start()
    running.join()
    out, err = [(folder / f"said{k}").read_text() if k not in ends else "" for k in (1, 2)]
    return running.exitcode, out, err, made(folder / "new")


def made(new: Path) -> list[str]:
    """Return the files that a command made, and remove them."""
    paths = sorted(new.rglob("*"), reverse=True)
    names = [str(path.relative_to(new)) for path in paths if path.is_file()]
    for path in paths:
        path.rmdir() if path.is_dir() else path.unlink()
    return names


def limited(command: str, folder: Path, megabytes: int) -> str:
    """Return how a command ends whose process may take so many megabytes; what is wrong, in words."""
    words = [sys.executable, "-m", "octmip.interfaces.cli", command, *WORDS[command]]
    wanted = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    limit, wanted["OMP_NUM_THREADS"] = (megabytes << 20, megabytes << 20), "2"
    named: dict[str, Any] = {"cwd": folder, "env": wanted, "timeout": GIVEN_UP, "capture_output": True, "text": True}
    try:
        ran = subprocess.run(words, **named, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit))
    except subprocess.TimeoutExpired:
        return "does not end"
    files, said = made(folder / "new"), ran.stderr.splitlines()
    if ran.returncode == 0 and (files or ran.stdout):
        return "result"
    if ran.returncode == 1 and said and said[-1].startswith("octmip: out of memory") and "Traceback" not in ran.stderr:
        return "one sentence"
    is_told = command == "doctor" and ran.returncode == 1 and "FAULT" in ran.stdout
    return "result" if is_told else f"exit code {ran.returncode}: {ran.stderr[-200:]}"


def streamed(command: str, folder: Path, end: str) -> Iterator[tuple[str, str]]:
    """Yield each stream, and how a command ends where it is closed or full."""
    code, out, err, files = ended(command, folder, {})
    shows = command not in SAYS_BESIDE
    if code != 0 or (bool(out), bool(files)) != (shows, "new/made" in " ".join(WORDS[command])):
        yield "both streams", f"exit code {code}: {err[-200:]}"
        return
    code, _, said, kept = ended(command, folder, {1: end})
    lines = said.splitlines()
    is_told = not shows or lines[-1:] == [line for line in lines[-1:] if line.startswith(CANNOT)]
    is_right = (code, kept, len(lines)) == (int(shows), files, len(err.splitlines()) + shows)
    yield "standard output", ("one sentence" if shows else "result") if is_right and is_told else f"{code}: {said}"
    code, shown, _, kept = ended(command, folder, {2: end})
    is_right = (code, kept, len(shown.splitlines())) == (0, files, len(out.splitlines()))
    yield "standard error", "result" if is_right else f"{code}: {kept} of {files}"


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield a line for each command and end; `only` is a command."""
    with TemporaryDirectory() as name:
        prepare(folder := Path(name))
        for command in [only] if only else COMMANDS:
            for end in (CLOSED, FULL):
                for stream, outcome in streamed(command, folder, end):
                    yield {"size": command, "end": f"{stream} {end}", "outcome": outcome}
            for megabytes in MEGABYTES:
                outcome = limited(command, folder, megabytes)
                yield {"size": command, "end": f"{megabytes} MB", "outcome": outcome}


def summary(lines: Sequence[Line]) -> str:
    """Return a row for each end, and every line that is wrong."""
    rows = []
    for end in dict.fromkeys(line["end"] for line in lines):
        found = Counter(line["outcome"] for line in lines if line["end"] == end)
        right = {word: found.pop(word, 0) for word in ("result", "one sentence")}
        rows.append({"end": end, **right, "wrong": sum(found.values())})
    wrong = [line for line in lines if line["outcome"] not in ("result", "one sentence")]
    return "\n".join([markdown_table(rows), *(f"{line['size']}, {line['end']}: {line['outcome']}" for line in wrong)])
