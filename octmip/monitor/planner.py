"""Planner: which action costs least until the end, by value iteration over state, growth rate and place.

A step costs `cost`, a failure F. With x the place (the steps left, or a point of a course), k the growth rate, s the
state, a the action and h_a(s) its chance of failing,

    Q_a(x, k, s) = cost_a + h_a(s) F + (1 - h_a(s)) E[V(x', k', s') | x, k, s, a],     V = min over a of Q_a.

On a belief the planner takes the action of least expected Q: it supposes that the state will be known from the next
step on (QMDP), so its expectation is a lower bound of any policy's. Where the readings tell little, `told_after` says
after how many steps it may be known: the action is held as long, V taken only then. To inspect costs its price and
tells the state now; the action is then the best one of the state, at the expectation of the least Q.

Source: M. L. Littman, A. R. Cassandra, L. P. Kaelbling, Proc. ICML 12 (1995) 362-370 (QMDP).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, diags_array

from octmip.errors import ProblemError
from octmip.monitor.forecast import checked_chances
from octmip.monitor.growth import Growth

Floats = NDArray[np.float64]

INSPECT = "inspect"
"""Name of the decision to look at the asset before anything else."""


@dataclass(frozen=True, slots=True, eq=False)
class Action:
    """A way to use the asset for one step.

    Attributes
    ----------
    name
        in words.
    cost
        of the step.
    fails
        (n_states,) chance that the asset fails in it.
    growth
        of damage in it; a repair is a growth that leads to a sound state.
    onward
        (n_places, n_places) probability of the next place by this one, each of a lower number: 0 is the end. None: a
        place is the number of steps left.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> fly = Action("fly", cost=0.0, fails=[0.0, 0.1], growth=steady_growth(library, rates=0.04))
    >>> fly.name, fly.growth.n_states
    ('fly', 2)
    """

    name: str
    cost: float
    fails: ArrayLike
    growth: Growth
    onward: csr_array | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Planner:
    """What each action costs until the end.

    Attributes
    ----------
    actions
        to choose from.
    failure
        cost of a failure.
    after
        (n_actions, n_places, n_rates, n_states) expected cost after a step that the asset survives.
    inspection
        price of an inspection; None: there is none.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> calm, fast = (steady_growth(library, rates=rate) for rate in (0.001, 0.04))
    >>> actions = Action("slow", 1.0, [0.0, 0.0], calm), Action("fast", 0.0, [0.0, 0.5], fast)
    >>> plan = Planner.of(actions, failure=100.0, n_steps=10)
    >>> known = np.eye(2)[:, None]  # the state of each of two assets
    >>> [plan.names[k] for k in plan.choose(known, np.array([10, 10]))]
    ['fast', 'slow']
    """

    actions: tuple[Action, ...]
    failure: float
    after: Floats
    inspection: float | None = None

    @classmethod
    def of(
        cls,
        actions: Sequence[Action],
        failure: float,
        n_steps: int,
        inspection: float | None = None,
        told_after: int = 1,
    ) -> "Planner":
        """Return the plan of a task of `n_steps`, or of as many places but the end.

        Raises
        ------
        ProblemError
            an action is of another library or task, or leads to no lower place.

        Examples
        --------
        Drive fast or slowly for 50 steps, or look for a crack at the price of 3 steps:

        >>> from octmip.monitor import Action, Library, Planner, steady_growth
        >>> library = Library(("crack",), [[0.0], [0.4], [0.8]], ("a",), [[1.0], [2.0], [4.0]], 1.0)
        >>> fast = Action("fast", 1.0, (0.0, 0.0, 0.05), steady_growth(library, 0.002))
        >>> slow = Action("slow", 1.5, (0.0, 0.0, 0.0), steady_growth(library, 0.001))
        >>> plan = Planner.of((fast, slow), failure=100.0, n_steps=50, inspection=3.0, told_after=20)
        >>> doubts = np.array([[[0.98, 0.0, 0.02]], [[0.6, 0.0, 0.4]], [[0.0, 0.0, 1.0]]])
        >>> [plan.names[k] for k in plan.choose(doubts, np.array([50, 50, 50]))]
        ['fast', 'inspect', 'slow']
        """
        rows = [_checked(action, n_steps + 1, actions[0].growth) for action in actions]
        shape = (n_steps + 1, actions[0].growth.n_rates, actions[0].growth.n_states)
        value, after = np.zeros(shape), np.zeros((len(actions), *shape))
        held = np.zeros((told_after, len(actions), *shape))  # cost of holding an action for 0, 1, ... steps, then V
        for place in range(1, n_steps + 1):
            for a, (action, onward) in enumerate(zip(actions, rows, strict=True)):
                span = slice(onward.indptr[place], onward.indptr[place + 1])
                ahead, share = onward.indices[span], onward.data[span]
                for m in range(told_after):
                    then = held[m - 1, a] if m else value
                    after[a, place] = _expected(action.growth, np.tensordot(share, then[ahead], 1))
                    held[m, a, place] = _cost(action, np.asarray(action.fails), failure, after[a, place])
            value[place] = held[0, :, place].min(axis=0)
        return cls(tuple(actions), failure, after, inspection)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the decisions, an inspection last."""
        return (*(action.name for action in self.actions), *(() if self.inspection is None else (INSPECT,)))

    def expected(self, weights: Floats, places: NDArray[np.intp]) -> Floats:
        """Return the expected cost (n, n_decisions) of beliefs (n, n_rates, n_states) at places (n,)."""
        costs = [
            _cost(action, np.asarray(action.fails), self.failure, self.after[a, places])
            for a, action in enumerate(self.actions)
        ]
        each = [np.einsum("nks,nks->n", cost, weights) for cost in costs]
        if self.inspection is not None:
            each.append(self.inspection + np.einsum("nks,nks->n", np.minimum.reduce(costs), weights))
        return np.column_stack(each)

    def choose(self, weights: Floats, places: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return the decision (n,) of least expected cost, an index of `names`; the first of equal ones."""
        return np.asarray(self.expected(weights, places).argmin(axis=1))

    def choose_knowing(
        self, fails: Floats, rates: NDArray[np.intp], states: NDArray[np.intp], places: NDArray[np.intp]
    ) -> NDArray[np.intp]:
        """Return the action (n,) where rates and states (n,) are known, and chances (n_actions, n) of failing."""
        after = self.after[:, places, rates, states]
        costs = [_cost(action, fails[a], self.failure, after[a]) for a, action in enumerate(self.actions)]
        return np.asarray(np.argmin(costs, axis=0))


def _cost(action: Action, fails: Floats, failure: float, after: Floats) -> Floats:
    return np.asarray(action.cost + fails * failure + (1.0 - fails) * after)


def _expected(growth: Growth, value: Floats) -> Floats:
    """Return E[value (n_rates, n_states) of the next step] by rate and state of this one."""
    moved, behind = growth.changes @ value, growth.n_states
    for table in growth.tables:
        levels = table.shape[1]
        behind //= levels
        moved = (table[:, None] @ moved.reshape(growth.n_rates, -1, levels, behind)).reshape(value.shape)
    return np.asarray(moved)


def _checked(action: Action, n_places: int, first: Growth) -> csr_array:
    """Return where an action leads, of an action that is checked."""
    checked_chances(action.fails, f"fails of {action.name!r}", first.n_states)
    own, expected = ((one.n_rates, one.n_states) for one in (action.growth, first))
    if own != expected:
        raise ProblemError(
            f"growth of {action.name!r} has {own} rates and states; expected {expected} as the first action; make all "
            "for one library"
        )
    onward = action.onward
    if onward is None:
        onward = csr_array(diags_array(np.ones(n_places - 1), offsets=-1))
    places, ahead = onward.nonzero()
    if onward.shape != (n_places, n_places) or (ahead >= places).any():
        raise ProblemError(
            f"onward of {action.name!r} has shape {onward.shape} or leads to a place that is not lower; expected "
            f"({n_places}, {n_places}), each step to places of a lower number; number them from the end"
        )
    return onward
