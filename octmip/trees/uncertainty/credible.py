"""Credible sets: classes that hold the truth with a stated probability, whatever the distribution is (split-conformal).

Samples that took no part in the training say how unusual the truth is: s_i = 1 - P(y_i | x_i). With q the r-th
smallest of n such scores, r = ceil((n + 1) coverage), the set {k : 1 - P(k | x) <= q} of a further sample holds its
class with

    coverage  <=  P(y in set)                      over the draws of all n + 1 samples, exchangeable, no other
    assumption P(y in set | these n samples)  ~  Beta(r, n + 1 - r), or more where scores tie

so that even thresholds out of an unlucky draw are worth a stated coverage (`CredibleSets.assured`). A tree has as many
scores as leaves times classes: they tie, and sets are then larger than asked for. With random numbers to break
ties the first line holds with coverage + 1 / (n + 1) as its upper end. Class by class (Mondrian), with a threshold
from the samples of each class alone, the lines hold for each class by itself: also for the rare and critical one.

Source: V. Vovk, A. Gammerman, G. Shafer, Algorithmic Learning in a Random World (2005), chapters 2 and 4; Beta: V.
Vovk, Conditional validity of inductive conformal predictors (2012), proposition 2a. Weights: R. J. Tibshirani and
others, Conformal prediction under covariate shift (2019), eq. 7.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class CredibleSets:
    """Thresholds of the scores, one per class.

    Attributes
    ----------
    coverage
        asked for.
    thresholds
        (n_classes,) largest score in the set; inf: the class is in every set.
    ties
        (n_classes,) share of the samples at the threshold itself that are in the set.
    ranks
        (n_classes,) r of the module's text; n_samples: (n_classes,) scores that it was taken of.
    by_class
        whether coverage holds for each class by itself.
    """

    coverage: float
    thresholds: Floats
    ties: Floats
    ranks: NDArray[np.int64]
    n_samples: NDArray[np.int64]
    by_class: bool

    def sets(self, probabilities: ArrayLike, rng: np.random.Generator | None = None) -> NDArray[np.bool_]:
        """Return which classes are in the set of each row (n, n_classes) of probabilities, shape (n, n_classes).

        Without `rng` scores at the threshold are all in the set: never less than the coverage, often more.
        """
        scores = 1.0 - _table(probabilities)
        if scores.shape[1] != len(self.thresholds):
            raise ProblemError(
                f"probabilities has {scores.shape[1]} columns; expected {len(self.thresholds)}, one per class"
            )
        if rng is None:
            return np.asarray(scores <= self.thresholds)
        is_in = rng.random((len(scores), 1)) <= self.ties
        return np.asarray(
            (scores < self.thresholds) | ((scores == self.thresholds) & is_in) | np.isinf(self.thresholds)
        )

    def assured(self, confidence: float = 0.95) -> Floats:
        """Return the coverage (n_classes,) that these very thresholds have with this confidence at least.

        Of unweighted scores; where all classes share one threshold all entries are the same.
        """
        if not 0.0 < confidence < 1.0:
            raise ProblemError(f"confidence is {confidence}; expected a share between 0 and 1")
        from scipy.special import betaincinv  # only here: every command would wait for it

        is_all = self.ranks > self.n_samples
        low = betaincinv(self.ranks, np.where(is_all, 1, self.n_samples + 1 - self.ranks), 1.0 - confidence)
        return np.asarray(np.where(is_all, 1.0, low))


def calibrate_sets(
    probabilities: ArrayLike,
    codes: ArrayLike,
    *,
    coverage: float = 0.9,
    by_class: bool = False,
    weights: ArrayLike | None = None,
    rng: np.random.Generator | None = None,
) -> CredibleSets:
    """Return the thresholds from samples that took no part in the training.

    Parameters
    ----------
    probabilities
        (n, n_classes) that the tree gives them; codes: (n,) index of each true class.
    by_class
        a threshold for each class. A class with fewer than coverage / (1 - coverage) samples is in every set.
    weights
        (n,) how often what each sample stands for comes where the sets are used, relative to here; a sample to
        come counts as the heaviest of them, which is on the safe side.
    rng
        breaks ties; then give one to `CredibleSets.sets` too.

    Raises
    ------
    ProblemError
        shapes or ranges are wrong.
    """
    table, truth = _table(probabilities), np.asarray(codes)
    weight = np.ones(len(table)) if weights is None else np.asarray(weights, dtype=np.float64)
    if truth.shape != (len(table),) or weight.shape != truth.shape or truth.dtype.kind not in "iu":
        raise ProblemError(
            f"codes and weights have shapes {truth.shape}, {weight.shape}; expected "
            f"({len(table)},), codes whole numbers"
        )
    if not 0.0 < coverage < 1.0 or (weight < 0).any() or not ((truth >= 0) & (truth < table.shape[1])).all():
        raise ProblemError(f"coverage is {coverage}; expected a share, weights of 0 or more and codes of classes")
    scores = 1.0 - table[np.arange(len(truth)), truth]
    drawn = np.ones(len(scores)) if rng is None else rng.random(len(scores))
    groups = [truth == k if by_class else np.ones(len(truth), dtype=bool) for k in range(table.shape[1])]
    found = [_threshold(scores[g], drawn[g], weight[g], coverage) for g in groups]
    thresholds, ties = np.array([f[0] for f in found]), np.array([f[1] for f in found])
    ranks, sizes = np.array([f[2] for f in found]), np.array([int(g.sum()) for g in groups])
    return CredibleSets(coverage, thresholds, ties, ranks, sizes, by_class)


def _threshold(scores: Floats, drawn: Floats, weight: Floats, coverage: float) -> tuple[float, float, int]:
    """Return the threshold, the share of those at it that are in the set, and its rank among the scores, from 1."""
    if not weight.sum() > 0:
        return math.inf, 1.0, len(scores) + 1
    order = np.lexsort((drawn, scores))
    running = np.cumsum(weight[order])
    # one more sample, of infinite score and the largest weight, stands for the one to come
    needed = coverage * (running[-1] + weight.max())
    rank = int(np.searchsorted(running, needed * (1.0 - 1e-12)))
    if rank == len(scores):
        return math.inf, 1.0, rank + 1
    return float(scores[order[rank]]), float(drawn[order[rank]]), rank + 1


def _table(probabilities: ArrayLike) -> Floats:
    table = np.asarray(probabilities, dtype=np.float64)
    if table.ndim != 2 or not np.isfinite(table).all():
        raise ProblemError(f"probabilities has shape {table.shape}; expected finite numbers (n, n_classes)")
    return table
