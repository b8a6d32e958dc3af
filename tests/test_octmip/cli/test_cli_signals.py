"""SIGTERM: the best result so far is shown and written, as after Ctrl-C; without a result the exit code is 143."""

import os
import signal
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from octmip import Solution, solve
from octmip.cli import main
from octmip.cli.stages import term_as_interrupt


@pytest.fixture
def hard(tmp_path: Path) -> Path:
    """A table whose proof at depth 5 takes hours."""
    rng = np.random.default_rng(0)
    frame = pd.DataFrame(rng.normal(size=(2000, 12)).round(3), columns=[f"x{j}" for j in range(12)])
    frame.assign(y=rng.integers(0, 3, 2000)).to_csv(tmp_path / "data.csv", index=False)
    return tmp_path / "data.csv"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_proof_that_is_terminated_writes_its_best_tree(
    hard: Path, number: signal.Signals, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def signalled(*arguments: Any, **options: Any) -> Solution:
        threading.Timer(0.3, os.kill, (os.getpid(), number)).start()
        return solve(*arguments, **options)

    monkeypatch.setattr("octmip.cli.solve.solve", signalled)
    tree, kept = hard.parent / "tree.json", hard.parent / "kept"
    words = ["solve", str(hard), "--label", "y", "--depth", "5", "--seconds", "600", "--out", str(tree)]
    start = time.perf_counter()
    assert main([*words, "--checkpoint", str(kept)]) == 0
    assert time.perf_counter() - start < 60
    assert "interrupted" in capsys.readouterr().out
    assert main(["certify", str(tree), str(hard)]) == 0


def test_a_command_without_a_result_ends_with_143(hard: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    def slow(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(10.0)

    monkeypatch.setattr("octmip.cli.predict.run", slow)
    assert main(["predict", "tree.json", str(hard)]) == 143
    assert capsys.readouterr().err == "octmip: terminated\n"


def test_the_handler_of_before_is_put_back() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with term_as_interrupt() as heard, pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGTERM)
    assert heard.exit_code == 143
    assert signal.getsignal(signal.SIGTERM) is before
