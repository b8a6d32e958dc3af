"""Libraries of damage states: grids, random joint damage, lists, and any of them one after the other.

A library is asked for a range of its states and makes only those, so that a million of them need no memory.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError, frozen_floats, is_number, is_whole

STATES = 2
"""First word of the generators' seeds, so that states and noise of one seed have nothing in common."""
RANDOM_BLOCK = 1024
"""Random states that share a generator: state k is the same whichever range is asked for."""


class Part(Protocol):
    """Some states of a library."""

    @property
    def n_states(self) -> int:
        """Number of states."""

    def between(self, first: int, stop: int) -> FloatArray:
        """Return the states first to stop - 1 (stop - first, n_parameters)."""

    def describe(self) -> dict[str, object]:
        """Return the origin of the states, for the side file."""


@dataclass(frozen=True, slots=True)
class StateLibrary:
    """States of damage, fractions of stiffness lost, in a fixed order. Libraries add up: `grid + random`.

    Attributes
    ----------
    parameters : tuple of str
        Names of the damage parameters: the columns of `between`.
    parts : tuple of Part
        What the states come from.

    Examples
    --------
    >>> library = grid_states({"mu1": [0.0, 0.4], "mu2": [0.0, 0.8]}) + listed_states(["mu1", "mu2"], [[0.1, 0.2]])
    >>> len(library), library.between(3, 5).tolist()
    (5, [[0.4, 0.8], [0.1, 0.2]])
    """

    parameters: tuple[str, ...]
    parts: tuple[Part, ...]

    def __len__(self) -> int:
        return sum(part.n_states for part in self.parts)

    def __add__(self, other: "StateLibrary") -> "StateLibrary":
        if self.parameters != other.parameters:
            raise InputError(
                f"state libraries have the parameters {list(self.parameters)} and {list(other.parameters)}; "
                "expected the same in the same order; name all of them in both"
            )
        return StateLibrary(self.parameters, self.parts + other.parts)

    def between(self, first: int, stop: int) -> FloatArray:
        """Return the states first to stop - 1 (stop - first, n_parameters).

        Raises
        ------
        InputError
            If the range leaves the library.
        """
        if not 0 <= first <= stop <= len(self):
            raise InputError(f"states {first} to {stop} were asked for; expected a range within 0 to {len(self)}")
        pieces, start = [np.zeros((0, len(self.parameters)))], 0
        for part in self.parts:
            low, high = max(first - start, 0), min(stop - start, part.n_states)
            if low < high:
                pieces.append(part.between(low, high))
            start += part.n_states
        return np.concatenate(pieces)


def grid_states(levels: Mapping[str, Sequence[float]]) -> StateLibrary:
    """Return every combination of the levels [fraction of stiffness lost] of each parameter, the first one slowest.

    >>> len(grid_states({"mu1": [0.0, 0.4, 0.8], "mu2": [0.0, 0.8]}))
    6

    Raises
    ------
    InputError
        If there is no parameter, one has no level, or a level is outside [0, 1).
    """
    parameters = _checked_parameters(list(levels))
    rows = tuple(tuple(_checked_fractions(levels[name], f"levels of {name}").tolist()) for name in parameters)
    return StateLibrary(parameters, (_Grid(rows),))


def random_states(
    parameters: Sequence[str], n_states: int, *, seed: int, n_damaged: int | None = None, largest: float = 0.8
) -> StateLibrary:
    """Return states of random joint damage.

    In each, 1 to `n_damaged` parameters (any number as likely as another, any set of that number too) lose a share of
    stiffness drawn evenly between 0 and `largest`; the others are undamaged.

    Parameters
    ----------
    parameters : sequence of str
        Names of the damage parameters.
    n_states : int
        Number of states; a million take no more memory than a thousand.
    seed : int
        Seed; a longer library of the same seed begins with the states of a shorter one.
    n_damaged : int, optional
        Most parameters damaged at once; all of them if not given.
    largest : float
        Largest fraction of stiffness lost, in (0, 1).

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> states = random_states(["mu1", "mu2", "mu3"], 1000, seed=0, n_damaged=2, largest=0.5).between(0, 1000)
    >>> int((states > 0.0).sum(axis=1).max()), bool(states.max() < 0.5)
    (2, True)
    """
    names = _checked_parameters(parameters)
    most = len(names) if n_damaged is None else n_damaged
    if not is_whole(n_states) or n_states < 1:
        raise InputError(f"n_states is {n_states!r}; expected 1 or more random states; correct it")
    if not is_whole(most) or not 1 <= most <= len(names):
        raise InputError(f"n_damaged is {most!r}; expected 1 to {len(names)}, the number of parameters; correct it")
    if not is_number(largest) or not 0.0 < largest < 1.0:
        raise InputError(
            f"largest is {largest!r}; expected a fraction of stiffness between 0 and 1 (1 leaves a mechanism); "
            "give it as a fraction, not in percent"
        )
    if not is_whole(seed) or seed < 0:
        raise InputError(f"seed is {seed!r}; expected 0 or more; choose another")
    return StateLibrary(names, (_Random(len(names), n_states, seed, most, largest),))


