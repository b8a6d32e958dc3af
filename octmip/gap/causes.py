"""Causes: the posterior over sets of effects, grouped by what these readings cannot tell apart.

Members of a set that are not identifiable (d' < 3 from their own absence) are removed from it. The most probable
hypothesis then gives a cause its name. Hypotheses of the same number of effects whose members are, one by one, less
than d' = 3 from its members are the same cause under other names: their probabilities add up, and their names are
reported beside it. Then the most probable hypothesis that is left gives the next cause.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import permutations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from octmip.gap.campaign.noise import moves_together
from octmip.gap.effects.words import words_at
from octmip.gap.inference.candidates import Candidate
from octmip.gap.inference.confounding import EXACT, SEPARABLE, VISIBLE, distances_from
from octmip.gap.inference.evidence import Members
from octmip.gap.inference.inference import Judged, neighbours
from octmip.gap.inference.posterior import fit_together
from octmip.gap.shrinkage import Shrinkage, chance_of_rest
from octmip.gap.sizes import Parameter, parameters
from octmip.input.messages import InWords
from octmip.input.names import shown

Floats = NDArray[np.float64]

UNKNOWN = "unknown"
"""Name of the cause that no effect of the library describes."""
CREDIBLE = 0.95
"""Probability that the reported causes hold together."""
MOST_CAUSES = 12
MANY, MIMICRY = 3, 0.3
"""Effects of a set that may be one thing outside the library; share of such things that a set of so many imitates.

Of 27 of pump, furnace and transformer eight were imitated so, of 216 machines with no, one or two faults two."""
MISFIT = 1e-3
"""Chance of the remaining chi-squared below which the best cause does not explain the readings."""
EXPLAINED = 0.8
"""Share of the held-out gap up to which a misfit counts in full; it counts the less, the more of the gap closes."""
CLOSES_WITHIN, COURSE, PER_D_PRIME = 0.04, 4.0, 1.5
"""Standard deviation of the share of a held-out gap that a right cause closes, about 1.

At least; over the square of its signature's error where the course over the load is a model's; of noise, for a gap that
stands d' = 1 above it."""
CLEAR = 5.0
"""d' of an effect from which its name is clear; below it a set of causes is said, not a name."""
ENOUGH = 0.8
"""Probability from which a clear cause is acted on."""
DIGITS = 3
"""Of d' by which effects that look the same are ordered; those that are one are in the library's order."""
IDLE = 1e-4
"""Probability below which a hypothesis is not searched for members that are not identifiable."""
MOST_SEPARATIONS = 3
"""Effects of one group for which a reason says what would separate them."""


class Certainty(StrEnum):
    """How far one may act on a cause."""

    CLEAR = "clear"
    PROBABLE = "probable"
    OPEN = "cannot be told"


