"""Guards and baselines to compare a score with: shuffled keys, a classifier, a ranking without priors, a lasso.

Baselines say one name; by group means that the name's group, fixed before any data, holds the truth. The same rule is
applied to this diagnosis.
"""

import warnings
from collections.abc import Sequence

import numpy as np
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import StratifiedKFold, cross_val_predict

from benchmarks.blind.answers import Found
from benchmarks.blind.score import CLEAR, Pair, d_prime, names_of, top
from benchmarks.blind.sealing import Key
from benchmarks.figure import Figure, share, statistic

GROUPS = (
    {"modulus", "load_factor_error", "common_gain", "skin_thickness", "planform"},
    {"gauge_gain", "misalignment", "position_offset", "crosstalk"},
)
"""Names that cannot be told apart in one state by strain proportional to load."""
FEWEST = 5
"""Cases of a name from which a classifier can learn it."""


def guards(cases: Sequence[Pair]) -> list[Figure]:
    """Return the guards' figures for pairs of diagnosis and opened key."""
    single = [(f, a) for f, a in cases if a["case"]["stratum"].startswith("single")]
    clear = [(f, a) for f, a in single if d_prime(f, a) >= CLEAR]
    with_lasso = [(f, a) for f, a in clear if f["lasso"] is not None]
    first = [f["which"][0]["effects"] for f, _ in clear]
    rows = [
        share("this diagnosis, top-1 by its own groups", [top(f, a) for f, a in clear]),
        shuffled(clear),
        chance(clear),
        statistic("names in the first cause's groups", [sum(map(len, f["names"][0])) for f, _ in clear]),
    ]
    said: dict[str, list[tuple[Key, str | None]]] = {
        "this diagnosis": [
            (a, names[0] if len(names) == 1 else "") for names, (_, a) in zip(first, clear, strict=True)
        ],
        "chi-squared ranking": [(a, f["ranking"]) for f, a in clear],
        "group lasso": [(a, f["lasso"]) for f, a in with_lasso],
        "residual classifier, cross-validated": classified(clear),
    }
    for method, answers in said.items():
        rows.append(share(f"{method}, top-1 by fixed group", [_group(_name(a)) == _group(n) for a, n in answers]))
        rows.append(share(f"{method}, top-1 by name", [_name(a) == n for a, n in answers]))
    return rows


def shuffled(clear: Sequence[Pair]) -> Figure:
    """Return top-1 against the keys of other cases, dealt out at random: it must score what `chance` says."""
    order = np.random.default_rng(0).permutation(len(clear))
    hits = [top(clear[k][0], clear[order[j]][1]) for j, k in enumerate(np.roll(order, 1))]
    return share("shuffled keys, top-1 by the diagnosis' groups", hits)


def chance(clear: Sequence[Pair]) -> Figure:
    """Return what luck scores with groups of these names: how often the names of a group are drawn, over all cases."""
    drawn = [_name(a) for _, a in clear]
    hits = [drawn.count(name) / len(drawn) for f, _ in clear for name in _only_group(f)]
    value = float(np.sum(hits)) / max(1, len(clear))
    return Figure("chance of groups so wide", value, value, value, len(clear))


def _only_group(found: Found) -> list[str]:
    """Return the names of a first cause of one effect; a cause of more is never right about a single truth."""
    groups = found["names"][0]
    return groups[0] if len(groups) == 1 else []


def classified(cases: Sequence[Pair]) -> list[tuple[Key, str | None]]:
    """Return (answer, name) of a logistic regression on whitened residuals, for names with five cases or more."""
    names = [_name(a) for _, a in cases]
    kept = [k for k, name in enumerate(names) if names.count(name) >= FEWEST and cases[k][0]["residual"]]
    width = max((len(cases[k][0]["residual"]) for k in kept), default=0)
    kept = [k for k in kept if len(cases[k][0]["residual"]) == width]
    labels = np.array([names[k] for k in kept])
    if len(set(labels.tolist())) < 2:
        return []
    features = np.arcsinh(np.array([cases[k][0]["residual"] for k in kept]))
    folds = StratifiedKFold(FEWEST, shuffle=True, random_state=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of convergence: a baseline need not be at its very optimum
        told = cross_val_predict(LogisticRegression(max_iter=500), features, labels, cv=folds)
    return [(cases[k][1], str(name)) for k, name in zip(kept, told, strict=True)]


def _name(answer: Key) -> str:
    return names_of(answer)[0]


def _group(name: str | None) -> frozenset[str | None]:
    """Return the fixed group of a name: itself where it has no confounders."""
    return next((frozenset(group) for group in GROUPS if name in group), frozenset({name}))
