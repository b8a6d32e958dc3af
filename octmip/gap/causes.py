"""Causes: the posterior told so that nobody is misled by effects that these readings cannot tell apart.

Members of a set that do not stand clear of the noise (d' < 3) are taken out of it. The most probable hypothesis then
gives a cause its name. Hypotheses of the same number of effects whose members are, one
by one, less than d' = 3 from its members are the same cause seen from elsewhere: their probabilities add up, and
their names are told beside it. Then the most probable hypothesis that is left gives the next cause.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from octmip.gap.inference.candidates import SCALES
from octmip.gap.inference.confounding import SEPARABLE, Rival, rivals, tied_columns, visibility
from octmip.gap.inference.evidence import Fit, Members
from octmip.gap.inference.posterior import Judged, Posterior, fit_together
from octmip.gap.inference.signature_error import clearness, neighbours
from octmip.gap.shrinkage import Shrinkage, chance_of_rest
from octmip.gap.sizes import Parameter, parameters

UNKNOWN = "unknown"
"""Name of the cause that no effect of the library describes."""
CREDIBLE = 0.95
"""Probability that the causes which are told hold together."""
MOST_CAUSES = 12
MISFIT = 1e-3
"""Chance of the remaining chi-squared below which the best cause does not explain the readings."""
EXPLAINED = 0.8
"""Share of the held-out gap beyond which a cause stands although something smaller remains."""
IDLE = 1e-4
"""Probability below which a hypothesis is not searched for idle members."""
TOLD = 3
"""Rivals whose separation is told."""


@dataclass(frozen=True, slots=True)
class Tie:
    """Effects that these readings cannot tell apart.

    Attributes:
        effects: names, the one that is reported first.
        places: their places.
        d_prime: how far the rivals are, in standard deviations.
        reason: why, and what would separate them.
    """

    effects: tuple[str, ...]
    places: tuple[str, ...]
    d_prime: tuple[float, ...]
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """One explanation of the gap.

    Attributes:
        effects: names, each once (two places of one effect are two parameters); empty when no effect is needed,
            ("unknown",) when the library does not hold it.
        ("unknown",) when the library does not hold it. probability: of this explanation, ties included. parameters:
        sizes of its effects. ties: for every effect that has rivals. is_clear: whether every effect of it stands d' =
        3 clear of the noise; else its name means little. is_prior_sensitive: whether another cause would lead with
        all priors three times narrower or wider. judged: the hypothesis that gives it its name.
    """

    effects: tuple[str, ...]
    probability: float
    parameters: tuple[Parameter, ...]
    ties: tuple[Tie, ...]
    is_clear: bool
    is_prior_sensitive: bool
    judged: Judged

    @property
    def names(self) -> tuple[frozenset[str], ...]:
        """For every effect the names that cannot be told from it, its own included."""
        tied = {tie.effects[0]: frozenset(tie.effects) for tie in self.ties}
        return tuple(tied.get(name, frozenset({name})) for name in self.effects)


def tell_causes(posterior: Posterior) -> tuple[Cause, ...]:
    """Return the explanations, most probable first, down to `CREDIBLE` together (at least three if there are)."""
    left = cleared(posterior.judged)
    found: list[Cause] = []
    told = 0.0
    while left and len(found) < MOST_CAUSES and (told < CREDIBLE or len(found) < 3):
        head = left[0]
        own = head.fit
        parts = [] if head.has_unknown else _parts(head)
        same = [h for h in left if h is head or _is_same(head, parts, h)]
        cause = _cause(head, own, same)
        found.append(cause)
        told += cause.probability
        taken = {id(h) for h in same}
        left = [h for h in left if id(h) not in taken]
    found.sort(key=lambda cause: -cause.probability)
    if found and _is_sensitive(posterior):
        first = found[0]
        found[0] = replace(first, is_prior_sensitive=True)
    return tuple(found)


def cleared(judged: Sequence[Judged]) -> list[Judged]:
    """Return the hypotheses with every member that does not stand clear of the noise taken out.

    A set with an idle member explains what the set without it explains: its probability goes there. Hypotheses that
    hold less than `IDLE` are left as they are.
    """
    exact = {h.members: h for h in judged if not h.has_unknown}
    fit_together([h for h in judged if not h.has_unknown and h.members and h.probability > IDLE])
    added: dict[tuple[int, ...], float] = {}
    kept = []
    for h in judged:
        target = h.members
        if not h.has_unknown and h.members and h.probability > IDLE:
            target = clear_members(h)
        if target != h.members and target in exact:
            added[target] = added.get(target, 0.0) + h.probability
        else:
            kept.append(h)
    kept = [h if h.has_unknown else replace(h, probability=h.probability + added.get(h.members, 0.0)) for h in kept]
    return sorted(kept, key=lambda h: -h.probability)


def clear_members(judged: Judged) -> Members:
    """Return the members of a hypothesis that stand d' = 3 clear of the noise, the faintest taken out one at a time."""
    scene, members = judged.scene, judged.members
    if members in scene.clear:
        return scene.clear[members]
    while members:
        clear = clearness(scene, members)
        faintest = int(np.argmin(clear))
        if clear[faintest] >= SEPARABLE:
            break
        members = (*members[:faintest], *members[faintest + 1 :])
    scene.clear[judged.members] = members
    return members