@dataclass(frozen=True, slots=True)
class ConfoundedEffects:
    """Effects that these readings cannot tell apart.

    Attributes
    ----------
    effects
        names, the one that is reported first.
    places
        where each acts.
    d_prime
        how far the confounders are, in standard deviations.
    shares
        of the cause's probability, those of its sets that hold each effect.
    words
        what an engineer calls each at its place.
    reason
        why.
    separated_by
        for the first few, the observation that would separate it from the others.
    """

    effects: tuple[str, ...]
    places: tuple[str, ...]
    d_prime: tuple[float, ...]
    shares: tuple[float, ...]
    words: tuple[str, ...]
    reason: str
    separated_by: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Cause(InWords):
    """One explanation of the gap.

    Attributes
    ----------
    effects
        names, each once (two places of one effect are two parameters); empty when no effect is needed, ("unknown",)
        when the library does not hold the cause.
    probability
        of this explanation, confounded ones included.
    parameters
        sizes of its effects.
    confounded
        for every effect that has confounders.
    d_prime
        how far each of `parameters` stands above its own absence, in standard deviations.
    is_identifiable
        whether every effect stands d' = 3 above the noise; else its name means little.
    judged
        the hypothesis that names the cause.
    """

    effects: tuple[str, ...]
    probability: float
    parameters: tuple[Parameter, ...]
    confounded: tuple[ConfoundedEffects, ...]
    is_identifiable: bool
    judged: Judged
    d_prime: tuple[float, ...] = ()

    def __repr__(self) -> str:
        """Return the probability, and each effect with its size and 90 % interval."""
        sizes = [f"{one.effect}{one.place and ' ' + shown(one.place)} {one.interval}" for one in self.parameters]
        return f"Cause({self.probability:.3f}: {', '.join(sizes or self.effects) or 'nothing acts'})"

    @property
    def certainty(self) -> Certainty:
        """How far one may act on it."""
        clear = min(self.d_prime, default=np.inf) >= CLEAR
        if UNKNOWN not in self.effects and not clear:
            return Certainty.PROBABLE if self.probability >= CREDIBLE else Certainty.OPEN
        if self.probability >= CREDIBLE:
            return Certainty.CLEAR
        return Certainty.PROBABLE if self.probability >= ENOUGH else Certainty.OPEN

    @property
    def names(self) -> tuple[frozenset[str], ...]:
        """For every effect the names that cannot be told from it, its own included."""
        alike = {found.effects[0]: frozenset(found.effects) for found in self.confounded}
        return tuple(alike.get(name, frozenset({name})) for name in self.effects)


def causes_of(judged: Sequence[Judged]) -> tuple[Cause, ...]:
    """Return the explanations, most probable first, down to `CREDIBLE` together (at least three if there are).

    The hypotheses are those of `with_identifiable`.
    """
    left = list(judged)
    found: list[Cause] = []
    covered = 0.0
    while left and len(found) < MOST_CAUSES and (covered < CREDIBLE or len(found) < 3):
        head = left[0]
        parts = [] if head.has_unknown else _parts(head)
        same = [h for h in left if h is head or _is_same(head, parts, h)]
        found.append(_cause(head, same))
        covered += found[-1].probability
        taken = {id(h) for h in same}
        left = [h for h in left if id(h) not in taken]
    return tuple(sorted(found, key=lambda cause: -cause.probability))


def with_identifiable(judged: Sequence[Judged]) -> list[Judged]:
    """Return the hypotheses with every member that is not identifiable taken out.

    A set with an idle member explains what the set without it explains: its probability goes there. Hypotheses that
    hold less than `IDLE` are left as they are.
    """
    exact = {h.members for h in judged if not h.has_unknown}
    searched = [h for h in judged if not h.has_unknown and h.members and h.probability > IDLE]
    fit_together([h for h in searched if not h.inference.is_idle(h.members)])
    targets = {id(h): h.inference.identifiable(h.members) for h in searched}
    added: dict[Members, float] = {}
    kept = []
    for h in judged:
        target = targets.get(id(h), h.members)
        if target != h.members and target in exact:
            added[target] = added.get(target, 0.0) + h.probability
        else:
            kept.append(h)
    gained = [0.0 if h.has_unknown else added.get(h.members, 0.0) for h in kept]
    kept = [replace(h, probability=h.probability + more) if more else h for h, more in zip(kept, gained, strict=True)]
    return sorted(kept, key=lambda h: -h.probability)


def with_imitations(judged: Sequence[Judged]) -> list[Judged]:
    """Return the hypotheses, with what sets of `MANY` effects hold shared with the unknown.

    Three faults at once are rarer than one thing that no name describes and that three sizes together imitate: it does
    so with the probability `MIMICRY`. A swapped pair and a dead gauge have no size that could be fitted.
    """
    unknown = next((h for h in judged if h.has_unknown and not h.members), None)
    many = [h for h in judged if not h.has_unknown and len(_sized(h)) >= MANY]
    if unknown is None or not many:
        return list(judged)
    odds = unknown.model.inputs.odds
    outside = odds.unknown[0] * MIMICRY
    share = outside / (outside + odds.count[MANY])
    new = {id(h): (1.0 - share) * h.probability for h in many}
    new[id(unknown)] = unknown.probability + share * sum(h.probability for h in many)
    return sorted((replace(h, probability=new.get(id(h), h.probability)) for h in judged), key=lambda h: -h.probability)


