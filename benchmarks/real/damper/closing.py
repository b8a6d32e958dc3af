"""How far the force of tests that were not used closes: amplitudes and frequencies held out in turn.

The tests of one series with the same frequency and amplitude are held out together, so that what predicts them has
seen neither (tests one by one, where all are the same). The twin is fitted to the other tests, and so is what the
diagnosis found there; both know the held-out test's displacement and its tension reading at the tight end, one number a
direction. Closed is 1 - (sum of squares left) / (sum of squares that the twin leaves), over the samples of all kept
half cycles. The limit is what a regression of the force on stroke, time, phase, velocity, acceleration and friction
levels (a forest of random trees) closes in the same way: it knows nothing of slack, but may take any form.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from sklearn.ensemble import ExtraTreesRegressor

from benchmarks.real.damper.cycles import Samples
from benchmarks.real.damper.lacking import Found, Lacking, modelled, with_extras
from benchmarks.real.damper.path import fitted
from benchmarks.real.damper.series import Recording
from femlib.arrays import FloatArray

ALIKE = 0.1
"""Tests whose frequency and amplitude differ by less than this share are held out together."""


@dataclass(frozen=True, slots=True)
class Closed:
    """Sums of squares [kip2] over held-out samples: of the twin, of what the diagnosis found, of the regression."""

    twin: float
    found: float
    regression: float
    samples: int

    @property
    def share(self) -> float:
        """Share of the square that is closed; 0 where nothing was held out."""
        return 1.0 - self.found / self.twin if self.twin > 0.0 else 0.0

    @property
    def limit(self) -> float:
        """Share of the square that the regression closes."""
        return 1.0 - self.regression / self.twin if self.twin > 0.0 else 0.0

    def __add__(self, other: "Closed") -> "Closed":
        """Return the sums over both."""
        return Closed(
            self.twin + other.twin,
            self.found + other.found,
            self.regression + other.regression,
            self.samples + other.samples,
        )


NOTHING = Closed(0.0, 0.0, 0.0, 0)


def folds(tests: Sequence[Recording], use: Sequence[int]) -> list[list[int]]:
    """Return the tests that are held out together, each fold once; `use` are the tests that have a say."""
    found: list[list[int]] = []
    for k in use:
        for fold in found:
            first = tests[fold[0]]
            pairs = ((tests[k].frequency, first.frequency), (tests[k].amplitude, first.amplitude))
            if all(abs(np.log(one / other)) < ALIKE for one, other in pairs):
                fold.append(k)
                break
        else:
            found.append([k])
    return found if len(found) > 1 else [[k] for k in use]


def closed(tests: Sequence[Recording], data: Samples, verdict: Lacking, sound: Sequence[int]) -> Closed:
    """Return the sums of squares over all folds of the sound tests."""
    total = NOTHING
    there = [k for k in sound if np.any(data.test == k)]
    for fold in folds(tests, there):
        known = [k for k in there if k not in fold]
        if known:
            total += one_fold(data.of(known), data.of(fold), verdict)
    return total


def one_fold(known: Samples, held: Samples, verdict: Lacking) -> Closed:
    """Return the sums of squares on held-out samples, everything fitted to the known ones."""
    twin = Found(fitted("twin", "stroke", known), {})
    path = fitted(verdict.best.path.kind, verdict.best.path.coordinate, known, verdict.best.path)
    found = with_extras(path, tuple(verdict.best.extras), known)
    reference = float(np.median(known.now))
    models: list[Callable[[Samples], FloatArray]] = [
        lambda data: modelled(twin, data, reference),
        lambda data: modelled(found, data, reference),
        regression(known),
    ]
    left = [float(np.sum((held.force - model(held)) ** 2)) for model in models]
    return Closed(left[0], left[1], left[2], len(held.force))


def regression(known: Samples) -> Callable[[Samples], FloatArray]:
    """Return the regression fitted to the known samples."""
    trees = ExtraTreesRegressor(n_estimators=10, min_samples_leaf=8, random_state=0, n_jobs=1)
    trees.fit(inputs(known), known.force * known.half)
    return lambda data: np.asarray(trees.predict(inputs(data)) * data.half)


def inputs(data: Samples) -> FloatArray:
    """Return the regression's inputs (n_samples, 8), signs along the motion."""
    along = (data.velocity * data.half, data.acceleration * data.half)
    return np.column_stack([data.stroke, data.since, data.phase, *along, data.before, data.now, data.half])