def with_misfit(
    found: tuple[Cause, ...], best: Cause | None, closing: Shrinkage | None, unknown_probability: float
) -> tuple[tuple[Cause, ...], float]:
    """Return the causes and the unknown's probability once the best cause has had to fit in absolute terms.

    Evidence only compares: the best of a library that lacks the truth is still the best. Where the chance of what the
    best cause leaves is below `MISFIT` and it does not close most of the gap on held-out readings, all causes of the
    library lose in proportion to that chance, and the unknown gains what they lose.
    """
    if best is None:
        return found, unknown_probability
    chance = closing.p_after if closing is not None else chance_of_rest(best.judged.scene, best.judged.fit)
    if chance >= MISFIT or (closing is not None and closing.closed > EXPLAINED):
        return found, unknown_probability
    kept = chance / MISFIT
    strange = 1.0 - (1.0 - unknown_probability) * kept
    others = tuple(replace(c, probability=c.probability * kept) for c in found if UNKNOWN not in c.effects)
    return (Cause((UNKNOWN,), strange, (), (), True, False, best.judged), *others), strange


def credible_set(found: Sequence[Cause]) -> tuple[Cause, ...]:
    """Return the fewest causes that hold `CREDIBLE` of the probability."""
    kept: list[Cause] = []
    for cause in found:
        kept.append(cause)
        if sum(c.probability for c in kept) >= CREDIBLE:
            break
    return tuple(kept)


def _parts(head: Judged) -> list[set[int]]:
    """Return for every effect of a hypothesis the columns that are the same cause.

    Those are tied to it (d' < 3), or, where the effect lies between places, next to it: two such places are one.
    """
    columns = head.scene.setting.columns
    found: dict[object, set[int]] = {}
    for j in head.members:
        key = columns[j].name if columns[j].n_between else j
        near = {j, *neighbours(head.scene, j)} if columns[j].n_between else {j}
        found[key] = found.get(key, set()) | near | tied_columns(head.allowed, head.fit, j)
    return list(found.values())


def _is_same(head: Judged, parts: Sequence[set[int]], other: Judged) -> bool:
    if head.has_unknown or other.has_unknown:  # whatever acts beside it, the library does not hold the cause
        return head.has_unknown and other.has_unknown
    if not parts or not other.members:
        return False
    columns = head.scene.setting.columns
    grouped: dict[object, set[int]] = {}
    for j in other.members:
        grouped.setdefault(columns[j].name if columns[j].n_between else j, set()).add(j)
    if len(grouped) != len(parts):
        return False
    return any(all(g <= p for g, p in zip(order, parts, strict=True)) for order in permutations(grouped.values()))


def _cause(head: Judged, own: Fit, same: Sequence[Judged]) -> Cause:
    columns = head.scene.setting.columns
    effects = tuple(dict.fromkeys(columns[j].name for j in head.members))
    probability = float(sum(h.probability for h in same))
    seen = [j for j in head.members if visibility(head.allowed, own, j) >= SEPARABLE]
    clear = len(seen) == len(head.members)
    if head.has_unknown and (not clear or head.probability < 0.5 * probability):  # nothing beside it stands out
        return Cause((UNKNOWN,), probability, (), (), True, False, head)
    ties = tuple(tie for j in seen if (tie := _tie(head, j, rivals(head.allowed, own, j))))
    named = (*effects, UNKNOWN) if head.has_unknown else effects
    return Cause(named, probability, parameters(head, same), ties, clear, False, head)


def _tie(head: Judged, member: int, found: Sequence[Rival]) -> Tie | None:
    if not found:
        return None
    columns = head.scene.setting.columns
    members = [member, *(r.column for r in found)]
    separations = "; ".join(f"{columns[j].name}: {columns[j].effect.separated_by}" for j in members[:TOLD])
    exact = all(r.d_prime < 0.5 for r in found)
    reason = (
        f"{'they change these readings in the same way' if exact else 'their traces in these readings are too alike'}"
        f" (d' {', '.join(f'{r.d_prime:.1f}' for r in found)}, 3 is needed). {separations}"
    )
    return Tie(
        tuple(columns[j].name for j in members),
        tuple(columns[j].variant for j in members),
        (0.0, *(r.d_prime for r in found)),
        reason,
    )


def _is_sensitive(posterior: Posterior) -> bool:
    """Return whether the winner changes when every prior sd is a third or three times what it is."""
    best = posterior.judged[:12]
    if best[0].has_unknown:
        return False
    head = best[0]
    named = {h.members: clear_members(h) for h in best if not h.has_unknown}
    parts = _parts(head)
    shares = [(h, h.fit.scales if h.members else (1.0,) * 3) for h in best if not h.has_unknown]
    for k in range(len(SCALES)):
        winner = max(shares, key=lambda item: item[0].probability * item[1][k])[0]
        same = named[winner.members] == named[head.members] or _is_same(head, parts, winner)
        if not same:
            return True
    return False
