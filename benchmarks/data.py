"""The data that benchmarks and tests read from `../shared`, beside the repository; never copied into it."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from femlib.dataset import Recipe, build_dataset, published_strains

SHARED = Path(__file__).parents[2] / "shared"

# Left out of the numeric sets although every cell is a number: another file of the same samples, or no classification.
LEFT_OUT = {
    "ct-bank": "the same samples as banknote-authentication, rescaled",
    "breast-cancer-wisconsin-prognostic": "missing cells",
    "skin-segmentation": "a quarter of a million rows, a case by itself",
}


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """Samples with labels: features (n, p), labels (n,)."""

    features: NDArray[np.float64]
    labels: NDArray[np.int64]


@cache
def uci(name: str) -> Table:
    """Return a set of `../shared/uci`; every column but the last, the label, must be numbers without missing readings.

    Raises
    ------
    ValueError
        a column is not.
    """
    frame = pd.read_csv(SHARED / "uci" / f"{name}.csv", na_values=["?"])
    features = frame.iloc[:, :-1].to_numpy(dtype=np.float64)  # ValueError on text
    if not np.isfinite(features).all():
        raise ValueError(f"{name} has missing cells")
    return Table(features, np.unique(frame.iloc[:, -1].astype(str), return_inverse=True)[1])


def numeric_sets() -> tuple[list[str], dict[str, str]]:
    """Return the names of the numeric sets of `../shared/uci`, and why each other one is left out."""
    names, left_out = [], {}
    for path in sorted((SHARED / "uci").glob("*.csv")):
        try:
            uci(path.stem)
            reason = LEFT_OUT.get(path.stem)
        except ValueError as error:
            reason = "missing cells" if "missing" in str(error) else "columns of text"
        if reason is None:
            names.append(path.stem)
        else:
            left_out[path.stem] = reason
    return names, left_out


@cache
def synthetic_uav(target: str) -> Table:
    """Return the synthetic UAV set: 20 strains of 25 states; target A labels the first damage, B the second.

    x = base_s + g_s mu1 / (1 - .8 mu1) + h_s mu2 / (1 - .8 mu2) + N(0, 10.5), base_s ~ U(200, 900), g_s falling
    from 150 at sensor 1 to 0 at sensor 20, h_s a bell of height 40 about sensor 16, 8 sensors wide (one sigma);
    100 samples per state, 70 % kept.
    """
    rng = np.random.default_rng(0)
    sensor = np.arange(1, 21)
    base = rng.uniform(200, 900, 20)
    near = np.linspace(150, 0, 20)
    far = 40 * np.exp(-0.5 * ((sensor - 16) / 8.0) ** 2)
    level = np.repeat(np.arange(25), 100)
    states = np.column_stack([level // 5, level % 5])
    loss = states / 5.0
    effect = loss / (1 - 0.8 * loss)
    features = base + effect[:, :1] * near + effect[:, 1:] * far + rng.normal(0, 10.5, (len(level), 20))
    kept = np.sort(rng.permutation(len(level))[:1750])
    return Table(features[kept], states[kept, 0 if target == "A" else 1])


@cache
def published(target: str, seed: int) -> Table:
    """Return the training samples of the published strains (20 gauges, 1750 rows); target "mu1" or "mu2" [percent]."""
    data = build_dataset(published_strains(SHARED / "uav" / "strains.csv"), Recipe(), seed=seed)
    labels = data.mu1 if target == "mu1" else data.mu2
    return Table(data.features[data.is_train], labels[data.is_train])


def first_rows(table: Table, n: int) -> Table:
    """Return every (n_samples / n)-th row of a table: n rows, all classes in their shares."""
    rows = [i * len(table.labels) // n for i in range(n)]
    return Table(table.features[rows], table.labels[rows])
