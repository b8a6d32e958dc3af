"""A cantilever written in a few lines, with its own effects: the twin and the asset of the gap tests."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from octmip.gap import CHAIN, Campaign

SD = 31.6
"""Standard deviation of a reading [microstrain]."""
ETA = np.concatenate([np.linspace(0.26, 0.47, 8), np.linspace(0.57, 0.755, 8), np.linspace(0.3, 0.7, 4)])
ROW = np.concatenate([np.full(16, 0.21), np.full(4, 0.35)])
HEALTHY = 980 * (1 - ETA) ** 1.6 * (1 + 1.1 * (ROW - 0.21)) + 60
CHANGE = [
    400 * np.exp(-(((ETA - 0.31) / 0.08) ** 2)) * (1 + 2.9 * (ROW - 0.21)),
    160 * np.exp(-(((ETA - 0.75) / 0.08) ** 2)) * (1 + 2.9 * (ROW - 0.21)),
]


@dataclass(frozen=True)
class Field:
    """An effect that adds a field: relative to the strain (power 1) or in microstrain times load_factor**power."""

    name: str
    shape: np.ndarray
    load_power: int | None
    prior_sd: float
    unit: str = "%"
    prior_mean: float = 0.0
    parameter: str = "size of the field"
    is_one_sided: bool = False
    separated_by: str = "its shape"
    seen_by: tuple[str, ...] = ()
    signature_error = 0.0  # no field of the dataclass: kinds of fields have their own

    def places(self, twin):
        return ("",)

    def signature(self, twin, state, load_factor, place="", time=0.0):
        if self.load_power is None:
            return self.shape * twin.predict(state, load_factor)
        return self.shape * load_factor**self.load_power


class Bumps(Field):
    """A bump anywhere along the span, told at six places, as tall as eta**power."""

    n_between = 2
    power = 0

    def places(self, twin):
        return tuple(f"{eta:.2f}" for eta in np.linspace(0.25, 0.75, 6))

    def signature(self, twin, state, load_factor, place="", time=0.0):
        return self.at(float(place), load_factor)

    @classmethod
    def at(cls, eta, load_factor):
        return load_factor * eta**cls.power * np.exp(-(((ETA - eta) / 0.15) ** 2))


def own_effects():
    found = [
        Field("modulus", np.full(20, -0.01), None, 2.0, seen_by=("deflection", "frequency")),
        Field("temperature_uniform", np.full(20, -2.5), 0, 10.0, "K", seen_by=("thermal_zero",)),
        Field("temperature_gradient", np.linspace(-2, 2, 20), 0, 5.0, "K", seen_by=("thermal_zero",)),
        Field("lift_distribution", 0.02 * (ETA - 0.3), None, 4.0),
        Field("large_deflection", -3 * np.linspace(0.2, 1.0, 20), 2, 1.0, "-", seen_by=("deflection",)),
    ]
    return {effect.name: effect for effect in found}


@dataclass
class Beam:
    gauges: tuple = tuple(f"g{k + 1:02d}" for k in range(20))
    parameters: tuple = ("mu1", "mu2")
    effects: dict = field(default_factory=own_effects)
    gauge_positions: np.ndarray = field(default_factory=lambda: np.stack([0.35 * ROW, 1.8 * ETA], axis=1))

    def predict(self, state, load_factor):
        damage = [state.get(name, 0.0) for name in self.parameters]
        return load_factor * (HEALTHY + sum(c * mu / (1 - 0.6 * mu) for c, mu in zip(CHANGE, damage, strict=False)))


def own_gains(mesh: float = 0.01):
    """Return what the asset's gauges show of the twin's healthy strain (20,): the same for all seeds."""
    return 1 + mesh * (0.9 + np.random.default_rng(12345).standard_normal(20))


class Asset(Beam):
    """The beam as its gauges read it."""

    def predict(self, state, load_factor):
        return own_gains() * super().predict(state, load_factor)


Change = Callable[[dict, float, float], np.ndarray]


def effect(name: str, size: float, place: str = "") -> Change:
    """Return the change by an effect; those of the measuring chain act on what the asset's gauges see."""
    acting, strained = {**CHAIN, **own_effects()}[name], Asset() if name in CHAIN else Beam()
    return lambda state, load, time: size * acting.signature(strained, state, load, place=place, time=time)


def both(*changes: Change) -> Change:
    return lambda state, load, time: sum(change(state, load, time) for change in changes)


def sound_readings(campaign: Campaign) -> np.ndarray:
    """Return what the twin says of every row of a campaign of the sound asset."""
    return np.array([Beam().predict({}, load) for load in campaign.load_factor])


def remembering(rng, shape, rho):
    """Return AR(1) of unit variance along the first axis."""
    series = rng.standard_normal((shape[0] + 200, *shape[1:]))
    for k in range(1, len(series)):
        series[k] = rho * series[k - 1] + np.sqrt(1.0 - rho**2) * series[k]
    return series[200:]


def serial(rho):
    """Return noise in which each reading remembers the one before."""
    return lambda rng, shape, load: SD * remembering(rng, shape, rho)


def measured(
    seed: int,
    change: Change | None = None,
    states=((0.0, 0.0),),
    loads=(0.0, 1.0, 2.0, 3.0),
    repeats: int = 50,
    sd: float = SD,
    known: bool = True,
    mesh: float = 0.01,
    noise: Callable | None = None,
) -> Campaign:
    """Return a campaign of a beam that differs from the twin by some 1 % per gauge, and by `change(state, load, time)`.

    The difference is the same for all seeds: campaigns of one asset.
    """
    rng = np.random.default_rng(seed)
    twin = Beam()
    own = own_gains(mesh)
    rows, time = [], 0.0
    for number, state in enumerate(states):
        named = dict(zip(twin.parameters, state, strict=True))
        for load in loads:
            scatter = rng.standard_normal((repeats, 20)) * sd if noise is None else noise(rng, (repeats, 20), load)
            for k in range(repeats):
                time += 6.0
                extra = 0.0 if change is None else change(named, load, time - 6.0)
                rows.append((f"T{number}", load, state, time, own * twin.predict(named, load) + extra + scatter[k]))
    states_given = np.array([r[2] for r in rows], dtype=float)
    return Campaign(
        gauges=twin.gauges,
        parameters=twin.parameters,
        test=tuple(r[0] for r in rows),
        load_factor=np.array([r[1] for r in rows]),
        states=states_given if known else np.full_like(states_given, np.nan),
        readings=np.array([r[4] for r in rows]),
        time=np.array([r[3] for r in rows]),
        temperature=np.full(len(rows), np.nan),
    )
