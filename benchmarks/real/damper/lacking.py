"""Which effects the twin lacks: evidence over what follows a reversal and over what adds to the force, with sizes.

The candidates for what follows a reversal are those of `path`; to the best of them, effects that add to the force are
tried in all combinations:

| effect | adds to the force |
|---|---|
| speed_dependence | velocity: viscous if positive, friction that falls with speed if negative |
| breakaway | friction that falls off with speed: F exp(-|v| / v0), v0 = `SLOW` |
| direction | friction that differs between the directions beyond the tension |
| force_zero | a constant |
| inertia | acceleration |
| centring | displacement from the middle |
| force_delay | the time derivative of the force |
| tension_power | F log(T / T0): friction not proportional to tension |

Each test is weighed by its own friction level. Residuals of one test's cells are alike, so the number of independent
readings is not that of cells: n_eff = n / design effect, the variance of the friction with the residuals of each test
summed first over that with all residuals independent. With k sizes,

    log p(data | candidate) = -(n_eff log(rest) + k log n_eff) / 2.                                  (2)

The diagnosis of `octmip.gap` asks for readings that are the same at every load and for residuals with a known noise;
here each test has a load, an amplitude and a frequency of its own, the candidates are not linear in their sizes, and
the scatter between tests is what is left, so the evidence is taken here.
Source of (2): Schwarz (1978), "Estimating the dimension of a model", Annals of Statistics 6; of the jackknife: Tukey
(1958), Annals of Mathematical Statistics 29; of the design effect: Kish (1965), "Survey sampling".
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy import stats

from benchmarks.real.damper.cycles import Samples
from benchmarks.real.damper.path import COORDINATES, KINDS, Path, averaged, fitted, share, sizes_of
from benchmarks.real.damper.series import Recording
from benchmarks.real.damper.slack import slack_force, slacks, stiffnesses
from femlib.arrays import FloatArray

EXTRAS: Mapping[str, str] = {
    "speed_dependence": "kip s/in",
    "breakaway": "of the friction",
    "direction": "of the friction",
    "force_zero": "kip",
    "inertia": "kip s2/in",
    "centring": "kip/in",
    "force_delay": "s",
    "tension_power": "-",
}
PHASE_PRIOR = 0.05
"""Prior weight of a slack that grows with the amplitude beside one that does not: no mechanism is known for it, and
tests of one amplitude do not tell them apart."""
SLOW = 0.5
"""Speed [in/s] over which friction may fall off."""
MOST = 3
"""Effects that are tried at once beside the path."""
INTERVAL = 0.9
FLOOR = 1e-3
"""Share of the square of the force below which candidates are not told apart: no model of a machine is that good."""


@dataclass(frozen=True, slots=True)
class Found:
    """A path and the extra effects beside it, with sizes."""

    path: Path
    extras: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Size:
    """An effect of a series: size with its 90 % interval, and the probability that the twin lacks it.

    `worth` is the share of the square of the force that stays open without it.
    """

    name: str
    size: float
    low: float
    high: float
    unit: str
    probability: float
    worth: float


@dataclass(frozen=True, slots=True, eq=False)
class Chances:
    """Probabilities of the paths by name and of each extra, and what each path leaves of the square of the force."""

    paths: Mapping[str, float]
    extras: Mapping[str, float]
    left: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Lacking:
    """The verdict on a series: what the candidates' chances are, the effects with their sizes, the best model."""

    chances: Chances
    sizes: tuple[Size, ...]
    best: Found


def columns(path: Path, data: Samples, reference: float) -> Mapping[str, FloatArray]:
    """Return what each extra adds to the force per unit of its size [kip], at the samples."""
    part = share(path, data, reference) * reference * path.friction * data.half
    speed = np.abs(data.velocity)
    slope = np.where(np.diff(data.since, prepend=0.0) > 0.0, np.diff(part, prepend=part[:1]), 0.0)
    step = float(np.median(np.diff(data.since)[np.diff(data.since) > 0.0]))
    return {
        "speed_dependence": data.velocity,
        "breakaway": part * np.exp(-speed / SLOW),
        "direction": part * data.half,
        "force_zero": np.ones(len(part)),
        "inertia": data.acceleration,
        "centring": data.position,
        "force_delay": -slope / step,
        "tension_power": part * np.log(data.now / reference),
    }