def _sized(judged: Judged) -> set[tuple[str, str]]:
    """Return the effects with a size that is fitted, each at its place: once in all tests, once between two places."""
    chosen = [judged.model.inputs.candidates[j] for j in judged.members]
    return {(one.name, "" if one.n_between else one.place) for one in chosen if not one.is_discrete}


def with_misfit(
    found: tuple[Cause, ...], best: Cause | None, closing: Shrinkage | None, unknown_probability: float
) -> tuple[tuple[Cause, ...], float]:
    """Return the causes and the unknown's probability once the best cause has had to fit in absolute terms.

    Evidence only compares: the best of a library that lacks the truth is still the best. Where the chance of what the
    best cause leaves is below `MISFIT`, all causes of the library lose in proportion to that chance, and the unknown
    gains what they lose; the less so, the more of the gap on held-out readings the best cause closes. Likewise where
    it closes too little of that gap (`_closes`), and where what gauges share wanders: the noise then takes what no
    effect explains.
    """
    if best is None:
        return found, unknown_probability
    chance = closing.p_after if closing is not None else chance_of_rest(best.judged.model, best.judged.fit)
    closed = closing.closed if closing is not None and np.isfinite(closing.closed) else 0.0
    kept = min(1.0, chance / MISFIT) ** float(np.clip((1.0 - closed) / (1.0 - EXPLAINED), 0.0, 1.0))
    left = [_left_by(best.judged.model.inputs.candidates[j]) for j in best.judged.members]
    kept *= _closes(closing, best.judged.model.n, max(left, default=0.0))
    inputs = best.judged.model.inputs
    kept *= 1.0 - moves_together(inputs.noise, inputs.averages)
    unknown = 1.0 - (1.0 - unknown_probability) * kept
    if kept == 1.0:
        return found, unknown_probability
    known = [replace(c, probability=c.probability * kept) for c in found if UNKNOWN not in c.effects]
    beside = [c for c in found if UNKNOWN in c.effects and kept > 0.5 and c.probability > 0.5 * unknown_probability]
    plain = Cause((UNKNOWN,), unknown, (), (), True, best.judged)
    outside = replace(beside[0], probability=unknown) if beside else plain
    return tuple(sorted([*known, outside], key=lambda cause: -cause.probability)), unknown


def _left_by(candidate: Candidate) -> float:
    """Return the share of a gap that a right cause may leave open: the square of the error of its signature.

    More where its course over the load is a model's as well, and not that of a linear structure.
    """
    known = candidate.effect.load_power in (0, 1)
    return (1.0 if known else COURSE) * candidate.signature_error**2


def _closes(closing: Shrinkage | None, n: int, left: float = 0.0) -> float:
    """Return how much less probable a cause is that closes too little of the gap on held-out readings, at most 1.

    A right cause closes all of it but for noise and the share `left` that its signature may leave, another one any
    share between none and all. What twin and asset differ by is known to a factor: it blurs both.
    """
    if closing is None or not np.isfinite(closing.closed):
        return 1.0
    d_prime = np.sqrt(max(1.0, n * (closing.chi2_before - closing.chi2_after)))
    blur = closing.floor**2 / (closing.before**2 - closing.floor**2) + 1e-6
    spread = float(np.linalg.norm([max(CLOSES_WITHIN, left), PER_D_PRIME / d_prime, blur]))
    missing = max(0.0, 1.0 - closing.closed)
    of_another = float(ndtr(missing / blur) - ndtr((min(missing, 1.0) - 1.0) / blur))
    of_right = float(np.exp(-0.5 * (missing / spread) ** 2)) / (spread * float(np.sqrt(2.0 * np.pi)))
    return min(1.0, of_right / of_another)


def credible_set(found: Sequence[Cause]) -> tuple[Cause, ...]:
    """Return the fewest causes that hold `CREDIBLE` of the probability."""
    kept: list[Cause] = []
    for cause in found:
        kept.append(cause)
        if sum(c.probability for c in kept) >= CREDIBLE:
            break
    return tuple(kept)