def listed_states(parameters: Sequence[str], states: FloatArray | Sequence[Sequence[float]]) -> StateLibrary:
    """Return the states (n_states, n_parameters) [fraction of stiffness lost] as they are listed.

    Raises
    ------
    InputError
        If the list is empty, has another number of columns, or a loss is outside [0, 1).

    Examples
    --------
    >>> listed_states(["mu1", "mu2"], [[0.0, 0.0], [0.4, 0.2]]).between(1, 2).tolist()
    [[0.4, 0.2]]
    """
    names = _checked_parameters(parameters)
    rows = frozen_floats(states, "listed states", (-1, len(names)))
    if not len(rows):
        raise InputError("the list of states is empty; expected at least one state; add one, all zeros is healthy")
    _checked_fractions(rows.ravel(), "listed states")
    return StateLibrary(names, (_Listed(rows),))


@dataclass(frozen=True, slots=True)
class _Grid:
    levels: tuple[tuple[float, ...], ...]

    @property
    def n_states(self) -> int:
        return int(np.prod([len(row) for row in self.levels]))

    def between(self, first: int, stop: int) -> FloatArray:
        places = np.unravel_index(np.arange(first, stop), [len(row) for row in self.levels])
        return np.stack([np.array(row)[k] for row, k in zip(self.levels, places, strict=True)], axis=1)

    def describe(self) -> dict[str, object]:
        return {"kind": "grid", "levels": [list(row) for row in self.levels]}


@dataclass(frozen=True, slots=True)
class _Random:
    n_parameters: int
    n_states: int
    seed: int
    n_damaged: int
    largest: float

    def between(self, first: int, stop: int) -> FloatArray:
        blocks = range(first // RANDOM_BLOCK, -(-stop // RANDOM_BLOCK))
        drawn = np.concatenate([self._block(block) for block in blocks])
        start = blocks.start * RANDOM_BLOCK
        return drawn[first - start : stop - start]

    def _block(self, block: int) -> FloatArray:
        rng = np.random.default_rng([STATES, self.seed, block])
        shape = (RANDOM_BLOCK, self.n_parameters)
        counts = rng.integers(1, self.n_damaged + 1, RANDOM_BLOCK)
        order = rng.random(shape).argsort(axis=1).argsort(axis=1)
        return np.where(order < counts[:, None], self.largest * rng.random(shape), 0.0)

    def describe(self) -> dict[str, object]:
        words = {"kind": "random", "n_states": self.n_states, "seed": self.seed}
        return words | {"n_damaged": self.n_damaged, "largest": self.largest}


@dataclass(frozen=True, slots=True, eq=False)
class _Listed:
    rows: FloatArray

    @property
    def n_states(self) -> int:
        return len(self.rows)

    def between(self, first: int, stop: int) -> FloatArray:
        return self.rows[first:stop]

    def describe(self) -> dict[str, object]:
        return {"kind": "list", "n_states": self.n_states}


def _checked_parameters(names: Sequence[str]) -> tuple[str, ...]:
    if isinstance(names, str) or not names or len(set(names)) != len(names):
        raise InputError(
            f"damage parameters are {names!r}; expected one name or more, each once, in a list; "
            "a wing's are wing.parameters"
        )
    return tuple(names)


def _checked_fractions(values: Sequence[float] | FloatArray, where: str) -> FloatArray:
    fractions = frozen_floats(values, where, (-1,))
    if not len(fractions):
        raise InputError(f"{where} are empty; expected at least one fraction of stiffness lost; 0 is healthy")
    bad = fractions[(fractions < 0.0) | (fractions >= 1.0)]
    if len(bad):
        raise InputError(
            f"{where} hold {bad[0]:g}; expected losses of stiffness from 0 to below 1 (1 leaves a mechanism); "
            "give them as fractions, not in percent"
        )
    return fractions
