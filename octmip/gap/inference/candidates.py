"""Candidates: one effect at one place each, the unit of all hypotheses.

A candidate adds size * signature to the readings with size ~ N(mean, (scale sd)^2), scale 1/3, 1 or 3 with equal
weight; a size known to be positive keeps the positive half. A discrete effect (swapped or not) has one scale only.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, TwinError
from octmip.gap.effects import in_chain
from octmip.gap.effects.simple import SIGNATURE_ERROR, test_of
from octmip.gap.odds import Odds
from octmip.twin import Effect, State, Twin

Forward = Callable[[Twin, State, Any, float, str, float], NDArray[np.float64]]
"""Twin, state, load, size, place and time -> readings (n_gauges,) with an effect of that size."""

NEEDED = (
    "name", "parameter", "unit", "prior_mean", "prior_sd", "is_one_sided", "separated_by", "load_power",
    "places", "signature",
)  # fmt: skip
"""What every effect says itself."""
SCALES = (1 / 3, 1.0, 3.0)
"""Factors on the sd of every prior, equally likely: no result may hang on one guess of the size."""
OF_TESTS = 0.2
"""Share of an effect's prior probability that it acts in single tests, where it may."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """One effect at one place.

    Attributes
    ----------
    effect
        the effect.
    place
        where it acts, "" for the whole.
    weight
        share of the effect's prior probability, the look-elsewhere correction.
    """

    effect: Effect
    place: str
    weight: float

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name

    @property
    def test(self) -> str:
        """The test in which alone it acts; "" where it acts in all."""
        return test_of(self.effect, self.place)

    @property
    def is_nameless(self) -> bool:
        """Whether it is a cell of the families without a name of its own."""
        return bool(getattr(self.effect, "is_nameless", False))

    @property
    def is_discrete(self) -> bool:
        """Whether the size is known once the effect is there."""
        return self.effect.prior_mean != 0.0

    @property
    def signature_errors(self) -> NDArray[np.float64]:
        """Relative sd of the signature, the same at each of the twin's readings or one for each (n_gauges,)."""
        usual = 0.0 if in_chain(self.effect) else SIGNATURE_ERROR
        return np.asarray(getattr(self.effect, "signature_error", usual), dtype=np.float64)

    @property
    def signature_error(self) -> float:
        """Relative sd of the signature where it is known best: how well the model knows what the effect does."""
        return float(np.min(self.signature_errors))

    @property
    def n_between(self) -> int:
        """Number of neighbouring places between which the effect may lie; 0 where each place is its own."""
        return int(getattr(self.effect, "n_between", 0))

    @property
    def forward(self) -> Forward | None:
        """The exact forward map, where the effect is not linear in its size."""
        forward: Forward | None = getattr(self.effect, "predict", None)
        return forward


@dataclass(frozen=True, slots=True, eq=False)
class Priors:
    """The priors of all candidates as arrays (n_candidates,).

    Attributes
    ----------
    mean, sd
        of the size.
    bounds
        (2, n_candidates) lowest and highest size.
    is_discrete
        as the candidates say.
    log_weight
        log of the candidates' shares.
    name
        index of each candidate's effect among the effects.
    n_effects
        number of effects.
    """

    mean: NDArray[np.float64]
    sd: NDArray[np.float64]
    bounds: NDArray[np.float64]
    is_discrete: NDArray[np.bool_]
    log_weight: NDArray[np.float64]
    name: NDArray[np.int64]
    n_effects: int


def explain_together(candidates: Sequence[Candidate]) -> bool:
    """Return whether candidates are an explanation: two cells without names are a field, which is unknown.

    Nor is an effect in all tests and in one of them: it has a size of its own in each then.
    """
    pairs = combinations(candidates, 2)
    return not any(
        (a.is_nameless and b.is_nameless) or (a.name == b.name and bool(a.test) != bool(b.test)) for a, b in pairs
    )


def sizes_by_test(candidates: Sequence[Candidate]) -> list[tuple[int, ...]]:
    """Return for each effect that may have a size of its own in every test those of its candidates."""
    found: dict[str, list[int]] = {}
    for j, one in enumerate(candidates):
        if one.test:
            found.setdefault(one.name, []).append(j)
    return [tuple(members) for members in found.values()]


