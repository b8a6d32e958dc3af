"""A proof shared over processes: the tree, bound and evaluated cuts of one machine, also when a worker is killed."""

import json
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import nullcontext
from unittest.mock import Mock, patch

import dask
import numpy as np
import pandas as pd
import pytest
from distributed import Client, LocalCluster

from octmip import Limits, Problem, Progress, Stop
from octmip.errors import DataError, SolverError
from octmip.interfaces.cli import main
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods import shared_work
from octmip.trees.methods.cluster import RESTART, Cluster, open_cluster
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions, SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.methods.shared_work import shared_problem
from octmip.trees.question.losses import ClassCosts

pytestmark = pytest.mark.filterwarnings("ignore:no worker of the cluster is left")
"""Where a killed worker comes back slowly; what says so has a test of its own."""


@pytest.fixture(scope="module")
def n_workers(request: pytest.FixtureRequest) -> int:
    """Two for the long tests, which kill one; otherwise one of two threads, as each takes four seconds to begin."""
    return 1 + bool(request.config.getoption("--long"))


@pytest.fixture(scope="module")
def workers(n_workers: int) -> Iterator[Client]:
    """Processes with two threads in all, on the loopback; one that was killed has long to come back."""
    options = {
        "n_workers": n_workers,
        "threads_per_worker": 3 - n_workers,
        "dashboard_address": "127.0.0.1:0",
        "host": "127.0.0.1",
    }
    with (
        dask.config.set({"distributed.deploy.lost-worker-timeout": RESTART}),
        LocalCluster(**options, silence_logs=50) as cluster,
        Client(cluster) as client,
    ):
        yield client


@pytest.fixture
def client(workers: Client, n_workers: int) -> Client:
    """All workers, whatever the test before has killed."""
    workers.wait_for_workers(n_workers, timeout=120)
    return workers


@pytest.fixture
def asked(client: Client) -> Iterator[Client]:
    """The workers, and that they are asked: without them the answer would be the same."""
    with patch.object(Cluster, "submit", autospec=True, side_effect=Cluster.submit) as submit:
        yield client
    assert submit.called


COSTS = [[0, 1, 4], [2, 0, 1], [5, 1, 0]]


def hard(n: int = 400, depth: int = 3, **options: object) -> Problem:
    rng = np.random.default_rng(5)
    return Problem(rng.integers(0, 90, (n, 5)).astype(float), rng.integers(0, 3, n), depth=depth, **options)


@pytest.mark.long("options1")
@pytest.mark.parametrize("options", [{"sensor_budget": 2}, {"loss": ClassCosts(COSTS)}])
def test_tree_bound_and_cuts_are_those_of_one_machine(asked: Client, options: dict[str, object]) -> None:
    problem = hard(150, **options)
    alone = branch_and_bound(problem)
    shared = branch_and_bound(problem, options=ExactOptions(cluster=Cluster(asked)))
    assert (shared.tree, shared.bound, shared.stop) == (alone.tree, alone.bound, Stop.OPTIMAL)
    assert shared.n_nodes == alone.n_nodes


def test_the_parts_of_a_log_are_joined_and_checked(asked: Client, tmp_path) -> None:
    problem = hard(120, leaf_size=4)
    alone, threads, shared = (tmp_path / name for name in ("alone", "threads", "shared"))
    found = branch_and_bound(problem, options=ExactOptions(proof=alone))
    branch_and_bound(problem, n_jobs=3, options=ExactOptions(proof=threads))
    branch_and_bound(problem, options=ExactOptions(cluster=Cluster(asked), proof=shared))
    assert alone.read_bytes() == threads.read_bytes() == shared.read_bytes()
    assert check_proof(problem, shared).bound == found.objective


@pytest.mark.long
def test_a_worker_that_is_killed_costs_no_result(client: Client) -> None:
    problem = hard(1200, 4)
    alone = branch_and_bound(hard(1200, 3))
    shared: list[object] = []
    worker = threading.Thread(
        target=lambda: shared.append(branch_and_bound(hard(1200, 3), options=ExactOptions(cluster=Cluster(client))))
    )
    worker.start()
    time.sleep(0.3)
    pids = client.run(os.getpid)
    os.kill(next(iter(pids.values())), signal.SIGKILL)
    worker.join()
    assert [(found.tree, found.bound, found.n_nodes) for found in shared] == [(alone.tree, alone.bound, alone.n_nodes)]
    # A limit ends the search although cuts are still in work elsewhere.
    start = time.perf_counter()
    options = ExactOptions(cluster=Cluster(client))
    assert branch_and_bound(problem, options=options, limits=Limits(seconds=0.5)).stop is Stop.TIME
    assert time.perf_counter() - start < 10


def test_the_command_takes_the_address_of_a_scheduler(client: Client, tmp_path, capsys) -> None:
    problem = hard(40)
    frame = pd.DataFrame(problem.samples.features, columns=list("abcde")).assign(y=problem.samples.codes)
    frame.to_csv(tmp_path / "data.csv", index=False)
    words = [str(tmp_path / "data.csv"), "--label", "y", "--depth", "3", "--cluster", client.scheduler.address]
    assert main(["solve", *words]) == 0
    assert "optimal" in capsys.readouterr().out
    assert main(["solve", *words, "--method", "search"]) == 0
    assert "proves nothing about other trees" in capsys.readouterr().out
    assert main(["frontier", *words, "--over", "depth", "--folds", "2", "--json"]) == 0
    shared = json.loads(capsys.readouterr().out)
    assert main(["frontier", *words[:-2], "--over", "depth", "--folds", "2", "--json"]) == 0
    alone = json.loads(capsys.readouterr().out)
    assert [row["tree"] for row in shared["rows"]] == [row["tree"] for row in alone["rows"]]
    assert shared["chosen"] == alone["chosen"]


