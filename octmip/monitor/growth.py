"""Growth: how damage changes from one reading to the next, as probabilities between the states of a library.

Damage does not heal. In one step a parameter stays on its level, goes up to the next with probability rate / gap (so
that it grows by `rate` in the mean), or, with probability `sudden`, jumps to any higher level, each as likely.
Parameters grow independently. Which rates hold is not known: every combination of the parameters' rates is one growth
rate of the chain, hidden like the state, and changes to any other with a small probability.
"""

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.monitor.library import Library, grid_states

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """A Markov chain over growth rates and states.

    The states are all combinations of the levels of one or more axes, the last axis fastest, and the axes grow
    independently: one small table per axis instead of one large one. Any chain at all is one axis with its full table.

    Attributes
    ----------
    tables
        for each axis (n_rates, n_levels, n_levels), from the row's level to the column's in one step.
    changes
        (n_rates, n_rates), from one growth rate to another in one step.

    Examples
    --------
    >>> growth = Growth((np.array([[[0.9, 0.1], [0.0, 1.0]]]),), changes=np.eye(1))  # one rate, two states
    >>> growth.advance(np.array([[[1.0, 0.0]]])).tolist()
    [[[0.9, 0.1]]]
    """

    tables: tuple[Floats, ...]
    changes: Floats

    def __post_init__(self) -> None:
        if isinstance(self.tables, np.ndarray):
            raise ProblemError("tables is one array; expected a tuple of them, one for each axis of the states")
        object.__setattr__(self, "tables", tuple(probabilities(table, "tables", 3) for table in self.tables))
        object.__setattr__(self, "changes", probabilities(self.changes, "changes", 2))
        lengths = {len(table) for table in self.tables}
        if lengths != {len(self.changes)}:
            raise ProblemError(
                f"tables have {sorted(lengths)} growth rates but changes {len(self.changes)}; give all for the same "
                "growth rates"
            )

    @property
    def n_rates(self) -> int:
        """Number of growth rates."""
        return len(self.changes)

    @property
    def n_states(self) -> int:
        """Number of states."""
        return math.prod(table.shape[1] for table in self.tables)

    @property
    def transitions(self) -> Floats:
        """Probabilities (n_rates, n_states, n_states) from the row's state to the column's in one step."""
        return np.array([functools.reduce(np.kron, axes) for axes in zip(*self.tables, strict=True)])

    def advance(self, weights: Floats) -> Floats:
        """Return the probabilities (n, n_rates, n_states) of growth rates and states one step later."""
        moved, behind = np.asarray(weights, dtype=np.float64), self.n_states
        for table in self.tables:
            levels = table.shape[1]
            behind //= levels
            ahead = self.n_states // (levels * behind)  # not -1, which numpy cannot infer where there is no asset
            axes = moved.reshape(len(weights), self.n_rates, ahead, levels, behind)
            moved = table.swapaxes(1, 2)[:, None] @ axes if behind > 1 else (axes[..., 0] @ table)
        moved = moved.reshape(len(weights), self.n_rates, self.n_states)
        return np.asarray(self.changes.T @ moved if self.n_rates > 1 else moved)


def probabilities(values: Floats, name: str, n_axes: int, length: int | None = None) -> Floats:
    """Return probabilities, checked: a square of the last two axes, or of one axis as many as `length`."""
    table = np.array(values, dtype=np.float64)
    if table.ndim != n_axes or table.shape[-1] != (length or table.shape[-2:][0]):
        kind = f"{length} numbers" if length else f"{n_axes} axes, the last two a square"
        raise ProblemError(f"{name} has shape {table.shape}; expected {kind}")
    if not (table >= 0).all() or not np.allclose(table.sum(axis=-1), 1.0):
        raise ProblemError(
            f"{name} has an entry of {table.min()} and rows that add up to {table.sum(axis=-1).min()} to "
            f"{table.sum(axis=-1).max()}; expected probabilities, 1 in every row"
        )
    table.flags.writeable = False
    return table


def steady_growth(library: Library, rates: float | Sequence[float], sudden: float = 0.0, change: float = 0.0) -> Growth:
    """Return the growth of a library whose every parameter grows at one of `rates` per step in the mean.

    Parameters
    ----------
    rates
        fractions per step; each parameter may have each.
    sudden
        probability of a jump of a parameter per step.
    change
        probability of another growth rate per step.

    Raises
    ------
    ProblemError
        a rate or probability is outside of 0 to 1, or a step would skip levels.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> growth = steady_growth(library, rates=(0.004, 0.04))  # of crack, a step
    >>> growth.transitions[:, 0].round(3).tolist()
    [[0.99, 0.01], [0.9, 0.1]]
    """
    given = np.atleast_1d(np.asarray(rates, dtype=np.float64)).tolist()
    levels = [np.unique(column) for column in library.states.T]
    combinations = list(itertools.product(given, repeat=len(levels)))
    tables = [
        np.array([_level_table(of_axis, rates_of[k], sudden, library.parameters[k]) for rates_of in combinations])
        for k, of_axis in enumerate(levels)
    ]
    n = len(combinations)
    changes = np.full((n, n), change / max(1, n - 1))
    np.fill_diagonal(changes, 1.0 - change if n > 1 else 1.0)
    grid = grid_states([of_axis.tolist() for of_axis in levels])
    if np.array_equal(grid, library.states):
        return Growth(tuple(tables), changes)
    return Growth((_within(Growth(tuple(tables), changes).transitions, grid, library.states),), changes)


def _within(transitions: Floats, grid: Floats, states: Floats) -> Floats:
    """Return the transitions between those states of a grid that a library holds; what would leave them stays in."""
    at = [int(np.flatnonzero((grid == state).all(axis=1))[0]) for state in states]
    kept = transitions[:, at][:, :, at]
    return np.asarray(kept / kept.sum(axis=2, keepdims=True))


def _level_table(levels: Floats, rate: float, sudden: float, name: str) -> Floats:
    """Return the transitions (n_levels, n_levels) of one parameter."""
    gaps = np.diff(levels)
    if not 0.0 <= sudden <= 1.0 or rate < 0.0 or (gaps.size and rate / gaps.min() + sudden > 1.0):
        raise ProblemError(
            f"{name} grows by {rate} per step with jumps of probability {sudden}, on levels {gaps.min(initial=1.0):g} "
            "apart; expected 0 or more, and less than one level per step; use coarser levels or shorter steps"
        )
    n = len(levels)
    table = np.zeros((n, n))
    for j in range(n - 1):
        table[j, j + 1] = rate / gaps[j]
        table[j, j + 1 :] += sudden / (n - 1 - j)
        table[j, j] = 1.0 - table[j].sum()
    table[n - 1, n - 1] = 1.0
    return table
