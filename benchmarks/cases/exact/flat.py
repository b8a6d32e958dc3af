"""Data by published formulas on which many trees err about as often: depth 3, at 1,000 rows and in full size.

The number of errors hardly depends on where a cut lies, so that a bound rules out few cuts. The formulas are those of
Breiman, Friedman, Olshen and Stone (1984; waveform), Breiman (1996; twonorm, ringnorm), Friedman (1991), Guyon (2003;
the generator of Madelon, as scikit-learn has it), labels drawn without regard to the features, and channels that drift
together while a label stays for hundreds of rows, as in recordings of an electroencephalogram.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from sklearn.datasets import make_classification, make_friedman1

from benchmarks.case import Case
from benchmarks.data import Table
from benchmarks.tables import race_table
from octmip.trees.problem import Problem

SMALL = 1_000


def cases() -> Iterator[Case]:
    """Yield two cases for each formula, the smaller ones first."""
    for n_rows in (SMALL, 0):
        for name, (n_full, make) in FORMULAS.items():
            n = n_rows or n_full
            yield Case(f"{name}, {n} rows, depth 3", 0, partial(_problem, make, n), ("octmip", "pycontree"))


def _problem(make: Callable[[np.random.Generator, int], Table], n: int) -> Problem:
    table = make(np.random.default_rng(0), n)
    return Problem(table.features, table.labels, depth=3)


def _waveform(random: np.random.Generator, n: int, *, two_classes: bool = False) -> Table:
    """Return waveforms: 21 features and 19 of noise alone, two decimals; of two classes, class 0 against the others."""
    peaks = [np.maximum(6 - abs(np.arange(1, 22) - centre), 0) for centre in (11, 15, 7)]
    first, second = np.array(peaks)[[0, 0, 1]], np.array(peaks)[[1, 2, 2]]
    labels, share = random.integers(0, 3, n), random.random((n, 1))
    waves = share * first[labels] + (1 - share) * second[labels] + random.normal(size=(n, 21))
    features = np.round(np.hstack([waves, random.normal(size=(n, 19))]), 2)
    return Table(features, (labels == 0).astype(np.int64) if two_classes else labels)


def _twonorm(random: np.random.Generator, n: int) -> Table:
    labels = random.integers(0, 2, n)
    return Table(random.normal(size=(n, 20)) + (4 * labels[:, None] - 2) / np.sqrt(20), labels)


def _ringnorm(random: np.random.Generator, n: int) -> Table:
    labels = random.integers(0, 2, n)
    inner = random.normal(size=(n, 20)) + 1 / np.sqrt(20)
    return Table(np.where(labels[:, None] == 1, inner, 2 * random.normal(size=(n, 20))), labels)


def _friedman(random: np.random.Generator, n: int) -> Table:
    features, values = make_friedman1(n, 10, noise=3.0, random_state=int(random.integers(2**31)))
    return Table(features, (values > np.median(values)).astype(np.int64))


def _madelon(random: np.random.Generator, n: int) -> Table:
    seed = int(random.integers(2**31))
    features, labels = make_classification(
        n, 20, n_informative=5, n_redundant=5, n_clusters_per_class=8, flip_y=0.05, random_state=seed
    )
    return Table(features, labels.astype(np.int64))


def _chance(random: np.random.Generator, n: int) -> Table:
    return Table(random.normal(size=(n, 10)), random.integers(0, 2, n))


def _channels(random: np.random.Generator, n: int) -> Table:
    """Return 14 channels of some 500 values each, a common part and one of each channel, both autoregressive."""
    lengths = random.exponential(620, n // 20).astype(np.int64) + 20
    labels = np.repeat(np.arange(len(lengths)) % 2, lengths)[:n]
    common, own, features = 0.0, np.zeros(14), np.zeros((n, 14))
    for row in range(n):
        common = 0.97 * common + random.normal()
        own = 0.9 * own + random.normal(size=14)
        features[row] = own + 0.8 * common + 0.45 * labels[row] * np.linspace(-1, 1, 14)
    return Table(np.round(20 * features) / 20, labels)


FORMULAS: dict[str, tuple[int, Callable[[np.random.Generator, int], Table]]] = {
    "waveform": (5_000, _waveform),
    "waveform, two classes": (5_000, partial(_waveform, two_classes=True)),
    "twonorm": (7_400, _twonorm),
    "ringnorm": (7_400, _ringnorm),
    "Friedman's first": (4_000, _friedman),
    "as Madelon": (2_600, _madelon),
    "chance": (2_000, _chance),
    "drifting channels": (14_980, _channels),
}

summary = race_table
