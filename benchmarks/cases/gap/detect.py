"""Distance of each effect from none and from its nearest confounder, what damage can imitate projected out.

d' is the distance in standard deviations of the mean readings (50 repeats of variance 1000, the calibration's error
included) of an effect at its prior scale, at its median place; the confounder is the effect of another name whose best
size leaves the least distance. Below 3 nothing can be said. No readings enter: the table stands before any test.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.tables import Line
from femlib.wing import WingTwin, uav_wing
from femlib.wing.effects import wing_effects
from octmip.gap import CHAIN, Campaign
from octmip.gap.inference.confounding import separations
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import LinearModel, linearise
from octmip.gap.twins.cached import CachedTwin

Distance = tuple[float, str, float]
"""d' from no effect, the nearest confounder's name, d' from that."""

LOADS = (0.0, 1.0, 2.0, 3.0)
SOUND, DAMAGED = (0.0, 0.0), (0.25, 0.45)
REPEATS, SD = 50, 1000.0**0.5
SETUPS = {
    "sound state, 4 loads": (SOUND, True, LOADS),
    "two unknown damages, 4 loads": (DAMAGED, False, LOADS),
    "two unknown damages, 1 load": (DAMAGED, False, (3.0,)),
}


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each set-up, with and without a commissioning run."""
    yield from detected(1.0)


def detected(refinement: float) -> Iterator[Line]:
    """Yield d' of every effect, its nearest confounder and d' from that (name: [d', confounder, d']) for a mesh."""
    wing = uav_wing(refinement=refinement)
    twin = CachedTwin(WingTwin(wing, wing_effects(wing)))
    for words, (state, is_known, loads) in SETUPS.items():
        for calibrated in (True, False):
            watch = Stopwatch()
            model = model_of(twin, state, is_known, loads, calibrated)
            run = "with" if calibrated else "without"
            yield {
                "size": f"{words}, {run} commissioning",
                "seed": 0,
                "cpu_seconds": watch.read()[0],
                "effects": distances(model),
            }


def model_of(
    twin: CachedTwin, state: tuple[float, ...], is_known: bool, loads: Sequence[float], calibrated: bool
) -> LinearModel:
    """Return the linear problem about a state with the readings that the twin predicts, noise added."""
    campaign = _campaign(twin, state, is_known, loads, 1)
    run = _campaign(twin, SOUND, True, LOADS, 2) if calibrated else None
    inputs, _ = prepare(campaign, twin, {**CHAIN, **twin.effects}, run)
    return linearise(inputs, np.tile(np.array(state), (len(campaign.cells), 1)))


def distances(model: LinearModel) -> dict[str, Distance]:
    """Return d' from no effect, the nearest confounder's name and d' from it, by effect."""
    candidates, prior = model.inputs.candidates, model.inputs.priors
    names = tuple(dict.fromkeys(candidate.name for candidate in candidates))
    own = np.hypot(prior.mean, np.where(prior.is_discrete, 0.0, prior.sd)) * np.sqrt(model.whitened.lengths)
    table = separations(model, names)
    found: dict[str, Distance] = {}
    for k, name in enumerate(names):
        of_name = [j for j, candidate in enumerate(candidates) if candidate.name == name]
        confounder = int(np.argmin(table[k]))
        found[name] = (float(np.median(own[of_name])), names[confounder], float(table[k, confounder]))
    return found


def _campaign(
    twin: CachedTwin, state: tuple[float, ...], is_known: bool, loads: Sequence[float], seed: int
) -> Campaign:
    rng = np.random.default_rng(seed)
    named = dict(zip(twin.parameters, state, strict=True))
    n = REPEATS * len(loads)
    load = np.repeat(loads, REPEATS)
    mean = np.repeat([twin.predict(named, value) for value in loads], REPEATS, axis=0)
    return Campaign(
        gauges=twin.gauges,
        parameters=twin.parameters,
        test=("T0",) * n,
        load_factor=load,
        states=np.tile(np.array(state) if is_known else np.full(len(state), np.nan), (n, 1)),
        readings=mean + SD * rng.standard_normal(mean.shape),
        time=6.0 * np.arange(n, dtype=np.float64),
        temperature=np.full(n, np.nan),
    )


def summary(lines: Sequence[Line]) -> str:
    """Return the table of docs/theory/gap.md: d' with / without commissioning, in brackets that from the confounder."""
    pairs = [(lines[k], lines[k + 1]) for k in range(0, len(lines), 2)]
    head = "| effect at its prior scale | " + " | ".join(words for words in SETUPS) + " |"
    rows = []
    for name in lines[0]["effects"]:
        cells = [" / ".join(_cell(line["effects"][name]) for line in pair) for pair in pairs]
        rows.append(f"| {name} | " + " | ".join(cells) + f" | {lines[0]['effects'][name][1]} |")
    return "\n".join([head + " nearest confounder |", "|" + "---|" * (len(SETUPS) + 2), *rows])


def _cell(found: Distance) -> str:
    return f"{found[0]:.1f} ({found[2]:.1f})"
