"""SIGINT and SIGTERM end every command with what is known; without a result the exit code is 130 or 143."""

import importlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.cases.command import ends, signals
from octmip import Options, Problem, Solution, Study, solve
from octmip.interfaces.cli import main
from octmip.interfaces.cli.program import COMMANDS
from octmip.interfaces.cli.stages import term_as_interrupt
from octmip.trees.answer.interruption import held_back
from octmip.trees.answer.solution import Progress, Stop
from octmip.trees.near_sets import sensor_roles

on_linux = pytest.mark.skipif(sys.platform != "linux", reason="Linux has /proc, /dev/full and a limit of memory")


@pytest.fixture
def hard(tmp_path: Path) -> Path:
    """A table whose proof at depth 5 takes hours."""
    rng = np.random.default_rng(0)
    frame = pd.DataFrame(rng.normal(size=(2000, 12)).round(3), columns=[f"x{j}" for j in range(12)])
    frame.assign(y=rng.integers(0, 3, 2000)).to_csv(tmp_path / "data.csv", index=False)
    return tmp_path / "data.csv"


@pytest.fixture
def random_problem() -> Problem:
    """A problem whose proof takes minutes."""
    rng = np.random.default_rng(0)
    return Problem(rng.normal(size=(2000, 12)), rng.integers(0, 3, 2000), depth=3)


