"""What these readings cannot tell apart.

Two columns a and b are d' apart when the best b leaves of a's contribution, in standard deviations of the mean
readings,

    d'^2 = size_a^2 (G_aa - G_ab^2 / G_bb)      (b's size free, of the right sign and not absurd),
    d'^2 = |size_a a - b|^2                     (b a fact of size 1),

with G the Gram matrix after whatever else is open (damage tangents, calibration, the other members of the set) has been
projected out. Below 3 no test on these readings separates them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.inference.evidence import Fit, Members
from octmip.gap.inference.linear_model import Scene

Floats = NDArray[np.float64]

SEPARABLE = 3.0
"""d' below which two effects are one group."""
ABSURD = 9.0
"""Sizes beyond this many prior sd are no explanation (three times the widest of the scale mixture)."""
IMPOSSIBLE = 30.0
"""The same limit where the traces are one: a gain of 20 % is told beside a modulus, -100 % not beside a dead gauge."""
EXACT = 0.5
"""d' below which two traces are one."""
POWER = 3.3 + 1.645
"""d' that a size needs to be seen with 95 % power past a threshold corrected for some hundred places."""


@dataclass(frozen=True, slots=True)
class Rival:
    """A column that imitates another one.

    Attributes:
        column: the rival.
        d_prime: what it leaves, in standard deviations.
        size: the size that it would need, in its unit.
    """

    column: int
    d_prime: float
    size: float


def rivals(scene: Scene, own: Fit, member: int) -> list[Rival]:
    """Return the best rival of every other effect with d' below `SEPARABLE` from a fitted member, closest first."""
    columns = scene.setting.columns
    place = own.members.index(member)
    size = float(own.size[place])
    gram = conditional_gram(scene, tuple(j for j in own.members if j != member), member)
    d_prime, needed = _distances(scene, gram, member, size)
    best: dict[str, Rival] = {}
    for j in np.argsort(d_prime, kind="stable").tolist():
        name = columns[j].name
        if d_prime[j] < SEPARABLE and name != columns[member].name and name not in best:
            best[name] = Rival(j, float(d_prime[j]), float(needed[j]))
    return list(best.values())


def tied_columns(scene: Scene, own: Fit, member: int) -> set[int]:
    """Return all columns, other places of the same effect included, with d' below `SEPARABLE` from a fitted member."""
    size = float(own.size[own.members.index(member)])
    gram = conditional_gram(scene, tuple(j for j in own.members if j != member), member)
    d_prime, _ = _distances(scene, gram, member, size)
    return {int(j) for j in np.flatnonzero(d_prime < SEPARABLE)}


def visibility(scene: Scene, own: Fit, member: int) -> float:
    """Return d' of a fitted member from its own absence."""
    size = float(own.size[own.members.index(member)])
    _, diagonal = conditional_gram(scene, tuple(j for j in own.members if j != member), member)
    return abs(size) * float(np.sqrt(diagonal[member]))


def conditional_gram(scene: Scene, others: Members, member: int) -> tuple[Floats, Floats]:
    """Return (G_aj, G_jj) (n_columns,) each, the free columns `others` projected out."""
    cross, diagonal = scene.products([member])[0], scene.lengths.copy()
    if others:
        index = list(others)
        sd = scene.setting.priors.sd[index]
        with_others = scene.products(index)
        inverse = np.linalg.inv(with_others[:, index] + np.diag((3.0 * sd) ** -2))
        cross -= with_others.T @ inverse @ with_others[:, member]
        diagonal -= np.einsum("ij,ik,kj->j", with_others, inverse, with_others)
    return cross, np.maximum(diagonal, 0.0)


def _distances(scene: Scene, gram: tuple[Floats, Floats], member: int, size: float) -> tuple[Floats, Floats]:
    cross, diagonal = gram
    prior = scene.setting.priors
    fact, mean, sd, one_sided = prior.is_fact, prior.mean, prior.sd, prior.one_sided
    safe = np.maximum(diagonal, 1e-300)
    needed = np.where(fact, mean, size * cross / safe)
    needed = np.where(one_sided, np.maximum(needed, 0.0), needed)
    same_trace = size**2 * (diagonal[member] - cross**2 / safe) < EXACT**2
    limit = np.where(fact, np.abs(mean), np.where(same_trace, IMPOSSIBLE, ABSURD) * sd)
    needed = np.clip(needed, -limit, limit)
    squared = size**2 * diagonal[member] - 2 * size * needed * cross + needed**2 * diagonal
    return np.sqrt(np.maximum(squared, 0.0)), needed


def detectable(scene: Scene) -> dict[str, float]:
    """Return for every effect the size that these readings would have shown with 95 % power, at a typical place."""
    sizes: dict[str, list[float]] = {}
    for column, length in zip(scene.setting.columns, np.sqrt(scene.lengths), strict=True):
        sizes.setdefault(column.name, []).append(POWER / max(float(length), 1e-12))
    return {name: float(np.median(found)) for name, found in sizes.items()}


def separations(scene: Scene, names: tuple[str, ...]) -> Floats:
    """Return (n_names, n_names) the least d' between effects, each at its prior sd, before any reading is looked at.

    Entry (a, b) is the median over a's places of the distance to b's best place.
    """
    columns = scene.setting.columns
    table = np.full((len(names), len(names)), np.inf)
    for i, name in enumerate(names):
        rows = [j for j, c in enumerate(columns) if c.name == name]
        distances = []
        for j in rows:
            gram = conditional_gram(scene, (), j)
            size = columns[j].effect.prior_mean or columns[j].effect.prior_sd
            distances.append(_distances(scene, gram, j, size)[0])
        for k, other in enumerate(names):
            there = [j for j, c in enumerate(columns) if c.name == other]
            if rows and there and other != name:
                table[i, k] = float(np.median([d[there].min() for d in distances]))
    return table