def modelled(found: Found, data: Samples, reference: float | None = None) -> FloatArray:
    """Return the force [kip] at the samples; `reference` [lb] is the T0 of the fit, the samples' own by default."""
    reference = float(np.median(data.now)) if reference is None else reference
    force = share(found.path, data, reference) * reference * found.path.friction * data.half
    added = columns(found.path, data, reference)
    return np.asarray(force + sum((size * added[name] for name, size in found.extras.items()), np.zeros(len(force))))


def with_extras(path: Path, names: tuple[str, ...], data: Samples) -> Found:
    """Return the extras' sizes beside a path, by least squares on the weighed cells; friction is fitted with them."""
    cell = data.cell
    weight = 1.0 / averaged(data.now, cell)
    added = columns(path, data, float(np.median(data.now)))
    own = modelled(Found(path, {}), data)
    matrix = np.array([averaged(row, cell) * weight for row in (own, *(added[name] for name in names))]).T
    sizes = np.linalg.lstsq(matrix, averaged(data.force, cell) * weight, rcond=None)[0]
    scaled = Path(path.kind, path.coordinate, path.friction * float(sizes[0]), path.gap, path.wind, path.power)
    friction = {"breakaway", "direction", "tension_power", "force_delay"}
    told = {n: float(s) / (float(sizes[0]) if n in friction else 1.0) for n, s in zip(names, sizes[1:], strict=True)}
    return Found(scaled, told)


def rest(found: Found, data: Samples) -> float:
    """Return the share of the square of the force that a model leaves in the cells, each test over its tension."""
    cell = data.cell
    weight = 1.0 / averaged(data.now, cell)
    left = averaged(data.force - modelled(found, data), cell) * weight
    return float(np.sum(left**2) / np.sum((averaged(data.force, cell) * weight) ** 2))


def lacking(data: Samples, tests: Sequence[Recording]) -> Lacking:
    """Return what the twin lacks in a series of tests, of which `data` are the samples."""
    paths = [fitted("twin", "stroke", data)]
    paths += [fitted(kind, coordinate, data) for kind in KINDS for coordinate in COORDINATES]
    left = {path.name: rest(Found(path, {}), data) for path in paths}
    first = min(paths[1:], key=lambda path: left[path.name] * (1.0 + 1e-3 * len(sizes_of(path))))
    n = independent(first, data)
    prior = np.array([np.log(PHASE_PRIOR if path.coordinate == "phase" else 1.0) for path in paths])
    chances = weights([left[path.name] for path in paths], [1 + len(sizes_of(path)) for path in paths], n, prior)
    path = paths[int(np.argmax(chances))]
    sets = [names for count in range(MOST + 1) for names in combinations(EXTRAS, count)]
    fits = [with_extras(path, names, data) for names in sets]
    shares = weights([rest(fit, data) for fit in fits], [len(names) for names in sets], n, np.zeros(len(sets)))
    inclusion = {name: float(sum(s for s, names in zip(shares, sets, strict=True) if name in names)) for name in EXTRAS}
    best = with_extras(path, tuple(name for name in EXTRAS if inclusion[name] > 0.5), data)
    told = {path.name: float(chance) for path, chance in zip(paths, chances, strict=True)}
    found = Chances(told, inclusion, left)
    return Lacking(found, sized(best, found, data, tests), best)


def weights(left: list[float], sizes: list[int], n: float, prior: FloatArray) -> FloatArray:
    """Return the posterior probabilities of candidates by (2)."""
    logs = -0.5 * (n * np.log(np.array(left) + FLOOR) + np.array(sizes) * np.log(n)) + prior
    chances = np.exp(logs - logs.max())
    return np.asarray(chances / chances.sum())


