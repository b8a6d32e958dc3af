"""The process that HiGHS runs in: limits kept when it is silent, and nothing left of it."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from octmip import Leaf, Limits, Problem, Stop, certify
from octmip.errors import SolverError
from octmip.trees.mip.flow import solve_flow
from octmip.trees.mip.highs import highs, process
from octmip.trees.mip.oct import encode, solve_oct
from octmip.trees.mip.oct_h import solve_oct_h
from octmip.trees.mip.rows import Rows
from tests.test_octmip.test_mip import blobs

needs_proc = pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="the system shows no processes")


def noisy(n: int, p: int, depth: int, **options: object) -> Problem:
    """Return a problem whose relaxations take HiGHS long."""
    rng = np.random.default_rng(0)
    features = rng.normal(size=(n, p))
    labels = (features[:, 0] + rng.normal(size=n) > 0).astype(int)
    return Problem(features, labels, depth=depth, **options)


def is_alive(pid: int) -> bool:
    """Return whether a process is there, a zombie included."""
    return os.path.exists(f"/proc/{pid}")


@pytest.mark.long
def test_a_relaxation_that_is_silent_ends_at_the_limit():
    for problem, solver in (
        (noisy(1750, 20, 2, split="hyperplane"), solve_oct_h),
        (noisy(800, 10, 3), solve_oct),
    ):
        began = time.perf_counter()
        solution = solver(problem, limits=Limits(seconds=1), incumbent=Leaf(0))
        assert time.perf_counter() - began < 30  # it took minutes
        certify(problem, solution)
        assert solution.stop is Stop.TIME
        assert solution.bound <= solution.objective


def test_a_model_that_takes_longer_to_build_than_the_limit_is_given_up():
    problem = noisy(3000, 10, 6)
    for solver in (solve_oct, solve_flow):
        solution = solver(problem, limits=Limits(seconds=0.2), incumbent=Leaf(0))
        certify(problem, solution)
        assert solution.stop is Stop.TIME
        assert solution.bound == 0


@pytest.mark.parametrize("solver", [solve_oct, solve_flow])
def test_a_heap_larger_than_the_memory_is_given_up(solver):
    problem = blobs(depth=30)
    solution = solver(problem, incumbent=Leaf(0))
    certify(problem, solution)
    assert solution.stop is Stop.MEMORY


@needs_proc
def test_the_memory_that_a_worker_holds_when_it_starts_is_not_counted():
    assert solve_oct(blobs(30, depth=1), limits=Limits(memory=2e7)).is_optimal


@needs_proc
def test_a_worker_that_does_not_obey_is_killed_and_waited_for(monkeypatch):
    with process.lent_worker() as lent:
        pid = lent.process.pid
        lent.send("run", {"model": highs.arrays(encode(blobs(depth=1)).rows), "options": {}, "start": None})
        os.kill(pid, signal.SIGSTOP)  # as silent as a process can be
        supervisor = highs._Supervisor(lent, Rows(), Limits(seconds=0.05), None)
        outcome = supervisor.over({"model": {}, "options": {}, "start": None})
    assert outcome.stop is Stop.TIME
    assert "killed" in outcome.status
    assert not is_alive(pid)


@needs_proc
def test_a_worker_that_dies_leaves_the_start_and_no_zombie():
    problem, pids = blobs(40, depth=3), []

    def kill(state):
        if math.isinf(state.objective):  # it has not begun
            return
        found = [child for child in children() if child not in pids]
        pids.extend(found)
        for pid in found:
            os.kill(pid, signal.SIGKILL)

    process.close_idle()
    solution = solve_oct(problem, limits=Limits(seconds=60), progress=kill)
    certify(problem, solution)
    assert pids
    assert solution.stop is Stop.NUMERICS
    assert "ended by itself" in solution.details["status"]
    assert not any(is_alive(pid) for pid in pids)


def children() -> list[int]:
    """Return the workers of this process that run; other children, such as multiprocessing's own, are left alone."""
    with open(f"/proc/self/task/{os.getpid()}/children") as file:
        pids = [int(pid) for pid in file.read().split()]
    return [pid for pid in pids if b"octmip/trees/mip/highs/worker.py" in Path(f"/proc/{pid}/cmdline").read_bytes()]


def test_an_idle_worker_is_used_again_and_closed_after_a_while(monkeypatch):
    process.close_idle()
    monkeypatch.setattr(process, "IDLE", 0.2)
    with process.lent_worker() as lent:
        first = lent
    with process.lent_worker() as lent:
        assert lent is first
    deadline = time.monotonic() + 20
    while first.process.returncode is None and time.monotonic() < deadline:
        time.sleep(0.05)
    assert first.process.returncode is not None
    assert not process._idle


def test_a_worker_is_closed_when_the_caller_fails():
    with pytest.raises(ValueError, match="caller"), process.lent_worker() as lent:
        raise ValueError("caller")
    assert lent.process.returncode is not None


@needs_proc
def test_a_worker_does_not_outlive_its_parent():
    code = (
        "from octmip.trees.mip.highs.process import lent_worker\n"
        "import os, signal\n"
        "with lent_worker() as lent:\n"
        "    print(lent.process.pid, flush=True)\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ})
    pid = int(done.stdout)
    deadline = time.monotonic() + 20
    while is_running(pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_running(pid)


def is_running(pid: int) -> bool:
    """Return whether a process runs; who is nobody's child any more may stay a zombie where nobody collects it."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.long
def test_a_script_without_a_main_guard_can_solve():
    code = "from octmip import Problem, solve\nprint(solve(Problem([[0.0], [1.0]], [0, 1], depth=1), 'oct').stop)\n"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("optimal\n", "")


def test_runs_in_several_threads_do_not_meet():
    problem, found = blobs(depth=1), []
    threads = [threading.Thread(target=lambda: found.append(solve_flow(problem).objective)) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 3
    assert len(set(found)) == 1


def test_a_model_that_highs_refuses_is_an_error_with_its_name():
    rows = encode(blobs(depth=1)).rows
    rows.columns("x", (range(1),), lower=np.nan)
    with pytest.raises(SolverError, match="refused the model"):
        highs.run(rows, highs.Options())


@pytest.mark.long
def test_masters_are_solved_beside_others_who_use_highs_with_other_threads():
    program = """
import highspy, numpy as np
from octmip.trees.mip.benders.solver import solve_benders
from octmip.trees.question.problem import Problem
other = highspy.Highs()
other.setOptionValue("output_flag", False)
other.addVar(0.0, 1.0)
other.run()  # with as many threads as HiGHS takes by itself
rng = np.random.default_rng(0)
features = rng.normal(size=(60, 3)).round(1)
print(solve_benders(Problem(features, (features.sum(axis=1) > 0).astype(int), depth=2)).stop)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.split()[-1:] == ["optimal"], done.stderr
