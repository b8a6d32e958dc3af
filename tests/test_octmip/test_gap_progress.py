"""Whoever waits for a diagnosis is told what it is doing, and can end it."""

import csv
import os
import pty
import re
import select
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from octmip.gap import diagnose
from octmip.gap.diagnosis import library_of
from octmip.gap.progress import Stage
from tests.test_octmip.beam_twin import Beam, measured

ROOT = Path(__file__).parents[2]
SLOW = """
import time
from tests.test_octmip.beam_twin import Beam

class Slow(Beam):
    def predict(self, state, load_factor):
        time.sleep(0.02)
        return super().predict(state, load_factor)
"""


def test_every_stage_is_named_and_counted():
    said: list[Stage] = []
    campaign = measured(7, states=((0.35, 0.55),), known=False)
    diagnose(campaign, Beam(), commissioning=measured(1000), progress=said.append)
    words = [str(stage) for stage in said]
    n = len(library_of(Beam(), campaign))
    assert words[0] == "the noise of the readings"
    assert f"effect 1 of {n}: gain of one gauge" in words
    assert [w for w in words if w.startswith(f"effect {n} of {n}")]
    assert "unknown state 1 of 1" in words
    assert "hypotheses, number of effects 2 of 3" in words
    assert words[-1] == "which test to run next"


def test_what_the_listener_raises_ends_the_diagnosis():
    def stop(stage: Stage) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        diagnose(measured(7), Beam(), progress=stop)


@pytest.fixture
def command(tmp_path):
    campaign = measured(7, loads=(0.0, 1.0, 2.0), repeats=20)
    with (tmp_path / "campaign.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["test", "load_factor", *campaign.parameters, "time", *campaign.gauges])
        rows = zip(campaign.test, campaign.load_factor, campaign.states, campaign.time, campaign.readings, strict=True)
        writer.writerows([test, load, *state, at, *reading] for test, load, state, at, reading in rows)
    (tmp_path / "slow.py").write_text(SLOW)
    command = [sys.executable, "-m", "octmip.interfaces.cli", "diagnose", "campaign.csv", "--twin", "slow:Slow"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "80"}
    return {"args": command, "cwd": tmp_path, "env": environment}


def test_a_terminal_sees_the_stages_and_ctrl_c_ends_them(command):
    own, other = pty.openpty()
    running = subprocess.Popen(**command, stdout=subprocess.DEVNULL, stderr=other)
    os.close(other)
    text, sent = "", False
    while select.select([own], [], [], 60.0)[0]:
        try:
            text += os.read(own, 65536).decode()
        except OSError:  # the other end is closed
            break
        if "effect 1 of " in text and not sent:
            sent = True
            running.send_signal(signal.SIGINT)
    os.close(own)
    assert running.wait(60) == 130, text
    assert text.startswith("octmip diagnose: a twin of finite elements takes about a minute")
    assert "building the twin slow:Slow" in text
    assert re.search(r"effect 1 of \d+: gain of one gauge", text)
    assert text.rstrip().endswith("octmip: interrupted")


def test_no_terminal_hears_nothing_of_it(command, tmp_path):
    command["args"][-1] = "tests.test_octmip.beam_twin:Beam"
    done = subprocess.run(**command, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert done.stdout.startswith("Nothing to do")
