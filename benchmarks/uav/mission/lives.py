"""Lives: the bands of a forecast beside what becomes of simulated wings that fly at 3 g until they break.

Damage grows by gamma increments (Source: J. M. van Noortwijk, Reliab. Eng. Syst. Saf. 94 (2009) 2-21) of a rate of each
wing's own, which is none of the filter's, and of the scale of the filter's cells. The filter sees leaves alone, and
allows for no sudden damage, as there is none.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission.aircraft import NOISE_SD, Aircraft
from benchmarks.uav.mission.capable import chance_of_failing
from benchmarks.uav.mission.course_plan import cell_points
from octmip.monitor import (
    Belief,
    Filter,
    LeafLikelihood,
    grid_states,
    learnt_rates,
    library_of,
    remaining_life,
    steady_growth,
)

Floats = NDArray[np.float64]

SEEN, LONGEST = 40, 1500
"""Readings before the forecast, and its steps."""
WIDTHS = (0.05, 0.2)
"""Of the filter's cells; mu2 hardly changes what the wing bears."""
RATES = np.geomspace(0.0005, 0.0075, 5)
"""Of the filter in a step; any wing grows by one between the ends."""
FLEET = (0.003, 0.005)
"""Rates of a fleet of one kind, which a filter learns."""
SEASONS, FLOWN = 4, 50
"""In which it learns them, and wings that fly in each."""


def life_rows(aircraft: Aircraft, n: int, seed: int) -> Iterator[dict[str, object]]:
    """Yield how many of n lives end within their 90 % bands: of any wing, of a fleet, and of it by rates learnt."""
    rng, chain = np.random.default_rng(seed), _filter(aircraft)
    fails = chance_of_failing(cell_points(chain.library, aircraft.capable), 3.0).mean(axis=1)
    rates = np.full(chain.growth.n_rates, 1.0 / chain.growth.n_rates)
    learnt = rates
    for _ in range(SEASONS):
        learnt = learnt_rates(learnt, _lives(aircraft, chain, FLOWN, FLEET, rng, learnt)[0])
    for wings, ends, held in (
        ("of any rate", (RATES[0], RATES[-1]), rates),
        ("of a fleet", FLEET, rates),
        (f"of a fleet, rates learnt over {SEASONS} x {FLOWN}", FLEET, learnt),
    ):
        belief, left = _lives(aircraft, chain, n, ends, rng, held)
        low, high = remaining_life(chain.growth, belief, fails, LONGEST).interval(0.9)
        is_inside = (low <= left) & (left <= high)
        yield {
            "wings": wings,
            "lives": len(left),
            "within 90 % bands %": round(100 * float(is_inside.mean()), 1),
            "ended before %": round(100 * float((left < low).mean()), 1),
            "median band in steps": f"{np.median(low):.0f} to {np.median(high):.0f}",
            "seed": seed,
        }


def _filter(aircraft: Aircraft) -> Filter:
    centres = [((np.arange(round(0.8 / width)) + 0.5) * width).tolist() for width in WIDTHS]
    cells = library_of(aircraft.twin, grid_states(centres), NOISE_SD, gauges=aircraft.gauges, widths=WIDTHS)
    return Filter(LeafLikelihood(aircraft.selector.tree, cells), steady_growth(cells, RATES.tolist()))


def _lives(
    aircraft: Aircraft, chain: Filter, n: int, ends: tuple[float, float], rng: np.random.Generator, rates: Floats
) -> tuple[Belief, Floats]:
    """Return the belief after SEEN readings about the wings that live on, and the steps (n,) that are left to each."""
    width = WIDTHS[0]
    own = np.exp(rng.uniform(np.log(ends[0]), np.log(ends[1]), (n, 1, 2)))
    damage = np.minimum(np.cumsum(rng.gamma(own / width, width, (n, SEEN + LONGEST, 2)), axis=1), 0.9)
    chance = aircraft.capable.fails(damage.reshape(-1, 2), 3.0).reshape(n, -1)
    is_over = rng.random(chance.shape) < chance
    is_alive = ~is_over[:, :SEEN].any(axis=1)
    damage, is_over = damage[is_alive], is_over[is_alive, SEEN:]
    left = np.where(is_over.any(axis=1), is_over.argmax(axis=1) + 1.0, np.inf)
    belief = chain.start(len(damage), 0, rates)
    for k in range(SEEN):
        strains = aircraft.strains(damage[:, k])
        belief = chain.step(belief, 3.0 * strains + rng.normal(0.0, NOISE_SD, strains.shape), 3.0)
    return belief, left
