"""The published strain table as the asset, femlib's wing as the twin: a real gap between two models of one wing.

The table holds means without noise; noise of the study's recipe (variance 1000, 50 readings) is added so that the
diagnosis has repeats to estimate it from. Four states are diagnosed, five others are held out.

`python -m benchmarks.real.published [--picture FILE]` prints the tables of docs/gap/published.md.
"""

import csv
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection

from benchmarks.data import SHARED
from benchmarks.main_program import run_main
from benchmarks.real.geometry import placing_effects
from benchmarks.real.telling import picture_path, show_causes
from femlib.arrays import FloatArray
from femlib.wing import WingTwin, reduced_twin, tapered_wing, uav_twin
from octmip.gap import CHAIN, Addition, AugmentedTwin, Campaign, Diagnosis, diagnose
from octmip.gap.inference.linear_model import whole_difference
from octmip.gap.twins import CachedTwin
from octmip.twin import Effect, Twin

TABLE = SHARED / "uav" / "strains.csv"
STATES = ((0, 0), (40, 0), (0, 40), (60, 60))
HELD_OUT = ((80, 0), (0, 80), (20, 20), (40, 60), (60, 20))
REPEATS, VARIANCE = 50, 1000.0
WEAK = ("g18", "g24")
"""Inside the damage regions, and known not to fit (docs/wing.md)."""
INSIDE = ("g17", "g18", "g23", "g24")
GLOBAL = ("modulus", "skin_thickness", "lift_distribution", "torsion", "planform")
"""Effects of the wing that another model of it may contain."""
N_ROUNDS = 3


def means() -> dict[tuple[int, int, float], FloatArray]:
    """Return the table's mean strains (24,) [microstrain] by state in per cent and load factor."""
    with TABLE.open() as file:
        return {
            (int(row["mu1_percent"]), int(row["mu2_percent"]), float(row["load_factor"])): np.array(
                [float(row[f"strain_{k:02d}"]) for k in range(1, 25)]
            )
            for row in csv.DictReader(file)
            if row["kind"] == "mean"
        }


def campaign(states: Sequence[tuple[int, int]] = STATES, without: tuple[str, ...] = (), seed: int = 0) -> Campaign:
    """Return the table's means in some states at load factors 2 and 3, with noise, some gauges left out."""
    rng = np.random.default_rng(seed)
    rows = []
    for (mu1, mu2, load), mean in means().items():
        if (mu1, mu2) in states:
            noise = rng.standard_normal((REPEATS, 24)) * np.sqrt(VARIANCE)
            rows += [(f"{mu1}-{mu2}", load, (mu1, mu2), reading) for reading in mean + noise]
    n = len(rows)
    names = [f"g{k:02d}" for k in range(1, 25)]
    kept = [k for k, name in enumerate(names) if name not in without]
    return Campaign(
        gauges=tuple(names[k] for k in kept),
        parameters=("mu1", "mu2"),
        test=tuple(row[0] for row in rows),
        load_factor=np.array([row[1] for row in rows]),
        states=np.array([row[2] for row in rows]) / 100.0,
        readings=np.array([row[3] for row in rows])[:, kept],
        time=np.full(n, np.nan),
        temperature=np.full(n, np.nan),
    )


def held_out_gap(twin: Twin, gauges: tuple[str, ...]) -> float:
    """Return the rms distance [microstrain] of a twin from the table's held-out states at load factor 3."""
    order = [twin.gauges.index(name) for name in gauges]
    table = means()
    apart = [(twin.predict({"mu1": a / 100, "mu2": b / 100}, 3.0) - table[a, b, 3.0])[order] for a, b in HELD_OUT]
    return float(np.sqrt(np.mean(np.square(apart))))


def best_of_library(found: Diagnosis) -> tuple[Addition, ...]:
    """Return the effects of the library's best hypothesis, even where the diagnosis says unexplained.

    By evidence: beside the unknown its probability may be too small for a float.
    """
    best = max((h for h in found.posterior.judged if not h.has_unknown), key=lambda h: h.fit.log_factor, default=None)
    if best is None:
        return ()
    candidates = best.model.inputs.candidates
    own = zip(best.members, best.fit.size.tolist(), strict=True)
    parts = [Addition(candidates[j].effect, candidates[j].place, size) for j, size in own]
    return tuple(sorted(parts, key=lambda part: part.effect.name in CHAIN))


def rounds_of(
    readings: Campaign, twin: Twin, library: Mapping[str, Effect], run: Campaign | None = None
) -> Iterator[tuple[Diagnosis, tuple[Addition, ...], AugmentedTwin]]:
    """Diagnose, add the best of the library, diagnose again; yield diagnosis, additions and the twin with all of them.

    A commissioning run calibrates the first round; the augmented twin carries the calibration on.
    """
    current: Twin = twin
    known = run
    for _ in range(N_ROUNDS):
        found = diagnose(readings, CachedTwin(current), library, commissioning=known)
        additions = best_of_library(found)
        if not additions:
            return
        inputs = found.posterior.model.inputs
        current, known = AugmentedTwin(current, additions, partial(whole_difference, inputs, 1.0)), None
        yield found, additions, current


