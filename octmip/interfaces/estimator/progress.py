"""What a fit prints while it works, where `verbose` asks for it."""

import time

from octmip.interfaces.report.text import progress_words
from octmip.trees.answer.solution import Progress

INTERVAL = 2.0
"""Seconds between two lines; a shorter fit prints none."""


class Told:
    """Prints how far a fit is: the state of a solver, or the share of a cross-validation that is done."""

    def __init__(self) -> None:
        self._next = time.monotonic() + INTERVAL

    def __call__(self, state: Progress | str) -> None:
        """Print a state, unless the last one is too near."""
        if time.monotonic() < self._next:
            return
        self._next = time.monotonic() + INTERVAL
        print(f"octmip: {state if isinstance(state, str) else progress_words(state)}", flush=True)
