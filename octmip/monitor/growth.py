"""Growth: how damage changes from one reading to the next, as probabilities between the states of a library.

Damage does not heal. In one step a parameter stays on its level, goes up to the next with probability rate / gap (so
that it grows by `rate` in the mean), or, with probability `sudden`, jumps to any higher level, each as likely.
Parameters grow independently. Which rate holds is not known: every combination of rates is a pace of its own, hidden
like the state, and changes to any other with a small probability.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.monitor.library import Library

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """A Markov chain over paces and states.

    Attributes:
        transitions: (n_paces, n_states, n_states), from the row's state to the column's in one step at each pace.
        changes: (n_paces, n_paces), from one pace to another in one step.
    """

    transitions: Floats
    changes: Floats

    def __post_init__(self) -> None:
        for name, n_axes in (("transitions", 3), ("changes", 2)):
            table = np.array(getattr(self, name), dtype=np.float64)
            if table.ndim != n_axes or table.shape[-1] != table.shape[-2]:
                raise ProblemError(f"{name} has shape {table.shape}; expected {n_axes} axes, the last two a square")
            if not (table >= 0).all() or not np.allclose(table.sum(axis=-1), 1.0):
                raise ProblemError(
                    f"{name} has an entry of {table.min()} and rows that add up to {table.sum(axis=-1).min()} to "
                    f"{table.sum(axis=-1).max()}; expected probabilities, 1 in every row"
                )
            table.flags.writeable = False
            object.__setattr__(self, name, table)
        if len(self.transitions) != len(self.changes):
            raise ProblemError(
                f"transitions has {len(self.transitions)} paces but changes {len(self.changes)}; give both for all"
            )

    @property
    def n_paces(self) -> int:
        """Number of paces."""
        return len(self.changes)

    @property
    def n_states(self) -> int:
        """Number of states."""
        return int(self.transitions.shape[1])

    def advance(self, weights: Floats) -> Floats:
        """Return the probabilities (n, n_paces, n_states) of paces and states one step later."""
        moved = np.stack([weights[:, k] @ table for k, table in enumerate(self.transitions)], axis=1)
        return np.asarray(np.einsum("nks,kl->nls", moved, self.changes, optimize=True)) if self.n_paces > 1 else moved


def steady_growth(library: Library, rates: float | Sequence[float], sudden: float = 0.0, change: float = 0.0) -> Growth:
    """Return the growth of a library whose every parameter grows at one of `rates` a step in the mean.

    Args:
        rates: fractions a step; each parameter may have each.
        sudden: probability of a jump of a parameter in a step.
        change: probability of another pace in a step.

    Raises:
        ProblemError: a rate or probability is outside of 0 to 1, or a step would skip levels.
    """
    given = np.atleast_1d(np.asarray(rates, dtype=np.float64)).tolist()
    tables = [_parameter_tables(library, k, given, sudden) for k in range(len(library.parameters))]
    transitions = np.array([np.prod(chosen, axis=0) for chosen in itertools.product(*tables)])
    transitions /= transitions.sum(axis=2, keepdims=True)  # a library need not hold every combination of levels
    n = len(transitions)
    changes = np.full((n, n), change / max(1, n - 1))
    np.fill_diagonal(changes, 1.0 - change if n > 1 else 1.0)
    return Growth(transitions, changes)


def _parameter_tables(library: Library, k: int, rates: list[float], sudden: float) -> list[Floats]:
    """Return for every rate the transitions (n_states, n_states) of one parameter, the others left alone."""
    levels, at = np.unique(library.states[:, k], return_inverse=True)
    return [_level_table(levels, rate, sudden, library.parameters[k])[np.ix_(at, at)] for rate in rates]


def _level_table(levels: Floats, rate: float, sudden: float, name: str) -> Floats:
    """Return the transitions (n_levels, n_levels) of one parameter."""
    gaps = np.diff(levels)
    if not 0.0 <= sudden <= 1.0 or rate < 0.0 or (gaps.size and rate / gaps.min() + sudden > 1.0):
        raise ProblemError(
            f"{name} grows by {rate} a step with jumps of probability {sudden}, on levels {gaps.min(initial=1.0):g} "
            "apart; expected 0 or more, and less than one level a step; use coarser levels or shorter steps"
        )
    n = len(levels)
    table = np.zeros((n, n))
    for j in range(n - 1):
        table[j, j + 1] = rate / gaps[j]
        table[j, j + 1 :] += sudden / (n - 1 - j)
        table[j, j] = 1.0 - table[j].sum()
    table[n - 1, n - 1] = 1.0
    return table