def picture(models: Mapping[str, WingTwin], path: str) -> None:
    """Draw the residuals of the 24 gauges on each wing, pristine and with mu1 = 60 %, mu2 = 20 %."""
    table = means()
    figure, axes = plt.subplots(2, 2, figsize=(11, 5.2), layout="constrained", sharex=True, sharey=True)
    drawn = []
    for column, (mu1, mu2) in enumerate(((0, 0), (60, 20))):
        for row, (title, model) in enumerate(models.items()):
            used = [k for k, name in enumerate(model.gauges) if name not in INSIDE]
            apart = table[mu1, mu2, 3.0] - model.predict({"mu1": mu1 / 100, "mu2": mu2 / 100}, 3.0)
            drawn.append(_residuals(axes[row, column], model, apart))
            rms = np.sqrt(np.mean(apart[used] ** 2))
            axes[row, column].set_title(f"{title}, mu1 = {mu1} %, mu2 = {mu2} %: {rms:.0f} rms of 20", fontsize=9)
    axes[0, 0].invert_yaxis()
    for axis in axes[-1]:
        axis.set_xlabel("span [m]")
    figure.colorbar(drawn[-1], ax=axes, label="table - twin at load factor 3 [microstrain]", shrink=0.8)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _residuals(axis: Axes, twin: WingTwin, apart: FloatArray) -> PathCollection:
    """Draw the planform and the gauges coloured by their residuals (n_gauges,) [microstrain]."""
    places, outline = twin.gauge_positions, twin.outline
    assert places is not None
    assert outline is not None
    axis.plot(outline[:, 1], outline[:, 0], color="#8c959f")
    return axis.scatter(
        places[:, 1], places[:, 0], c=apart, cmap="RdBu_r", vmin=-200, vmax=200, s=90, edgecolor="black"
    )


def libraries(twin: WingTwin) -> dict[str, Mapping[str, Effect]]:
    """Return the library as it is, and what two models of one wing may differ by: no measuring chain, no damage."""
    shared: dict[str, Effect] = {name: twin.effects[name] for name in GLOBAL}
    return {
        "the whole library": {**CHAIN, **twin.effects},
        "what models differ by": {**shared, **placing_effects(twin.wing)},
    }


def main() -> None:
    """Print where, which, how far for all gauges, 22 and 20; a run of pristine rows; both libraries in rounds."""
    path = picture_path(__doc__)
    whole = uav_twin()
    twin = CachedTwin(whole)
    for title, without in (("24 gauges", ()), ("22 gauges", WEAK), ("20 gauges", INSIDE)):
        print(f"\n{title}")
        found = diagnose(campaign(without=without), twin)
        show_where(found)
        show_causes(found)
    print("\n20 gauges, calibrated by the pristine rows")
    pristine = campaign(STATES[:1], INSIDE, seed=1)
    found = diagnose(campaign(STATES[1:], INSIDE), twin, commissioning=pristine)
    show_where(found)
    show_causes(found)
    for title, library in libraries(whole).items():
        for words, states, run in (("", STATES, None), (", pristine rows known", STATES[1:], pristine)):
            show_rounds(f"{title}{words}", whole, library, campaign(states, INSIDE), run)
    if path:
        picture({"tapered_wing": reduced_twin(tapered_wing()), "uav_wing": whole}, path)


def show_rounds(
    title: str, whole: WingTwin, library: Mapping[str, Effect], readings: Campaign, run: Campaign | None
) -> None:
    """Print what each round adds and the held-out gap after it."""
    before = held_out_gap(whole, readings.gauges)
    print(f"\n20 gauges, {title}: {before:.1f} microstrain on held-out states")
    for n_rounds, (found, additions, current) in enumerate(rounds_of(readings, whole, library, run)):
        if run is not None and n_rounds == 0:
            alone = AugmentedTwin(whole, (), current.difference)
            print(f"  calibration alone: {held_out_gap(alone, readings.gauges):.1f} microstrain")
        added = ", ".join(f"{a.effect.name} {a.place} {a.size:.3g} {a.effect.unit}" for a in additions)
        gap = held_out_gap(current, readings.gauges)
        print(f"  {added or 'no cause'}: {gap:.1f} microstrain; {_rest(found)}", flush=True)


def _rest(found: Diagnosis) -> str:
    if found.shrinkage is None:
        return "nothing to close: no effect is the likeliest answer"
    return f"chance of the rest {found.shrinkage.p_after:.1g}"


def show_where(found: Diagnosis) -> None:
    """Print the gap and the gauges and states that hold most of it."""
    where = found.where
    gauges = ", ".join(f"{p.name} {p.gap:+.0f} ({100 * p.share:.0f} %)" for p in where.gauges[:5])
    tests = ", ".join(f"{p.name} {100 * p.share:.0f} %" for p in where.tests)
    print(f"  {where.rms:.1f} microstrain rms; {gauges}; by state {tests}")


if __name__ == "__main__":
    run_main(main)
