"""Processes that share work: those of this machine or of a Dask cluster, behind one way to submit and to wait.

Dask is the engine, as it runs on one machine, on batch systems (dask-jobqueue), on Kubernetes and in clouds, moves data
once to each worker, and does a task again that was lost with its worker. Whoever shares work here names tasks that give
the same result wherever and however often they run, so that a worker which dies costs time and no result.

Whatever goes through joblib (folds of cross-validation, states of a dataset, sealed cases) takes the same cluster while
it is open: `open_cluster` sets joblib's backend.
"""

import contextlib
import logging
import os
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Protocol

from octmip.errors import DataError, SolverError, needed_by

LOCAL = "local"
MOST_LOST = 20
"""Times that one task may be lost with its worker: a task that ends its worker each time would be sent for ever."""
PATIENCE = 30.0
"""Seconds in which a scheduler has to answer, and a first worker to be there."""
PAUSE = 0.2
"""Seconds before what was lost is looked at, or sent, again."""
RESTART = "300s"
"""Time in which a killed process of this machine has to be there again; Dask's 15 s are too short on a busy one."""

ENDED = (OSError, LookupError, ValueError, AssertionError)
"""What Dask raises, by the moment, where a worker ends while it is sent something."""


class Future(Protocol):
    """A task that was submitted."""

    def done(self) -> bool:
        """Whether its result is there, or it has failed."""
        ...

    def wait(self, seconds: float) -> bool:
        """Wait for its end, so long at most; return `done()`."""
        ...

    def result(self) -> Any:
        """Return the result; raise what the task raised."""
        ...

    def cancel(self) -> object:
        """Give it up."""
        ...


@dataclass(slots=True)
class Cluster:
    """The workers of a Dask cluster.

    Attributes
    ----------
    client
        of the cluster.
    round_size
        cuts of a proof that are in work at once. 0: as many as on one machine, 5, so that tree and evaluated cuts are
        the same. More workers than that need more: then the bound is the same, but another of the best trees may be
        found.
    n_lost
        tasks that were lost with their workers and sent again by this side; Dask itself does more of that.
    is_waiting
        whether no worker is left, and a warning has said so.
    """

    client: Any
    round_size: int = 0
    n_lost: int = 0
    is_waiting: bool = False

    @property
    def n_workers(self) -> int:
        """Number of workers now."""
        return len(self._workers)

    def has_workers(self) -> bool:
        """Whether there is a worker; where none is left a warning says so, once until there is one again."""
        is_left = self.n_workers > 0
        if not is_left and not self.is_waiting:
            warnings.warn("no worker of the cluster is left: open tasks wait for one", stacklevel=2)
        self.is_waiting = not is_left
        return is_left

    @property
    def n_threads(self) -> int:
        """Tasks that all workers together do at once now; 1 where there is no worker yet."""
        return max(1, sum(int(worker["nthreads"]) for worker in self._workers.values()))

    @property
    def _workers(self) -> Mapping[str, Any]:
        workers: Mapping[str, Any] = self.client.scheduler_info(n_workers=-1)["workers"]
        return workers

    def share(self, value: object) -> "Shared":
        """Return a value that each worker gets once, as an argument of tasks."""
        return Shared(self, value)

    def submit(self, function: Callable[..., Any], shared: "Shared", *arguments: object) -> Future:
        """Submit `function(shared value, *arguments)`."""
        return _Task(self, function, shared, arguments)


@dataclass(slots=True)
class Shared:
    """A value on its way to all workers."""

    cluster: Cluster
    value: object
    held: Any = None

    def __post_init__(self) -> None:
        self.send()

    def send(self) -> None:
        """Send the value to one worker; the others fetch it from those that have it.

        Dask would also copy it to all at once, but tries for ever to copy it to a worker that has ended meanwhile.

        Raises
        ------
        SolverError
            there is no worker, or one ends whenever the value is sent.
        """
        for _ in range(MOST_LOST):
            try:
                self._scatter(PATIENCE)
                return
            except TimeoutError as error:
                raise SolverError(
                    "no worker to send the problem to; expected one at least; start one (dask worker ADDRESS) and run "
                    "again"
                ) from error
            except ENDED as error:
                name = type(error).__name__
                time.sleep(PAUSE)
        raise SolverError(
            f"the problem was lost on its way to the workers {MOST_LOST} times ({name}); expected workers with memory "
            "enough for it; give them more, or use fewer on each machine"
        )

    def send_again(self, lost: Any) -> bool:
        """Send the value again for a task that was lost with `lost`, unless that was done since for another task.

        Whether a value is lost cannot be asked of `lost` itself: where the only worker that has it ends before Dask has
        made its future, the future never hears of it. False: this try has failed.
        """
        if self.held is not lost:
            return True
        try:
            self._scatter(PAUSE)
        except ENDED:
            return False
        return True

    def _scatter(self, timeout: float) -> None:
        # In a list: of a tuple, named ones too, Dask would send each part by itself.
        (self.held,) = self.cluster.client.scatter([self.value], hash=False, timeout=timeout)


