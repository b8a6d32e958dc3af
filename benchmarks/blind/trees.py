"""Recovery by retraining: a tree for mu1 learns from the twin, from the augmented twin, and from the asset."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.blind.answers import Found, twin
from benchmarks.blind.assets.asset import TREE_STATES
from benchmarks.blind.sealing import TREE_LOAD, Key
from benchmarks.figure import Figure, share, statistic
from benchmarks.noises import VARIANCE
from femlib.arrays import FloatArray
from octmip.gap import CHAIN, Addition, AugmentedTwin
from octmip.gap.retrain import Lesson, Recovery, recovery, retrained, trained
from octmip.gap.twins.cached import CachedTwin
from octmip.trees.solution import Solution
from octmip.trees.tree import Node

REPEATS = 100
DEPTH = 3
SEEDS = (0, 1, 2)
ANSWERS_SEED = 100


def lesson(gauges: Sequence[str]) -> Lesson:
    """Return what the study's tree for mu1 learns: 25 states, 100 readings each at load factor 3, depth 3."""
    states = np.array(TREE_STATES)
    return Lesson(states, 100.0 * states[:, 0], tuple(gauges), TREE_LOAD, REPEATS, VARIANCE**0.5, DEPTH)


@dataclass(frozen=True)
class Retraining:
    """One case to retrain for.

    Attributes
    ----------
    found, answer
        its diagnosis and its opened key.
    refinement
        of the twin's mesh.
    """

    found: Found
    answer: Key
    refinement: float


def recovered(task: Retraining) -> Recovery:
    """Return the recovery of one case, scored on the asset's readings with the effect present in all states.

    Errors are means over several draws of the training's noise: one draw moves a tree of depth 3 by a tenth of a per
    cent, as much as what is left to recover.
    """
    plan = lesson(task.answer["gauges"])
    asset = np.array(task.answer["tree_means"])
    augmented = augmented_means(task, plan, twin(task.refinement))
    drawn = []
    for seed in SEEDS:
        after, oracle = (_tree(trained(plan, mean, seed=seed)) for mean in (augmented, asset))
        drawn.append(recovery(plan, asset, (deployed(task.refinement, plan.gauges, seed), after, oracle), ANSWERS_SEED))
    before, after, oracle, error = np.mean([(r.before, r.after, r.oracle, r.standard_error) for r in drawn], axis=0)
    return Recovery(float(before), float(after), float(oracle), float(error))


@cache
def deployed(refinement: float, gauges: tuple[str, ...], seed: int) -> Node:
    """Return the tree that the twin as it is teaches: the same for all cases."""
    return _tree(retrained(twin(refinement), lesson(gauges), seed=seed))


def _tree(solution: Solution) -> Node:
    assert solution.tree is not None
    return solution.tree


def augmented_means(task: Retraining, plan: Lesson, model: CachedTwin) -> FloatArray:
    """Return the augmented twin's readings (n_states, n_gauges) in the tree's states, at the end of the campaign."""
    parts = task.found["augmented"]
    effects = {**CHAIN, **model.effects}
    additions = tuple(Addition(effects[name], place, size) for name, place, size in parts["additions"])
    augmented = AugmentedTwin(model, additions, np.array(parts["calibration"]), parts["load"])
    order = [model.gauges.index(name) for name in plan.gauges]
    states = [dict(zip(model.parameters, state, strict=True)) for state in plan.states.tolist()]
    return np.array([augmented.predict(state, plan.load_factor, parts["end"])[order] for state in states])


def tree_figures(recoveries: Sequence[Recovery]) -> list[Figure]:
    """Return the figures of retraining."""
    clear = [r for r in recoveries if np.isfinite(r.recovered)]
    must = (0.90, np.inf)
    pooled = sum(r.before - r.after for r in clear) / sum(r.before - r.oracle for r in clear) if clear else np.nan
    bounds = _interval(clear) if clear else (np.nan, np.nan)
    return [
        statistic("tree MAE recovered against oracle, median", [r.recovered for r in clear], np.median, must),
        Figure("tree MAE recovered against oracle, all trees together", pooled, *bounds, len(clear), must),
        share("trees whom the gap costs more than noise", [bool(np.isfinite(r.recovered)) for r in recoveries]),
        statistic("tree MAE [% stiffness loss], trained on the twin", [r.before for r in clear]),
        statistic("tree MAE, trained on the augmented twin", [r.after for r in clear]),
        statistic("tree MAE, trained on the asset (oracle)", [r.oracle for r in clear]),
    ]


def _interval(clear: Sequence[Recovery]) -> tuple[float, float]:
    """Return the bootstrap interval of the pooled share."""
    rng = np.random.default_rng(0)
    gain, cost = np.array([r.before - r.after for r in clear]), np.array([r.before - r.oracle for r in clear])
    draws = rng.integers(len(clear), size=(1000, len(clear)))
    low, high = np.quantile(gain[draws].sum(axis=1) / cost[draws].sum(axis=1), [0.025, 0.975]).tolist()
    return low, high
