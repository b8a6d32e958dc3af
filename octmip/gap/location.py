"""Where the gap lies: entries, gauges, loads, tests; and which nodes of a deployed tree it flips.

Residuals are readings less the (calibrated) twin, in standard deviations of noise and of what two good models differ
by. Entries are significant under the false-discovery rate of 5 %: Benjamini and Hochberg (1995), J. R. Statist. Soc.
B 57; a gauge, a load or a test under a chi-squared test of all its entries with their full covariance, Bonferroni
over the groups.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from octmip.gap.inference.linear_model import Scene

Floats = NDArray[np.float64]

RATE = 0.05
"""False-discovery rate of entries, and familywise error of groups."""


@dataclass(frozen=True, slots=True)
class Place:
    """One gauge, load, test or single entry.

    Attributes:
        name: in words.
        z: standardised residual (an entry), or sqrt(chi2 / entries) (a group).
        p_value: of no gap.
        is_significant: after correction.
        share: part of the whole squared gap, noise taken off.
        gap_microstrain: mean residual.
    """

    name: str
    z: float
    p_value: float
    is_significant: bool
    share: float
    gap_microstrain: float


@dataclass(frozen=True, slots=True, eq=False)
class Where:
    """The gap by place.

    Attributes:
        entries: one for each averaged reading, most significant first.
        gauges, loads, tests: groups, greatest share first.
        nodes: nodes of the deployed tree, greatest share of flipped decisions first; empty without a tree.
        rms_microstrain: root mean square gap, noise taken off.
        p_value: of the whole: chi-squared of all entries.
    """

    entries: tuple[Place, ...]
    gauges: tuple[Place, ...]
    loads: tuple[Place, ...]
    tests: tuple[Place, ...]
    nodes: tuple["Flip", ...]
    rms_microstrain: float
    p_value: float


@dataclass(frozen=True, slots=True)
class Flip:
    """A node of a tree at which twin and asset part.

    Attributes:
        path: the way to the node, "L" and "R" from the root, "" for the root.
        words: its split in words.
        simulated, real: share of readings that pass left, twin and asset.
        share: part of all real readings that reach the node and go the other way than the twin's would.
    """

    path: str
    words: str
    simulated: float
    real: float
    share: float


def localise(scene: Scene, nodes: tuple[Flip, ...] = ()) -> Where:
    """Return where readings and twin differ in a scene, the halves of a test's readings taken together."""
    setting = scene.setting
    cell, gauge, mix = _entries(scene)
    residual, covariance = mix @ scene.residual, mix @ scene.covariance @ mix.T
    z = residual / np.sqrt(np.diag(covariance))
    excess = residual**2 - mix**2 @ noise_variance(scene)
    total = max(float(excess.sum()), 1e-12)
    p = 2.0 * norm.sf(np.abs(z))
    significant = discoveries(p)
    cells = [setting.campaign.cells[c] for c in cell]
    gauge_names = [setting.campaign.gauges[g] for g in gauge]
    entries = [
        Place(
            f"{gauge_names[k]}, {cells[k].name}",
            float(z[k]),
            float(p[k]),
            bool(significant[k]),
            float(excess[k]) / total,
            float(residual[k]),
        )
        for k in np.argsort(p, kind="stable")
    ]
    whole = float(chi2.sf(float(scene.white_residual @ scene.white_residual), scene.n))

    def groups(names: Sequence[str]) -> tuple[Place, ...]:
        return _groups(residual, covariance, np.array(names), excess / total)

    loads = groups([f"load factor {c.load_factor:g}" for c in cells])
    rms = float(np.sqrt(max(0.0, float(excess.mean()))))
    return Where(tuple(entries), groups(gauge_names), loads, groups([c.test for c in cells]), nodes, rms, whole)


def _entries(scene: Scene) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Return cell and gauge (n_entries,) of every mean reading, and the weights (n_entries, n) of its blocks."""
    blocks = scene.setting.blocks
    cell = np.array([b.cell for b in blocks])[scene.block]
    count = np.array([b.count for b in blocks])[scene.block, scene.gauge]
    places, entry = np.unique(np.stack([cell, scene.gauge]), axis=1, return_inverse=True)
    mix = np.zeros((places.shape[1], scene.n))
    mix[entry.ravel(), np.arange(scene.n)] = count
    return places[0], places[1], mix / mix.sum(axis=1, keepdims=True)


def noise_variance(scene: Scene) -> Floats:
    """Return the variance (n,) that noise alone gives each averaged reading [microstrain^2]."""
    setting = scene.setting
    loads = [setting.cell_of(b).load_factor for b in setting.blocks]
    of_block = [np.diag(setting.noise.of_mean(b.count, load)) for b, load in zip(setting.blocks, loads, strict=True)]
    return np.array(of_block)[scene.block, scene.gauge]


def discoveries(p: Floats, rate: float = RATE) -> NDArray[np.bool_]:
    """Return which p-values (n,) are significant by the step-up rule of Benjamini and Hochberg."""
    order = np.argsort(p, kind="stable")
    passed = np.flatnonzero(p[order] <= rate * np.arange(1, len(p) + 1) / len(p))
    found = np.zeros(len(p), dtype=bool)
    if passed.size:
        found[order[: passed[-1] + 1]] = True
    return found


def _groups(residual: Floats, covariance: Floats, names: NDArray[np.str_], share: Floats) -> tuple[Place, ...]:
    distinct = list(dict.fromkeys(names.tolist()))
    places = []
    for name in distinct:
        rows = np.flatnonzero(names == name)
        squared = float(residual[rows] @ np.linalg.solve(covariance[np.ix_(rows, rows)], residual[rows]))
        p = float(chi2.sf(squared, len(rows)))
        significant = p < RATE / len(distinct)
        z = float(np.sqrt(squared / len(rows)))
        places.append(Place(name, z, p, significant, float(share[rows].sum()), float(residual[rows].mean())))
    key: Callable[[Place], float] = lambda place: -place.share  # noqa: E731
    return tuple(sorted(places, key=key))