@dataclass(slots=True)
class _Task:
    """A task that is sent again where Dask says that it was lost."""

    cluster: Cluster
    function: Callable[..., Any]
    shared: Shared
    arguments: tuple[object, ...]
    future: Any = None
    held: Any = None
    n_lost: int = field(default=0)
    is_done: bool = False
    value: Any = None
    error: Exception | None = None
    woken: threading.Event = field(default_factory=threading.Event)

    def __post_init__(self) -> None:
        self._send()

    def _send(self) -> None:
        self.held = self.shared.held
        self.future = self.cluster.client.submit(self.function, self.held, *self.arguments, pure=False)
        self.future.add_done_callback(lambda _: self.woken.set())

    def wait(self, seconds: float) -> bool:
        """Wait for its end, so long at most; return `done()`."""
        if not self.done():
            self.woken.wait(seconds)
            self.woken.clear()
        return self.done()

    def done(self) -> bool:
        """Whether its result is here, or its error; a task that was lost is sent again as soon as there is a worker.

        The result is fetched here, not in `result`: its worker may end between the two, and whoever waits in steps
        keeps its limits.
        """
        if self.is_done or not self.future.done():
            return self.is_done
        try:
            self.value = self.future.result()
        except Exception as error:
            if not self._is_lost():
                self.error = error
            elif self.n_lost < MOST_LOST:
                self._replace()
                return False
            else:
                self.error = SolverError(
                    f"a task was lost with its worker {self.n_lost} times ({type(error).__name__}); expected workers "
                    "with memory enough for it; give them more, or use fewer on each machine"
                )
        self.is_done = True
        return True

    def _replace(self) -> None:
        if self.cluster.has_workers():
            self.n_lost += 1
            if self.shared.send_again(self.held):
                self.cluster.n_lost += 1
                self._send()

    def result(self) -> Any:
        """Return the result; raise `SolverError` where it was lost too often, else what the task raised."""
        while not self.wait(PAUSE):
            pass
        if self.error is not None:
            raise self.error
        return self.value

    def _is_lost(self) -> bool:
        status = self.future.status
        return status in ("lost", "cancelled") or (
            status == "error" and type(self.future.exception()).__name__ == "KilledWorker"
        )

    def cancel(self) -> object:
        return self.future.cancel()


def is_given_up() -> bool:
    """Whether the task that runs here, in a worker, was cancelled: Dask ends no task that has begun."""
    distributed = import_module("distributed")
    try:
        worker = distributed.get_worker()
        task = worker.state.tasks.get(worker.get_current_task())
    except (ValueError, KeyError):  # no worker, or no task
        return False
    return task is None or task.state == "cancelled"


@contextlib.contextmanager
def open_cluster(where: str | Any, n_workers: int | None = None) -> Iterator[Cluster]:
    """Open a cluster for the work inside: "local", the address of a scheduler, or a Dask client (which stays open).

    Parameters
    ----------
    where
        "local" starts `n_workers` processes on this machine (by default one per core) and ends them afterwards.

    Raises
    ------
    DataError
        nobody answers at the address.
    MissingExtraError
        dask.distributed is not installed.
    """
    with needed_by("work on a cluster"):
        distributed = import_module("distributed")
    with contextlib.ExitStack() as stack:
        client = (
            where
            if isinstance(where, distributed.Client)
            else stack.enter_context(_client(distributed, where, n_workers))
        )
        stack.enter_context(import_module("joblib").parallel_config(backend="dask", n_jobs=-1))
        yield Cluster(client)


@contextlib.contextmanager
def _client(distributed: Any, where: str, n_workers: int | None) -> Iterator[Any]:
    if where != LOCAL:
        try:
            client = distributed.Client(where, timeout=PATIENCE, set_as_default=True)
        except (OSError, ValueError, TypeError) as error:
            raise DataError(
                f"no Dask scheduler answers at {where!r} ({type(error).__name__}); expected 'local' or an address such "
                "as tcp://host:8786; start one (dask scheduler), or correct the address"
            ) from error
        with client:
            yield client
        return
    with contextlib.ExitStack() as stack:
        stack.enter_context(import_module("dask").config.set({"distributed.deploy.lost-worker-timeout": RESTART}))
        cluster = stack.enter_context(_local(distributed, n_workers or os.cpu_count() or 1))
        yield stack.enter_context(distributed.Client(cluster))


def _local(distributed: Any, n_workers: int) -> Any:
    # Any free port: without an address the scheduler takes 8787, and a second cluster on one machine is refused.
    options = {"n_workers": n_workers, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0", "host": "127.0.0.1"}
    try:
        return distributed.LocalCluster(**options, silence_logs=logging.ERROR)
    except RuntimeError as error:
        raise SolverError(
            f"{n_workers} worker processes could not be started ({error}); expected a program that they can import; in "
            "a script put the call below if __name__ == '__main__', and the script in a file"
        ) from error
