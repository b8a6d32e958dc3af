"""Two twins that are no wing, each from its page of the documentation: how often what is drawn blindly is named.

The draw takes one effect that the twin lacks (one of its own, or an offset or a gain of one instrument), a size between
half and twice its prior scale, within its bounds and of either sign, and a noise between half and twice `NOISE` of each
unit's readings. The asset differs from the twin by `MODEL` at every reading besides, as an honest model does. The truth
is drawn from the seed alone and compared with the first cause that the diagnosis names.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.cpu import Stopwatch
from benchmarks.tables import Line
from octmip.gap import Diagnosis, FunctionTwin, Recorded, diagnose, gathered
from octmip.gap.effects import chain_of
from octmip.twin import Effect, channels_of, load_of, loads_of, units_of

Floats = NDArray[np.float64]

PAGES = Path(__file__).resolve().parents[3] / "docs" / "examples" / "twins"
LOADS: dict[str, tuple[dict[str, float], ...]] = {
    "joint": ({"amplitude": 0.3}, {"amplitude": 0.45}, {"amplitude": 0.6}),
    "rod": ({"power": 5.0, "air": 20.0}, {"power": 10.0, "air": 21.0}, {"power": 20.0, "air": 23.0}),
}
"""What is applied to each, load by load."""
DRAWS, REPEATS = 10, 20
MODEL = 0.002
"""Relative sd by which the sound asset differs from the twin at each reading."""
NOISE = 0.005
"""Sd of one reading over the rms of its unit's readings, at a factor of one half to two."""


@dataclass(frozen=True, slots=True)
class Truth:
    """What acts in one draw.

    Attributes
    ----------
    effect, place, size
        name, place and size in the effect's unit.
    noise
        factor on `NOISE`.
    """

    effect: str
    place: str
    size: float
    noise: float


def twin_of(name: str) -> FunctionTwin:
    """Return the twin of a page of the documentation: what its first block of code makes."""
    found = re.search(r"```python\n(.*?)```", (PAGES / f"{name}.md").read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    space: dict[str, Any] = {}
    exec(found[1], space)
    twin = space["twin"]
    assert isinstance(twin, FunctionTwin)
    return twin


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each draw of each twin."""
    for name in LOADS:
        twin = twin_of(name)
        for seed in range(DRAWS):
            yield drawn(name, twin, seed)


def drawn(name: str, twin: FunctionTwin, seed: int) -> Line:
    """Return what one draw holds and what the diagnosis says of it."""
    watch = Stopwatch()
    rng = np.random.default_rng([seed, sum(name.encode())])
    library = _library(name, twin)
    truth = _truth(rng, twin, library)
    diagnosis = diagnose(gathered(twin, _recorded(name, twin, library, truth, rng)), twin)
    return {"size": name, "seed": seed, **_answer(diagnosis, truth), "cpu_seconds": watch.read()[0]}


def _library(name: str, twin: FunctionTwin) -> dict[str, Effect]:
    """Return the effects that are drawn from."""
    chain = chain_of(twin, _typical(name, twin))
    kept = {key: effect for key, effect in chain.items() if key.startswith(("gauge_bias", "gauge_gain"))}
    return {**twin.effects, **kept}


def _typical(name: str, twin: FunctionTwin) -> dict[str, float]:
    """Return the root mean square of the readings of each unit."""
    sound = np.array([twin.predict({}, _load(twin, loads)) for loads in LOADS[name]])
    units = np.array(units_of(twin))
    return {unit: float(np.sqrt(np.mean(sound[:, units == unit] ** 2))) for unit in dict.fromkeys(units.tolist())}


def _load(twin: FunctionTwin, loads: dict[str, float]) -> Any:
    names = loads_of(twin)
    return load_of(names, tuple(loads[name] for name in names))


def _truth(rng: np.random.Generator, twin: FunctionTwin, library: dict[str, Effect]) -> Truth:
    effect = library[str(rng.choice(sorted(library)))]
    low, high = getattr(effect, "bounds", (-np.inf, np.inf))
    size = float(rng.uniform(0.5, 2.0) * effect.prior_sd * (1.0 if effect.is_one_sided else rng.choice([-1.0, 1.0])))
    places = effect.places(twin)
    return Truth(effect.name, str(rng.choice(places)), float(np.clip(size, low, high)), float(2 ** rng.uniform(-1, 1)))


def _recorded(
    name: str, twin: FunctionTwin, library: dict[str, Effect], truth: Truth, rng: np.random.Generator
) -> list[Recorded]:
    typical = _typical(name, twin)
    scale = np.array([typical[unit] for unit in units_of(twin)])
    own = 1.0 + MODEL * rng.standard_normal(len(scale))
    blocks = []
    for loads in LOADS[name]:
        mean = own * _with(library[truth.effect], twin, _load(twin, loads), truth)
        scatter = truth.noise * NOISE * scale * rng.standard_normal((REPEATS, len(scale)))
        blocks.append(Recorded(mean + scatter, loads))
    return blocks


def _with(effect: Effect, twin: FunctionTwin, load: Any, truth: Truth) -> Floats:
    """Return the readings with the effect: by its exact map where it has one."""
    exact = getattr(effect, "predict", None)
    if exact is not None:
        return np.asarray(exact(twin, {}, load, truth.size, truth.place, 0.0))
    return np.asarray(twin.predict({}, load) + truth.size * effect.signature(twin, {}, load, truth.place))


def _answer(diagnosis: Diagnosis, truth: Truth) -> Line:
    """Return truth and answer side by side."""
    first = diagnosis.which[0]
    named = [(p.effect, p.place) for p in first.parameters]
    own = [p for p in first.parameters if (p.effect, p.place) == (truth.effect, truth.place)]
    beside = {(e, p) for c in first.confounded for e, p in zip(c.effects, c.places, strict=True)}
    return {
        "truth": f"{truth.effect} {truth.place}".strip(),
        "true_size": truth.size,
        "noise": truth.noise,
        "named": " and ".join(f"{e} {p}".strip() for e, p in named) or " ".join(first.effects) or "sound",
        "probability": first.probability,
        "is_right": named == [(truth.effect, truth.place)],
        "is_among": (truth.effect, truth.place) in {*named, *beside},
        "is_within": bool(own) and own[0].low <= truth.size <= own[0].high,
        "instruments": len(set(channels_of(diagnosis.posterior.model.inputs.twin))),
    }


def summary(lines: Sequence[Line]) -> str:
    """Return how often the effect was named, and how often its size lay within the interval."""
    rows = [
        "| twin | draws | named alone | named, or beside it | size within its 90 % interval |",
        "|---|---|---|---|---|",
    ]
    for name in dict.fromkeys(line["size"] for line in lines):
        own = [line for line in lines if line["size"] == name]
        right = [line for line in own if line["is_right"]]
        among, within = sum(line["is_among"] for line in own), sum(line["is_within"] for line in right)
        rows.append(f"| {name} | {len(own)} | {len(right)} | {among} | {within} of {len(right)} |")
    return "\n".join(rows)