SEARCHES = [
    ({"depth": 4}, {"restarts": 9, "perturbations": 8}),
    ({"split": "hyperplane"}, {"restarts": 3, "perturbations": 4}),
    ({"split": "hyperplane", "split_size": 2, "depth": 2}, {"restarts": 3, "perturbations": 4}),
    ({"loss": ClassCosts(np.arange(9).reshape(3, 3)), "sensor_budget": 2}, {"restarts": 11, "perturbations": 4}),
]


@pytest.mark.parametrize(("options", "effort"), SEARCHES)
def test_the_tree_of_a_search_is_that_of_one_machine(asked: Client, options: dict[str, object], effort: dict) -> None:
    problem = hard(120, **({"depth": 3} | options))
    alone = local_search(problem, seed=3, options=SearchOptions(**effort))
    shared = local_search(problem, seed=3, options=SearchOptions(cluster=Cluster(asked), **effort))
    assert (shared.tree, shared.n_nodes, shared.stop) == (alone.tree, alone.n_nodes, Stop.FINISHED)
    threads = local_search(problem, seed=3, n_jobs=3, options=SearchOptions(**effort))
    assert (threads.tree, threads.n_nodes) == (alone.tree, alone.n_nodes)


@pytest.mark.long
def test_limits_progress_and_control_c_of_a_shared_search(client: Client) -> None:
    problem = hard(4000, 5)
    reports: list[Progress] = []
    start = time.perf_counter()
    effort = SearchOptions(restarts=10_000, cluster=Cluster(client))
    found = local_search(problem, options=effort, limits=Limits(seconds=1.5), progress=reports.append)
    assert (found.stop, time.perf_counter() - start < 6) == (Stop.TIME, True)
    assert found.objective < 0.9 * problem.baseline  # what the workers had when time ran out
    assert reports
    assert local_search(problem, options=effort, limits=Limits(nodes=50)).stop is Stop.NODES

    def stop(_: Progress) -> None:
        if time.perf_counter() - start > 1:
            signal.raise_signal(signal.SIGINT)

    start = time.perf_counter()
    assert local_search(problem, options=effort, progress=stop).stop is Stop.INTERRUPTED
    # Turns that nobody waits for are given up by the workers, which are free for others.
    assert client.submit(len, "free", pure=False, priority=-1).result(timeout=5) == 4


def test_nobody_at_an_address_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("octmip.trees.methods.cluster.PATIENCE", 0.2)
    with (
        pytest.raises(DataError, match=r"no Dask scheduler answers at 'tcp://127.0.0.1:9'"),
        open_cluster("tcp://127.0.0.1:9"),
    ):
        pass


def test_what_a_task_raises_is_raised_here(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("octmip.trees._native.__version__", "0.0.0")
    with pytest.raises(SolverError, match=r"a worker has octmip .*; expected 0.0.0"):
        branch_and_bound(hard(100), options=ExactOptions(cluster=Cluster(client)))


@pytest.mark.long
def test_a_cluster_without_a_worker_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("octmip.trees.methods.cluster.PATIENCE", 0.5)
    options = {"n_workers": 0, "dashboard_address": "127.0.0.1:0", "host": "127.0.0.1"}
    with (
        LocalCluster(**options, silence_logs=50) as empty,
        Client(empty) as client,
        pytest.raises(SolverError, match=r"no worker to send the problem to; expected one at least"),
    ):
        branch_and_bound(hard(30, 2), options=ExactOptions(cluster=Cluster(client)))


@pytest.mark.long
def test_a_task_that_is_lost_each_time_is_given_up(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("octmip.trees.methods.cluster.MOST_LOST", 1)
    cluster = Cluster(client)
    task = cluster.submit(len, cluster.share("shared"))
    while not task.done():
        time.sleep(0.01)
    assert task.result() == 6
    task = cluster.submit(len, cluster.share("shared"))
    task.cancel()
    while not task.done():
        time.sleep(0.01)
    assert (task.result(), cluster.n_lost) == (6, 1)
    for _ in range(2):
        task = cluster.submit(time.sleep, cluster.share(5))
        task.future.cancel()
        task.n_lost = 1
    with pytest.raises(SolverError, match="lost with its worker 1 times"):
        task.result()
    for error in ("KilledWorker", "ValueError"):
        raised = Mock(return_value=type(error, (Exception,), {})())
        task.future = Mock(status="error", exception=raised)
        assert task._is_lost() == (error == "KilledWorker")


@pytest.mark.long
def test_a_turn_that_is_cut_short_leaves_no_solver_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = shared_problem({}, [])
    for is_whole in (None, False, True):
        solver = Mock(
            take=Mock(return_value={"is_whole": is_whole}) if is_whole is not None else Mock(side_effect=OSError)
        )
        monkeypatch.setitem(shared_work._kept, problem.digest, solver)
        with pytest.raises(OSError) if is_whole is None else nullcontext():  # noqa: PT011
            shared_work.take_turn(problem, "turn", {"seconds": 1.0, "gap": 0.0, "nodes": 9.0, "memory": 1e9})
        assert (problem.digest in shared_work._kept) == bool(is_whole)