def sent(number: signal.Signals, seconds: float = 0.3) -> None:
    """Send this process a signal a little later."""
    threading.Timer(seconds, os.kill, (os.getpid(), number)).start()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_proof_that_is_terminated_writes_its_best_tree(
    hard: Path, number: signal.Signals, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def signalled(*arguments: Any, **options: Any) -> Solution:
        sent(number)
        return solve(*arguments, **options)

    monkeypatch.setattr("octmip.interfaces.cli.solve.solve", signalled)
    tree, kept = hard.parent / "tree.json", hard.parent / "kept"
    words = ["solve", str(hard), "--label", "y", "--depth", "5", "--seconds", "600", "--out", str(tree)]
    start = time.perf_counter()
    assert main([*words, "--checkpoint", str(kept)]) == 0
    assert time.perf_counter() - start < 60
    assert "interrupted" in capsys.readouterr().out
    assert main(["certify", str(tree), str(hard)]) == 0


def test_a_proof_that_is_terminated_is_shown_though_its_log_is_not_written(
    hard: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def signalled(*arguments: Any, **options: Any) -> Solution:
        sent(signal.SIGTERM)
        return solve(*arguments, **options)

    monkeypatch.setattr("octmip.interfaces.cli.solve.solve", signalled)
    log = hard.parent / "log"
    assert main(["solve", str(hard), "--label", "y", "--depth", "4", "--proof", str(log)]) == 1
    shown = capsys.readouterr()
    assert "stop: interrupted" in shown.out
    assert "the proof was interrupted; tree and bound stand without it" in shown.err
    assert not log.exists()


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_while_the_program_is_loaded_ends_it_without_a_traceback(number: int, code: int) -> None:
    # Everything that the program imports of its own sends the signal first.
    program = (
        "import os, sys, importlib.abc\n"
        "class Loading(importlib.abc.MetaPathFinder):\n"
        "    def find_spec(self, name, path, target=None):\n"
        f"        if name == 'octmip.interfaces.cli.program': os.kill(os.getpid(), {int(number)})\n"
        "sys.meta_path.insert(0, Loading())\n"
        "from octmip.interfaces.cli import main\n"
        "assert not {'numpy', 'octmip.errors'} & {*sys.modules}\n"
        "sys.exit(main())\n"
    )
    ended = subprocess.run([sys.executable, "-c", program, "solve", "--help"], capture_output=True, text=True)
    assert (ended.returncode, ended.stdout) == (code, "")
    assert ended.stderr == f"octmip: {'terminated' if number == signal.SIGTERM else 'interrupted'}\n"


def test_a_signal_after_the_result_changes_nothing() -> None:
    program = (
        "import atexit, os, signal, sys\n"
        "class Late:\n"
        "    def __del__(self): os.kill(os.getpid(), signal.SIGINT)\n"
        "late = Late()\n"  # Python deletes it when it takes itself down
        "from octmip.interfaces.cli import main\n"
        "sys.exit(main())\n"
    )
    ended = subprocess.run([sys.executable, "-c", program, "solve", "--help"], capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "usage: octmip solve" in ended.stdout


def test_an_error_that_others_make_of_a_signal_is_an_interruption(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(*_: object) -> None:
        try:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(10.0)
        except KeyboardInterrupt:
            raise ImportError("half a module") from None

    monkeypatch.setattr("octmip.interfaces.cli.doctor.run", broken)
    assert main(["doctor"]) == 130
    assert capsys.readouterr().err == "octmip: interrupted\n"


class Dropping:
    """Its finaliser drops the signal."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.01)


DROPS = """
import os, signal, time
try:
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep({})
except KeyboardInterrupt:
    pass
time.sleep(0.1)
"""  # as compiled modules do


@pytest.mark.parametrize("seconds", [None, 0.0, 0.4])
def test_a_signal_that_a_finaliser_or_an_import_drops_is_sent_again(
    seconds: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "dropping.py").write_text(DROPS.format(seconds))

    def dropped(*_: object) -> None:
        Dropping() if seconds is None else importlib.import_module("dropping")
        time.sleep(10.0)

    monkeypatch.delitem(sys.modules, "dropping", raising=False)
    monkeypatch.setattr("octmip.interfaces.cli.doctor.run", dropped)
    start = time.perf_counter()
    assert main(["doctor"]) == 143
    assert time.perf_counter() - start < 5
    assert capsys.readouterr().err == "octmip: terminated\n"


def test_the_handlers_of_before_are_put_back() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with term_as_interrupt() as heard, pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGTERM)
    assert heard.exit_code == 143
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_a_first_signal_waits_until_a_result_is_shown_and_a_second_does_not() -> None:
    with term_as_interrupt(), held_back():
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)


def test_ctrl_c_in_python_ends_all_searches_too_and_the_next_call_is_a_new_one(
    random_problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = []

    def interrupted(state: Progress) -> None:
        raise KeyboardInterrupt

    def counted(*arguments: Any) -> Solution:
        begun.append(arguments)
        return solve(*arguments)

    monkeypatch.setattr("octmip.trees.near_sets.without.solve", counted)
    assert sensor_roles(random_problem, progress=interrupted).stop is Stop.INTERRUPTED
    assert len(begun) == 1
    assert solve(Problem(np.array([[0.0], [1.0]]), np.array([0, 1]), depth=1)).is_optimal


def test_an_interrupted_solve_goes_on_and_is_none_of_a_study(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    random_problem = Problem(rng.normal(size=(500, 12)), rng.integers(0, 3, 500), depth=3)

    def interrupted(state: Progress) -> None:
        raise KeyboardInterrupt

    for checkpoint in (tmp_path / "kept", Study(tmp_path / "study")):
        options = Options(checkpoint=checkpoint)
        assert solve(random_problem, progress=interrupted, options=options).stop is Stop.INTERRUPTED
        again = solve(random_problem, options=options)
        assert (again.stop, "kept" in again.details) == (Stop.OPTIMAL, False)


@pytest.fixture(scope="module")
def at_work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tables, tree, proof and twin that commands work on."""
    folder = tmp_path_factory.mktemp("signals")
    signals.prepare(folder, n_long=9)
    return folder


@pytest.mark.long("frontier", "report")
@on_linux
@pytest.mark.parametrize("command", ["solve", "frontier", "diagnose", "monitor", "report"])  # the benchmark asks all
def test_a_command_ends_by_a_signal_at_a_random_moment(command: str, at_work: Path) -> None:
    (line,) = signals.signalled(command, at_work, 1, latest=1.2, earliest=0.1)
    assert line["outcome"] in ("result", "interrupted", "ended before", "loading")
    # A second of an idle machine; the wall seconds are the benchmark's.
    assert line.get("cpu_seconds", 0.0) < 2.0


# Streams that are closed or full lose nothing that a command found, and their failure is one sentence


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the commands work on."""
    ends.prepare(made := tmp_path_factory.mktemp("ends"))
    return made


@pytest.mark.long("diagnose-600", "monitor-450")
@on_linux
@pytest.mark.parametrize(("command", "megabytes"), [("solve", 450), ("monitor", 450), ("diagnose", 600)])
def test_a_process_that_gets_no_more_memory_has_its_result_or_one_sentence(
    command: str, megabytes: int, folder: Path
) -> None:
    assert ends.limited(command, folder, megabytes) in ("result", "one sentence")


@pytest.mark.long("compare-full", "sensors-full", "frontier-full", "diagnose-closed")
@on_linux
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
