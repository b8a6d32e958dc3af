"""A kind of problem: how one is drawn, what is true of it, how it is asked, and what is wrong with an answer."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from octmip.trees.answer.solution import Limits, Stop

Generator = np.random.Generator
ROUNDING = Fraction(1, 2**44)
"""Relative: an objective is a sum of rounded products, rounded again."""

ENOUGH = 5.0
"""Seconds that are enough for a proof of a small problem."""
HEURISTIC = ("search", "cart")


class Answer(Protocol):
    """An answer of any kind: it says why it ended."""

    @property
    def stop(self) -> Stop:
        """Why the solver stopped."""


@dataclass(frozen=True, slots=True)
class Question:
    """One call: which problem of which kind, which method, which limits, with a proof log or without."""

    seed: int
    kind: str
    method: str
    limits: Limits
    proof: bool

    @property
    def is_free(self) -> bool:
        """Whether an exact method has time enough, no other limit and no log to write, whose grid may be too coarse."""
        is_exact = self.method not in HEURISTIC and not self.proof
        return is_exact and self.limits == Limits(seconds=self.limits.seconds) and self.limits.seconds >= ENOUGH

    def __str__(self) -> str:
        limits = f"seconds={self.limits.seconds:g}, nodes={self.limits.nodes:g}, gap={self.limits.gap:g}"
        return f"seed {self.seed} {self.kind} {self.method} ({limits}{', proof' if self.proof else ''})"


class Kind(Protocol):
    """A kind of problem."""

    @property
    def stream(self) -> int:
        """Last number of the seeds of its problems."""

    @property
    def share(self) -> float:
        """Share of the seeds that have a problem of it."""

    @property
    def methods(self) -> Mapping[str, float]:
        """Methods that are asked, and the share of the problems that each is."""

    @property
    def is_proven(self) -> bool:
        """Whether every answer without a limit is to be proven."""

    def draw(self, rng: Generator) -> Any:
        """Return a random problem."""

    def truth(self, problem: Any) -> Any:
        """Return what enumeration says of a problem."""

    def has_log(self, problem: Any, method: str) -> bool:
        """Return whether a method writes proof logs of a problem."""

    def ask(self, question: Question, problem: Any, log: Path | None) -> Answer:
        """Return the answer to a question."""

    def complaint(self, problem: Any, answer: Any, truth: Any, log: Path) -> str:
        """Return what is wrong with an answer and its log, if there is one; '' when nothing is."""