def _parts(head: Judged) -> list[set[int]]:
    """Return for every effect of a hypothesis the candidates that are the same cause.

    Those are confounded with it (d' < 3), or, where the effect lies between places, next to it: neighbours are one.
    """
    found: dict[object, set[int]] = {}
    for j in head.members:
        near = {j, *neighbours(head.model, j)} if head.model.inputs.candidates[j].n_between else {j}
        alike = np.flatnonzero(_distances(head, j) < SEPARABLE).tolist()
        found.setdefault(_part(head, j), set()).update(near, alike)
    return list(found.values())


def _distances(head: Judged, member: int) -> Floats:
    return distances_from(head.allowing, head.fit, member, head.inference.error_of)


def _part(head: Judged, member: int) -> object:
    """Return what makes members one part of a set: the effect where it lies between places, else the candidate."""
    candidate = head.model.inputs.candidates[member]
    return candidate.name if candidate.n_between else member


def _is_same(head: Judged, parts: Sequence[set[int]], other: Judged) -> bool:
    if head.has_unknown or other.has_unknown:  # whatever acts beside it, the library does not hold the cause
        return head.has_unknown and other.has_unknown
    if not parts or not other.members:
        return False
    grouped: dict[object, set[int]] = {}
    for j in other.members:
        grouped.setdefault(_part(head, j), set()).add(j)
    if len(grouped) != len(parts):
        return False
    return any(all(g <= p for g, p in zip(order, parts, strict=True)) for order in permutations(grouped.values()))


def _cause(head: Judged, same: Sequence[Judged]) -> Cause:
    probability = float(sum(h.probability for h in same))
    d_prime = tuple(head.inference.visibilities(head.members).tolist())
    seen = [j for j, d in zip(head.members, head.inference.visible(head.members), strict=True) if d >= VISIBLE]
    is_identifiable = len(seen) == len(head.members)
    if head.has_unknown and (not is_identifiable or head.probability < 0.5 * probability):  # nothing else stands out
        return Cause((UNKNOWN,), probability, (), (), True, head)
    confounded = tuple(found for j in seen if (found := _confounded(head, same, j)))
    named = (*head.effects, *[UNKNOWN] * head.has_unknown)
    return Cause(named, probability, parameters(head, same), confounded, is_identifiable, head, d_prime)


def _confounded(head: Judged, same: Sequence[Judged], member: int) -> ConfoundedEffects | None:
    inputs, d_prime = head.model.inputs, _distances(head, member)
    found: dict[str, int] = {}
    for j in np.argsort(np.round(d_prime, DIGITS), kind="stable").tolist():
        if d_prime[j] < SEPARABLE and inputs.candidates[j].name != inputs.candidates[member].name:
            found.setdefault(inputs.candidates[j].name, j)
    if not found:
        return None
    alike, apart = [inputs.candidates[j] for j in (member, *found.values())], d_prime[list(found.values())].tolist()
    exact = max(apart) < EXACT
    way = "change these readings in the same way" if exact else "have signatures in these readings that are too alike"
    return ConfoundedEffects(
        effects=tuple(candidate.name for candidate in alike),
        places=tuple(candidate.place for candidate in alike),
        d_prime=(0.0, *apart),
        shares=tuple(_share(candidate.name, same) for candidate in alike),
        words=tuple(words_at(candidate.effect, inputs.twin, candidate.place).name for candidate in alike),
        reason=f"they {way} (d' {', '.join(f'{d:.1f}' for d in apart)}, 3 is needed)",
        separated_by=tuple(candidate.effect.separated_by for candidate in alike[:MOST_SEPARATIONS]),
    )


def _share(name: str, same: Sequence[Judged]) -> float:
    """Return the part of the probability of these hypotheses that those with an effect hold."""
    whole = sum(h.probability for h in same)
    return float(sum(h.probability for h in same if name in h.effects) / max(whole, 1e-300))
