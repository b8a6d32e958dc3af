"""A mutant: one place of the sources, what stands there, and the wrong text that takes its place."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Mutant:
    """One wrong change, and the tests that are to fail with it.

    Attributes
    ----------
    file
        of the tree, from its root.
    source, replacement
        text that stands there exactly once, and what replaces it.
    tests
        files under `tests/`, the first one the most likely to fail.
    equivalent
        why no test can fail, where none can; '' elsewhere.
    """

    file: str
    source: str
    replacement: str
    tests: tuple[str, ...]
    equivalent: str = ""

    @property
    def name(self) -> str:
        """File and changed text on one line."""
        before, after = (" ".join(text.split()) for text in (self.source, self.replacement))
        return f"{self.file}: {before} -> {after or '(nothing)'}"

    def changed(self, root: Path) -> str:
        """Return the text of the file in a tree with this change made.

        Raises
        ------
        ValueError
            the text does not stand there exactly once, or what comes out is no Python.
        """
        text = (root / self.file).read_text(encoding="utf-8")
        if (times := text.count(self.source)) != 1:
            raise ValueError(f"{self.file} holds {self.source!r} {times} times; expected once; correct the row")
        changed = text.replace(self.source, self.replacement)
        try:
            compile(changed, self.file, "exec")
        except SyntaxError as error:
            raise ValueError(f"{self.file} with {self.replacement!r} is no Python: {error}; correct the row") from error
        return changed


def mutants_of(file: str, tests: tuple[str, ...], *changes: tuple[str, ...]) -> tuple[Mutant, ...]:
    """Return the mutants of a file: of each change what stands there, what replaces it, and why it is equivalent."""
    return tuple(Mutant(file, source, replacement, tests, *why) for source, replacement, *why in changes)
