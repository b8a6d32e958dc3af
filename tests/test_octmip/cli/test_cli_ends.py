"""Streams that are closed or full lose nothing that a command found, and their failure is one sentence."""

import multiprocessing
import os
import resource
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.cases.command import signals
from octmip.interfaces.cli import main
from octmip.interfaces.cli.program import COMMANDS

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
    "completion": ("bash",),
}
SAYS_BESIDE = ("predict", "report")
"""What they make is their file; nothing is left for standard output."""
CLOSED, FULL = "closed", "full"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table, a folder of it, a tree with its proof, a campaign and its twin."""
    folder = tmp_path_factory.mktemp("ends")
    rng = np.random.default_rng(0)
    table = pd.DataFrame(rng.normal(size=(60, 2)).round(2), columns=["a", "b"]).assign(y=rng.integers(0, 2, 60))
    (folder / "tables").mkdir()
    for path in (folder / DATA, folder / "tables" / DATA):
        table.to_csv(path, index=False)
    kept = ["--out", str(folder / "tree.json"), "--proof", str(folder / "proof.log"), "--json"]
    assert main(["solve", str(folder / DATA), *DEPTH, *kept]) == 0
    (folder / "asset.py").write_text(signals.TWIN.replace("20000", "1"))
    loads = np.repeat([0.0, 0.5, 1.0], 10)
    readings = loads[:, None] * np.arange(1.0, 7.0) + rng.normal(0.0, 0.01, (30, 6))
    columns = {"test": np.repeat([0, 1, 2], 10), "load_factor": loads, "time": np.arange(30.0)}
    frame = pd.DataFrame(columns | {f"g{k}": readings[:, k] for k in range(6)})
    frame.to_csv(folder / "campaign.csv", index=False)
    return folder


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


@pytest.mark.skipif(sys.platform != "linux", reason="Linux keeps a limit of address space")
@pytest.mark.parametrize(("command", "megabytes"), [("solve", 450), ("compare", 700), ("report", 450)])
def test_a_process_that_gets_no_more_memory_has_its_result_or_one_sentence(
    command: str, megabytes: int, folder: Path
) -> None:
    words = [sys.executable, "-m", "octmip.interfaces.cli", command, *WORDS[command]]
    wanted = {**os.environ, "OMP_NUM_THREADS": "2"}
    wanted.pop("OPENBLAS_NUM_THREADS", None)
    (folder / "new").mkdir(exist_ok=True)

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (megabytes << 20, megabytes << 20))

    ran = subprocess.run(words, cwd=folder, env=wanted, preexec_fn=limit, capture_output=True, text=True, timeout=300)
    is_result = (ran.returncode, bool(made(folder / "new")) or bool(ran.stdout)) == (0, True)
    assert is_result or (ran.returncode == 1 and ran.stderr.splitlines()[-1].startswith("octmip: out of memory"))
    assert "Traceback" not in ran.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="a full disk is /dev/full")
@pytest.mark.parametrize("command", COMMANDS)
def test_streams_that_fail_lose_no_file_and_are_one_sentence(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    (folder / "new").mkdir(exist_ok=True)
    assert main([command, *WORDS[command]]) == 0  # what it imports is there for its children
    out, err = capsys.readouterr()
    files, shows = made(folder / "new"), command not in SAYS_BESIDE
    assert (bool(out), bool(files)) == (shows, "new/made" in " ".join(WORDS[command]))
    for end in (CLOSED, FULL):
        code, _, words, kept = ended(command, folder, {1: end})
        assert (code, kept) == (int(shows), files)
        assert len(words.splitlines()) == len(err.splitlines()) + shows
        assert not shows or words.splitlines()[-1].startswith("octmip: standard output cannot be written (")
        code, shown, _, kept = ended(command, folder, {2: end})
        assert (code, kept) == (0, files)
        assert len(shown.splitlines()) == len(out.splitlines())
