"""Main programs of the benchmarks hear SIGTERM as Ctrl-C, and studies go on from what they wrote."""

import json
import signal
import subprocess
import sys
import time
from dataclasses import asdict

import pytest

from benchmarks.blind.__main__ import unfinished
from benchmarks.blind.run import Plan, _settled, begun_seed
from benchmarks.tables import whole_lines

SLEEPER = """
import sys, time
from joblib import Parallel, delayed
from benchmarks.main_program import run_main

def main():
    print("ready", flush=True)
    Parallel(n_jobs=2)(delayed(time.sleep)(60) for _ in range(2))

run_main(main)
"""


def test_a_main_program_ends_with_the_code_of_its_signal():
    for number, code in ((signal.SIGTERM, 143), (signal.SIGINT, 130)):
        command = [sys.executable, "-c", SLEEPER]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
            running.stdout.readline()
            time.sleep(0.3)
            running.send_signal(number)
            assert running.wait(timeout=20) == code
            assert "stopped; what was written stands" in running.stderr.read()


def test_a_last_line_that_was_cut_off_is_removed(tmp_path):
    path = tmp_path / "lines.jsonl"
    assert whole_lines(path) == []
    path.write_text('{"a": 1}\n{"a": 2}\n{"a"')
    assert [json.loads(line) for line in whole_lines(path)] == [{"a": 1}, {"a": 2}]
    assert path.read_text() == '{"a": 1}\n{"a": 2}\n'


def test_a_sealed_set_goes_on_with_its_own_plan_only(tmp_path):
    plan = Plan(7, count=3, families=("beam",))
    assert unfinished(tmp_path, None).parent == tmp_path
    folder = unfinished(tmp_path, 7)
    folder.mkdir()
    assert _settled(folder, plan) == plan
    assert (begun_seed(folder), unfinished(tmp_path, None), unfinished(tmp_path, 7)) == (7, folder, folder)
    assert unfinished(tmp_path, 8) != folder
    assert _settled(folder, Plan(**asdict(plan) | {"jobs": 1})).jobs == 1
    with pytest.raises(SystemExit, match="was begun with count 3; got 4; give the same plan, or another folder"):
        _settled(folder, Plan(**asdict(plan) | {"count": 4}))
    (folder / "tables.md").write_text("done")
    assert unfinished(tmp_path, None) != folder
