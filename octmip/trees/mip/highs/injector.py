"""Incumbent injector: trees found elsewhere, handed to HiGHS while it runs.

    with IncumbentInjector(lambda turn: local_search(problem, seed=turn, limits=Limits(seconds=1)).tree) as injector:
        solution = solve_flow(problem, inject=injector)

The source runs in a thread of its own, turn after turn, and is asked for nothing more once HiGHS has ended.
"""

import threading
from collections.abc import Callable
from types import TracebackType

from octmip.trees.tree import Node


class IncumbentInjector:
    """Calls a source in a thread, and gives each tree to HiGHS once."""

    def __init__(self, source: Callable[[int], Node | None], *, most_turns: int = 1000) -> None:
        """Make an injector.

        Parameters
        ----------
        source
            returns a tree or None; called with 0, 1, 2, ...
        most_turns
            calls of it at most.
        """
        self._source, self._most_turns = source, most_turns
        self._lock, self._ended = threading.Lock(), threading.Event()
        self._latest: Node | None = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._work, daemon=True)

    def __enter__(self) -> "IncumbentInjector":
        """Start the source."""
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the source after its present turn."""
        self._ended.set()
        self._thread.join()

    def __call__(self, objective: float) -> Node | None:
        """Return the latest tree not given yet; what the source raised is raised here."""
        with self._lock:
            tree, self._latest = self._latest, None
        if self._error is not None:
            raise self._error
        return tree

    def _work(self) -> None:
        for turn in range(self._most_turns):
            if self._ended.is_set():
                return
            try:
                tree = self._source(turn)
            except BaseException as error:
                self._error = error
                return
            with self._lock:
                self._latest = tree if tree is not None else self._latest