def priors_of(candidates: Sequence[Candidate]) -> Priors:
    """Return the priors of these candidates."""
    names = list(dict.fromkeys(candidate.name for candidate in candidates))
    return Priors(
        mean=np.array([c.effect.prior_mean for c in candidates], dtype=np.float64),
        sd=np.array([c.effect.prior_sd for c in candidates], dtype=np.float64),
        bounds=np.array([bounds_of(c.effect) for c in candidates], dtype=np.float64).reshape(-1, 2).T,
        is_discrete=np.array([c.is_discrete for c in candidates], dtype=bool),
        log_weight=np.log(np.array([c.weight for c in candidates], dtype=np.float64)),
        name=np.array([names.index(c.name) for c in candidates], dtype=np.int64),
        n_effects=len(names),
    )


def bounds_of(effect: Effect) -> tuple[float, float]:
    """Return the lowest and the highest size of an effect, as it says or as its one side has them."""
    low, high = getattr(effect, "bounds", None) or (-np.inf, np.inf)
    return (max(0.0, float(low)) if effect.is_one_sided else float(low)), float(high)


def candidates_of(
    effects: Mapping[str, Effect], twin: Twin, gauges: Sequence[str], odds: Odds
) -> tuple[Candidate, ...]:
    """Return the candidates of all effects, those that act on gauges outside `gauges` left out.

    Raises
    ------
    TwinError
        an effect lacks something that every effect says, or two have one name.
    DataError
        an effect lacks a positive prior sd, or the odds name an effect that is not there.
    """
    _check(effects)
    found = []
    absent = set(twin.gauges) - set(gauges)
    factors = _factors(effects, odds)
    for effect in (effect for effect in effects.values() if factors[effect.name] > 0.0):
        if not effect.prior_sd > 0.0:
            raise DataError(f"effect {effect.name} has prior_sd {effect.prior_sd}; expected a positive size")
        places = [place for place in effect.places(twin) if absent.isdisjoint(gauges_of(effect, twin, place))]
        n_tests = sum(bool(test_of(effect, place)) for place in places)
        whole, single = 1.0 - OF_TESTS * bool(n_tests), OF_TESTS / max(n_tests, 1)
        shares = [single if test_of(effect, place) else whole / (len(places) - n_tests) for place in places]
        found += [Candidate(effect, p, factors[effect.name] * s) for p, s in zip(places, shares, strict=True)]
    return tuple(found)


def _check(effects: Mapping[str, Effect]) -> None:
    for key, effect in effects.items():
        missing = [name for name in NEEDED if not hasattr(effect, name)]
        if missing:
            raise TwinError(
                f"effect {key!r} ({type(effect).__name__}) has no {missing[0]}; expected {', '.join(NEEDED)}, or a "
                "SimpleEffect(name, unit, prior_sd, apply), which needs no more; add it"
            )
    names = [effect.name for effect in effects.values()]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise TwinError(f"two effects are called {twice[0]!r}; expected a name each; rename one")


def _factors(effects: Mapping[str, Effect], odds: Odds) -> dict[str, float]:
    """Return how many times as probable each effect is as the mean of all, by name."""
    names = [effect.name for effect in effects.values()]
    strangers = [name for name in odds.effects if name not in names]
    if strangers:
        raise DataError(
            f"odds name the effect {strangers[0]!r}, which the library lacks; expected among {names[:5]}..."
        )
    usual = {effect.name: float(getattr(effect, "commonness", 1.0)) for effect in effects.values()}
    factors = {name: odds.effects.get(name, usual[name]) for name in names}
    mean = float(np.mean([*factors.values()])) if factors else 1.0
    return {name: factor / max(mean, 1e-300) for name, factor in factors.items()}


def gauges_of(effect: Effect, twin: Twin, place: str) -> Sequence[str]:
    """Return the gauges of a place as the effect says, or those that the place can be read as."""
    own = getattr(effect, "gauges_of", None)
    if own is not None:
        return tuple(own(twin, place))
    return (place,) if place in twin.gauges else place.replace("<", "/").split("/")
