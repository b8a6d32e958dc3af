"""RiskModel: how likely a state fails, what a wrong decision costs, and the Problem of a tree that decides by both.

A state has a loss d_r (a fraction of the stiffness) in each region r, and is flown at one of several load factors n. It
fails where its worst region has lost more than the limit of that load factor, or about there:

    step         P(fail | d, n) = 1 if max_r d_r > limit_n else 0                 spread = 0
    logistic     P(fail | d, n) = 1 / (1 + exp(-(max_r d_r - limit_n) / spread))
    lognormal    P(fail | d, n) = Phi(ln(max_r d_r / limit_n) / spread)

or with the probability that `failure` gives, such as a twin's.

Deciding for n costs `failure_loss` P(fail | d, n) + `caution_losses[n]` in expectation; the regret of a decision is
that less the least over all decisions. A tree of least regret is what a `Problem` with these weights and costs asks
for. Regions share one uncertainty, so the worst one decides; regions that fail independently of each other fail more
often.

Source: the step at 40 % for 3 g: M. G. Kapteyn, K. E. Willcox (2020), section 5. Logistic and lognormal fragility: J.
W. Baker, Efficient analytical fragility function fitting (2015), eq. 1.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem

Floats = NDArray[np.float64]
Shape = Literal["logistic", "lognormal"]


@dataclass(frozen=True, slots=True)
class ErrorRates:
    """Error rates of decisions on states whose truth is known.

    Attributes
    ----------
    missed_critical
        share of the critical states for which the boldest load factor was allowed.
    false_alarm
        share of the other states for which it was not.
    regret
        mean regret of a decision, in units of `failure_loss`.
    n_critical, n_sound
        states of both kinds; a share of none is nan.
    """

    missed_critical: float
    false_alarm: float
    regret: float
    n_critical: int
    n_sound: int


@dataclass(frozen=True, slots=True)
class RiskModel:
    """Probability of failure of a state, and the costs of failure and of caution.

    Attributes
    ----------
    load_factors
        to decide between, the boldest first [g].
    limit_losses
        loss of stiffness that the wing bears at each of them, rising, as fractions.
    caution_losses
        what each costs for not being the boldest (a longer way), rising from 0.
    failure_loss
        what a failure costs, in the same unit. Between two decisions, the cautious one is right from
        P(fail) = caution / failure_loss on.
    spread
        of the limit; 0: a step.
    shape
        of the probability of failure where spread > 0.
    failure
        P(fail) (n,) of states (n, n_regions) at a load factor, in place of limits and spread.

    Raises
    ------
    ProblemError
        lists of different length or order, or numbers out of range.
    """

    load_factors: tuple[float, ...] = (3.0, 2.0)
    limit_losses: tuple[float, ...] = (0.4, 0.8)
    caution_losses: tuple[float, ...] = (0.0, 1.0)
    failure_loss: float = 10.0
    spread: float = 0.0
    shape: Shape = "logistic"
    failure: Callable[[Floats, float], ArrayLike] | None = None

    def __post_init__(self) -> None:
        for name, sign in (("load_factors", -1.0), ("limit_losses", 1.0), ("caution_losses", 1.0)):
            values = tuple(float(value) for value in getattr(self, name))
            object.__setattr__(self, name, values)
            if len(values) != len(self.load_factors) or len(values) < 2:
                raise ProblemError(f"{name} has {len(values)} entries; expected one for each load factor, two or more")
            is_ordered = all(sign * (b - a) > 0 for a, b in itertools.pairwise(values))
            if not is_ordered or not all(math.isfinite(value) for value in values) or min(values) < 0:
                order = "rising" if sign > 0 else "falling"
                raise ProblemError(f"{name} is {values}; expected {order} numbers of 0 or more, boldest load first")
        if self.caution_losses[0] != 0 or max(self.limit_losses) > 1 or min(self.limit_losses) == 0:
            raise ProblemError(
                f"caution_losses begin with {self.caution_losses[0]} and limit_losses are {self.limit_losses}; "
                "expected 0 for the boldest load factor, and fractions above 0"
            )
        for name in ("failure_loss", "spread"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise ProblemError(f"{name} is {value}; expected a finite number of 0 or more")
        if self.shape not in ("logistic", "lognormal"):
            raise ProblemError(f"shape is {self.shape!r}; expected 'logistic' or 'lognormal'")

    @property
    def decision_names(self) -> tuple[str, ...]:
        """Names of the decisions: "3 g allowed", "2 g only"."""
        boldest, *others = self.load_factors
        return (f"{boldest:g} g allowed", *(f"{load:g} g only" for load in others))

    def failure_probability(self, losses: ArrayLike, load_factor: float) -> Floats:
        """Return the probability (n,) that states of losses (n, n_regions) fail at one of the load factors.

        Raises
        ------
        ProblemError
            the load factor is none of the model's, or a loss is no fraction.
        """
        if load_factor not in self.load_factors:
            raise ProblemError(
                f"load_factor is {load_factor}; expected one of {self.load_factors}; add it to the model"
            )
        from scipy.special import expit, ndtr  # only here: every command would wait for it

        worst = _worst(losses)
        if self.failure is not None:
            found = np.asarray(self.failure(np.asarray(losses, dtype=np.float64), load_factor), dtype=np.float64)
            if found.shape != worst.shape or not ((found >= 0.0) & (found <= 1.0)).all():
                raise ProblemError(
                    f"failure gave {found.shape} numbers for {len(worst)} states; expected one from 0 to 1 for each"
                )
            return found
        limit = self.limit_losses[self.load_factors.index(load_factor)]
        if self.spread == 0:
            return np.asarray(worst > limit, dtype=np.float64)
        if self.shape == "logistic":
            return np.asarray(expit((worst - limit) / self.spread))
        with np.errstate(divide="ignore"):  # no loss: ln 0 = -inf, which never fails
            return np.asarray(ndtr(np.log(worst / limit) / self.spread))

    def expected_losses(self, losses: ArrayLike) -> Floats:
        """Return what each decision costs in expectation (n, n_decisions) in states of losses (n, n_regions)."""
        failing = np.stack([self.failure_probability(losses, load) for load in self.load_factors], axis=1)
        return np.asarray(self.failure_loss * failing + np.array(self.caution_losses))

    def regrets(self, losses: ArrayLike) -> Floats:
        """Return what each decision costs more than the best one (n, n_decisions)."""
        expected = self.expected_losses(losses)
        return np.asarray(expected - expected.min(axis=1, keepdims=True))

    def decisions(self, losses: ArrayLike) -> NDArray[np.int64]:
        """Return the best decision (n,), as an index of `load_factors`; among equals the boldest."""
        return np.asarray(self.expected_losses(losses).argmin(axis=1), dtype=np.int64)

    def is_critical(self, losses: ArrayLike) -> NDArray[np.bool_]:
        """Return which states (n,) have lost more in some region than the boldest load factor's limit.

        With `failure` those that more likely fail than not.
        """
        if self.failure is not None:
            return np.asarray(self.failure_probability(losses, self.load_factors[0]) > 0.5)
        return np.asarray(_worst(losses) > self.limit_losses[0])

    def decision_problem(self, features: ArrayLike, losses: ArrayLike, *, depth: int, **options: Any) -> Problem:
        """Return the problem whose classes are the two decisions and whose weights are the regret of the wrong one.

        Parameters
        ----------
        features
            (n_samples, n_features).
        losses
            (n_samples, n_regions) true losses.
        options
            of `Problem`; `weights` are multiplied.

        Raises
        ------
        ProblemError
            there are more than two decisions, or it makes no problem.
        """
        if len(self.load_factors) != 2:
            raise ProblemError(
                f"there are {len(self.load_factors)} decisions, whose regrets are no weights; use state_problem"
            )
        weights = self.regrets(losses).max(axis=1) * np.asarray(options.pop("weights", 1.0))
        names = np.array(self.decision_names)
        labels = names[self.decisions(losses)]
        options = {"class_names": self.decision_names, "weights": weights, **options}
        return Problem(features, labels, depth=depth, **options)

    def state_problem(
        self,
        features: ArrayLike,
        labels: ArrayLike,
        losses_of_label: Mapping[Any, float | Sequence[float]],
        *,
        depth: int,
        error_cost: float = 1.0,
        **options: Any,
    ) -> Problem:
        """Return the problem whose classes are states: a wrong one costs `error_cost` and the regret it leads to.

        Parameters
        ----------
        features
            (n_samples, n_features).
        labels
            (n_samples,) true states.
        losses_of_label
            loss in the region, or in each region, of every state.
        options
            of `Problem`.

        Raises
        ------
        ProblemError
            a label has no losses, or it makes no problem.
        """
        missing = sorted({str(label) for label in np.unique(np.asarray(labels)) if label not in losses_of_label})
        if missing:
            raise ProblemError(f"losses_of_label lacks the labels {missing}; give the losses of every state")
        names = tuple(losses_of_label)
        losses = self.losses_of_classes(losses_of_label)
        costs = self.regrets(losses)[:, self.decisions(losses)] + error_cost * (1.0 - np.eye(len(names)))
        return Problem(features, labels, depth=depth, loss=ClassCosts(costs), class_names=names, **options)

    @staticmethod
    def losses_of_classes(losses_of_label: Mapping[Any, float | Sequence[float]]) -> Floats:
        """Return the losses (n_classes, n_regions) of the classes of a `state_problem`, in its order."""
        return np.array([np.atleast_1d(losses) for losses in losses_of_label.values()], dtype=np.float64)

    def rates(self, losses: ArrayLike, decided: ArrayLike) -> ErrorRates:
        """Return what decisions (n,), indices of `load_factors`, did to states of true losses (n, n_regions)."""
        chosen = np.asarray(decided, dtype=np.int64)
        is_critical = self.is_critical(losses)
        if chosen.shape != is_critical.shape or (
            chosen.size and not 0 <= chosen.min() <= chosen.max() < len(self.load_factors)
        ):
            raise ProblemError(
                f"decided has shape {chosen.shape} for {len(is_critical)} states; expected one index below "
                f"{len(self.load_factors)} each"
            )
        regrets = self.regrets(losses)[np.arange(len(chosen)), chosen]
        is_bold = chosen == 0
        return ErrorRates(
            missed_critical=_share(is_bold[is_critical]),
            false_alarm=_share(~is_bold[~is_critical]),
            regret=float(regrets.mean()) if len(regrets) else math.nan,
            n_critical=int(is_critical.sum()),
            n_sound=int((~is_critical).sum()),
        )


def _share(flags: NDArray[np.bool_]) -> float:
    return float(flags.mean()) if flags.size else math.nan


def _worst(losses: ArrayLike) -> Floats:
    """Return the worst region's loss (n,) of losses (n, n_regions)."""
    table = np.array(losses, dtype=np.float64)
    if table.ndim != 2 or not table.shape[1]:
        raise ProblemError(f"losses has shape {table.shape}; expected (n_states, n_regions), one column per region")
    if not ((table >= 0) & (table <= 1)).all():
        wrong = table[~((table >= 0) & (table <= 1))][0]
        raise ProblemError(f"losses holds {wrong}; expected fractions from 0 to 1 (0.4, not 40 percent)")
    return np.asarray(table.max(axis=1))
