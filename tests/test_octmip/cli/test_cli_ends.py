"""Streams that are closed or full lose nothing that a command found, and their failure is one sentence."""

import sys
from pathlib import Path

import pytest

from benchmarks.cases.command import ends
from octmip.interfaces.cli import main
from octmip.interfaces.cli.program import COMMANDS

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Linux keeps a limit of memory and has /dev/full")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the commands work on."""
    ends.prepare(made := tmp_path_factory.mktemp("ends"))
    return made


@pytest.mark.parametrize(("command", "megabytes"), [("solve", 450), ("monitor", 450), ("diagnose", 600)])
def test_a_process_that_gets_no_more_memory_has_its_result_or_one_sentence(
    command: str, megabytes: int, folder: Path
) -> None:
    assert ends.limited(command, folder, megabytes) in ("result", "one sentence")


@pytest.mark.parametrize(
    ("command", "end"),
    [*((command, ends.FULL) for command in COMMANDS), ("solve", ends.CLOSED), ("diagnose", ends.CLOSED)],
)
def test_streams_that_fail_lose_no_file_and_are_one_sentence(
    command: str, end: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    assert main([command, *ends.WORDS[command]]) == 0  # what it imports is there for its children
    capsys.readouterr()
    ends.made(folder / "new")
    right = "result" if command in ends.SAYS_BESIDE else "one sentence"
    assert dict(ends.streamed(command, folder, end)) == {"standard output": right, "standard error": "result"}
