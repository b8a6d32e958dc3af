"""Which effect: the posterior over sets of columns, summed over what may be held together.

Every hypothesis is judged in the scene whose states are closest to those it prefers itself (see states.py); the
posterior is normalised over no effect, sets of one to three columns, and the unknown. Sets whose members imitate each
other beyond what these readings can tell apart (d' < 3) are one explanation, reported under the name of its most
probable member.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from octmip.gap.inference.evidence import Fit, Members, extensions, fit
from octmip.gap.inference.hypotheses import UNKNOWN_PRIOR, Hypothesis, candidates, log_prior
from octmip.gap.inference.linear_model import Scene, Setting, build_scene
from octmip.gap.inference.signature_error import allowing, judge
from octmip.gap.inference.states import NEAR, distance, log_box, moved_states, starting_states
from octmip.gap.inference.unknown import Unknown, weigh_unknown

Floats = NDArray[np.float64]

EXACT = 100
"""Hypotheses whose evidence is computed exactly and, with open states, in their own scene."""
WHOLE = 30
"""Best sets whose subsets are judged as well: an idle member must be able to leave."""
POLISHED = 8
"""Distinct hypotheses about whose own states the scene is linearised again."""


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A hypothesis with its posterior probability and where it was judged.

    Attributes:
        members: columns.
        has_unknown: whether the unknown acts beside them.
        probability: posterior probability.
        scene: the scene in which it was judged.
    """

    members: Members
    has_unknown: bool
    probability: float
    scene: Scene

    @property
    def fit(self) -> Fit:
        """The sizes."""
        return judge(self.scene, [self.members])[0].fit

    @property
    def allowed(self) -> Scene:
        """The scene under the errors of the hypothesis' own shapes."""
        return allowing(self.scene, self.members)


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """All hypotheses, most probable first.

    Attributes:
        judged: ordered hypotheses; probabilities sum to 1.
        unknown: the unknown's evidence in the main scene.
        scene: the main scene (of the most probable hypothesis).
    """

    judged: tuple[Judged, ...]
    unknown: Unknown
    scene: Scene

    @property
    def unknown_probability(self) -> float:
        """Probability that something outside the library acts."""
        return float(sum(h.probability for h in self.judged if h.has_unknown))

    def inclusion(self) -> dict[str, float]:
        """Return the probability of every effect to be among the causes."""
        columns = self.scene.setting.columns
        found = {column.name: 0.0 for column in columns}
        for h in self.judged:
            for name in {columns[j].name for j in h.members}:
                found[name] += h.probability
        return dict(sorted(found.items(), key=lambda item: -item[1]))


def fit_together(hypotheses: Sequence[Judged]) -> None:
    """Make the fits of hypotheses, which their scenes keep: one by one they cost several times as much."""
    for scene in {id(h.scene): h.scene for h in hypotheses}.values():
        judge(scene, [h.members for h in hypotheses if h.scene is scene])


def attribute(setting: Setting) -> Posterior:
    """Return the posterior over sets of effects."""
    scenes = [build_scene(setting, states) for states in starting_states(setting)]
    scenes = [
        scenes[0],
        *(s for s in scenes[1:] if s.log_none + _promise(s) > scenes[0].log_none + _promise(scenes[0]) - 20),
    ]
    found = {h.members: h for scene in scenes for h in candidates(scene)}
    ordered = sorted(found.values(), key=lambda h: -h.log_weight)
    if setting.groups:
        scenes = _polished(scenes, [h.members for h in ordered[: 4 * POLISHED]])
    return _normalised(scenes, found)


def _promise(scene: Scene) -> float:
    """Return the best single column's log evidence over none."""
    return float(max(0.0, extensions(scene, ()).max(initial=0.0)))


def _polished(scenes: list[Scene], members: list[Members]) -> list[Scene]:
    """Return scenes about the states that the best hypotheses prefer; two steps, the second from the first's scene."""
    kept: list[Scene] = []
    for chosen in members:
        if len(kept) == POLISHED:
            break
        for start in scenes[:2]:
            scene = start
            for _ in range(3):
                states = moved_states(scene, fit(scene, chosen))
                if distance(states, scene.states) < NEAR / 10:
                    break
                near = [s for s in kept if distance(states, s.states) < NEAR / 5]
                scene = near[0] if near else build_scene(scene.setting, states)
            if not any(distance(scene.states, s.states) < NEAR / 5 for s in kept):
                kept.append(scene)
    return kept


def _normalised(scenes: list[Scene], found: dict[Members, Hypothesis]) -> Posterior:
    ordered = sorted(found.values(), key=lambda h: -h.log_weight)
    exact = _with_parts([h.members for h in ordered[:EXACT]])
    judged: list[tuple[Hypothesis, float, Scene]] = []
    for scene in scenes:  # all at once: one by one costs ten times as much
        judge(scene, exact)
    for members in exact:
        value, nearest = _exact(scenes, members)
        judged.append((Hypothesis(members, False, value), value, nearest))
    if len(scenes) == 1:
        done = set(exact)
        others = [h for h in ordered if h.members not in done]
        judged += [(h, h.log_weight + scenes[0].log_none, scenes[0]) for h in others]
    best = max(judged, key=lambda item: item[1])[2]
    strange = weigh_unknown(best)
    judged += _with_unknown(best, strange)
    total = float(logsumexp([value for _, value, _ in judged]))
    result = [Judged(h.members, h.has_unknown, float(np.exp(v - total)), s) for h, v, s in judged]
    return Posterior(tuple(sorted(result, key=lambda h: -h.probability)), strange, best)


def _with_parts(sets: list[Members]) -> list[Members]:
    """Return the sets, and what is left of the first `WHOLE` of them when members are taken out: never unjudged."""
    parts = {part for members in sets[:WHOLE] for k in range(len(members)) for part in combinations(members, k)}
    return [*sets, *sorted(parts - set(sets))]


def _exact(scenes: list[Scene], members: Members) -> tuple[float, Scene]:
    """Return prior times evidence of a hypothesis in the scene nearest to its own states."""
    tried = []
    for scene in scenes:
        shaped = judge(scene, [members])[0]
        own = shaped.fit
        away = distance(moved_states(scene, own), scene.states) if scene.setting.groups else 0.0
        value = scene.log_none + shaped.log_factor + log_box(scene, own) + log_prior(scene, members)
        tried.append((away, value, scene))
    near = [t for t in tried if t[0] < NEAR / 2] or [min(tried, key=lambda t: t[0])]
    _, value, scene = max(near, key=lambda t: t[1])
    return value, scene


def _with_unknown(scene: Scene, strange: Unknown) -> list[tuple[Hypothesis, float, Scene]]:
    """Return the unknown alone and beside every single effect."""
    box = log_box(scene, fit(scene, ()))
    alone = scene.log_none + strange.log_factor + box + float(np.log(UNKNOWN_PRIOR[0]))
    found = [(Hypothesis((), True, alone), alone, strange.conditioned)]
    logs = extensions(strange.conditioned, ())
    names = scene.setting.priors.n_effects
    for j, column in enumerate(scene.setting.columns):
        prior = np.log(UNKNOWN_PRIOR[1]) - np.log(names) + np.log(column.weight)
        value = strange.conditioned.log_none + float(logs[j]) + box + float(prior)
        found.append((Hypothesis((j,), True, value), value, strange.conditioned))
    return found