def without_each(data: Samples) -> list[Samples]:
    """Return the samples without each test in turn."""
    tests = np.unique(data.test)
    return [data.of(tests[tests != test]) for test in tests] if len(tests) > 1 else [data]


def independent(path: Path, data: Samples) -> float:
    """Return the number of independent readings among the cells, by the design effect of the friction's estimate."""
    cell = data.cell
    n = int(cell.max()) + 1
    weight = 1.0 / averaged(data.now, cell)
    model = averaged(modelled(Found(path, {}), data), cell) * weight
    residual = averaged(data.force, cell) * weight - model
    naive = float(np.mean(residual**2) / (model @ model))
    owner = averaged(data.test, cell)
    scores = np.array([model[owner == test] @ residual[owner == test] for test in np.unique(owner)])
    clustered = float((scores**2).sum() / (model @ model) ** 2)
    tests = len(scores)
    return float(np.clip(n * naive / max(clustered, 1e-30), tests, n))


def sized(best: Found, chances: Chances, data: Samples, tests: Sequence[Recording]) -> tuple[Size, ...]:
    """Return the effects of more than even odds with their sizes: slack and stiffness from each test by itself."""
    return (*after_reversal(chances, data, tests), *beside(best, chances, data))


def after_reversal(chances: Chances, data: Samples, tests: Sequence[Recording]) -> list[Size]:
    """Return the effects at a reversal: slack in the displacement and how stiffly the force rebuilds, or a time lag."""
    paths, left = chances.paths, chances.left
    late = sum(p for name, p in paths.items() if "since" in name)
    if late > 0.5:
        plain = fitted("delay", "since", data)
        each = [fitted("delay", "since", part).gap for part in without_each(data)]
        worth = left["twin"] - min(rest for name, rest in left.items() if "since" in name)
        return [jackknifed("time_lag", plain.gap, each, "s", late, worth)]
    force, found = slack_force(tests), []
    lost = 1.0 - late - paths["twin"]
    if lost > 0.5 and (each := slacks(tests, force)):
        found.append(mean_of("backlash", each, "in", lost, left["twin"] - left["gap in stroke"]))
    gradual = sum(p for name, p in paths.items() if name.startswith(("wind", "both")) and "since" not in name)
    if gradual > 0.5 and (each := stiffnesses(tests, force)):
        worth = left["gap in stroke"] - left["wind in stroke"]
        found.append(mean_of("rebuild_stiffness", each, "kip/in", gradual, worth))
    return found


def beside(best: Found, chances: Chances, data: Samples) -> list[Size]:
    """Return the effects that add to the force."""
    whole = rest(best, data)
    others = [with_extras(best.path, tuple(best.extras), part).extras for part in without_each(data)]
    found = []
    for name, size in best.extras.items():
        worth = rest(with_extras(best.path, tuple(one for one in best.extras if one != name), data), data) - whole
        each = [other[name] for other in others]
        found.append(jackknifed(name, size, each, EXTRAS[name], chances.extras[name], worth))
    return found


def mean_of(name: str, each: list[float], unit: str, probability: float, worth: float) -> Size:
    """Return the mean over tests, its interval by Student's t."""
    n = len(each)
    sd = float(np.std(each, ddof=1) / np.sqrt(n)) if n > 1 else abs(each[0])
    return with_interval(Size(name, float(np.mean(each)), sd, sd, unit, probability, worth), n)


def jackknifed(name: str, size: float, each: list[float], unit: str, probability: float, worth: float) -> Size:
    """Return a size with the interval that leaving each test out gives."""
    n = len(each)
    sd = float(np.sqrt((n - 1) / n * np.sum((np.array(each) - np.mean(each)) ** 2))) if n > 1 else abs(size)
    return with_interval(Size(name, size, sd, sd, unit, probability, worth), n)


def with_interval(size: Size, n: int) -> Size:
    """Return a size, of which `low` holds the standard error from n tests, with its 90 % interval."""
    half = float(stats.t.ppf(0.5 + INTERVAL / 2.0, max(n - 1, 1))) * size.low
    return replace(size, low=size.size - half, high=size.size + half, probability=min(size.probability, 1.0))
