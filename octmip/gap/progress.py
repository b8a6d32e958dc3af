"""Progress of a diagnosis: which stage it is at, for whoever waits."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Stage:
    """A stage of a diagnosis.

    Attributes
    ----------
    words
        what is being done.
    number, of
        which of how many parts of this stage; 0 where it has no parts.
    part
        name of the part, where it has one.
    """

    words: str
    number: int = 0
    of: int = 0
    part: str = ""

    def __str__(self) -> str:
        counted = f"{self.words} {self.number} of {self.of}" if self.of else self.words
        return f"{counted}: {self.part}" if self.part else counted


Progress = Callable[[Stage], None]
"""Called at the start of every stage, in the thread of the caller; what it raises ends the diagnosis."""


def silent(stage: Stage) -> None:
    """Say nothing."""
