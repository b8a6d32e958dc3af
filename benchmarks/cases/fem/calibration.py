"""The wing against what was published of the real one and of the authors' model: strains, stiffness, frequencies."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from benchmarks.data import SHARED, tip_test
from benchmarks.tables import Line
from benchmarks.wing.against_published import SEEDS, frequencies, least_errors
from femlib.dataset import MeanStrains, published_strains, simulated_strains
from femlib.wing import Wing, uav_wing

Floats = NDArray[np.float64]
FOLDER = SHARED / "uav"

FREQUENCY_REFINEMENT = 0.5


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line per gauge, then lines on increments, all states, best possible errors, stiffness and frequencies."""
    wing = uav_wing()
    ours, theirs = simulated_strains(wing), published_strains(FOLDER / "strains.csv")
    yield from gauges(ours, theirs)
    yield from distances(ours, theirs)
    yield tip(wing)
    yield from frequencies(uav_wing(refinement=FREQUENCY_REFINEMENT))


def gauges(ours: MeanStrains, theirs: MeanStrains) -> Iterator[Line]:
    """Yield strains and increments [microstrain] at load factor 3, published and ours, gauge by gauge."""
    for number, name in enumerate(theirs.gauges):
        line: Line = {"size": f"gauge {name}", "seed": 0, "gauge": name}
        line["is_usable"] = bool(theirs.is_usable[number])
        for key, (mu1, mu2) in {"pristine": (0, 0), "mu1": (80, 0), "mu2": (0, 80)}.items():
            line[key] = [float(_change(means, mu1, mu2)[number]) for means in (theirs, ours)]
        yield line


def distances(ours: MeanStrains, theirs: MeanStrains) -> Iterator[Line]:
    """Yield the figures of the distance between two libraries of mean strains."""
    usable = theirs.is_usable
    ratio = 100.0 * (_change(ours, 0, 0) / _change(theirs, 0, 0) - 1.0)[usable]
    yield _figure("pristine strain, 20 gauges", "%", _rms(ratio), float(np.abs(ratio).max()))
    for name, levels in {"mu1": (80, 0), "mu2": (0, 80)}.items():
        wanted, error = _change(theirs, *levels), _change(ours, *levels) - _change(theirs, *levels)
        for which, largest in (("20", np.abs(wanted[usable]).max()), ("24", np.abs(wanted).max())):
            share = 100.0 * error[usable] / largest
            most = float(np.abs(share).max())
            yield _figure(f"increment of {name} = 80 %, of the largest of the {which}", "%", _rms(share), most)
    error = (ours.strain_microstrain - theirs.strain_microstrain)[:, usable]
    yield _figure("all 25 states, 20 gauges", "microstrain", _rms(error), float(np.abs(error).max()))
    for name, means in (("published", theirs), ("ours", ours)):
        wrong = np.array([least_errors(means, seed) for seed in SEEDS])
        for k, target in enumerate(("mu1", "mu2")):
            low, high = float(wrong[:, k].min()), float(wrong[:, k].max())
            yield _figure(f"least possible errors on {target}, {name}, seeds 0 to 2", "%", low, high)


def tip(wing: Wing) -> Line:
    """Return the tip stiffness beside the published model's and the one measured [N/mm]."""
    theirs = {"published": tip_test("model").stiffness, "measured": tip_test("measurements").stiffness}
    return {"size": "tip stiffness", "seed": 0, "unit": "N/mm", **theirs, "ours": wing.tip_stiffness() / 1000.0}


def _change(means: MeanStrains, mu1: int, mu2: int) -> Floats:
    """Return the pristine strains (n_gauges,), or what a damage adds to them."""
    pristine, damaged = (
        means.strain_microstrain[(means.states_percent == levels).all(axis=1)][0] for levels in ([0, 0], [mu1, mu2])
    )
    return np.asarray(damaged - pristine if mu1 or mu2 else pristine)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _figure(size: str, unit: str, low: float, high: float) -> Line:
    return {"size": size, "seed": 0, "unit": unit, "figures": [low, high]}


def summary(lines: Sequence[Line]) -> str:
    """Return the tables of docs/wing.md: figures (rms and most; of seeds least and most), then gauges."""
    table = ["| figure | value |", "|---|---|"]
    for line in lines:
        if "figures" in line:
            low, high = line["figures"]
            table.append(f"| {line['size']} | {low:.3g} and {high:.3g} {line['unit']} |")
        elif "measured" in line:
            values = [f"{name} {_words(line[name])}" for name in ("measured", "published", "ours")]
            table.append(f"| {line['size']} [{line['unit']}] | {'; '.join(values)} |")
    table += ["", "| gauge | pristine: published, ours | mu1 = 80 % adds | mu2 = 80 % adds |", "|---|---|---|---|"]
    for line in lines:
        if "gauge" in line:
            cells = [f"{line[key][0]:.0f}, {line[key][1]:.0f}" for key in ("pristine", "mu1", "mu2")]
            mark = "" if line["is_usable"] else " (left out)"
            table.append(f"| {line['gauge']}{mark} | " + " | ".join(cells) + " |")
    return "\n".join(table)


def _words(values: float | Sequence[float]) -> str:
    return f"{values:.3f}" if isinstance(values, float) else ", ".join(f"{value:.2f}" for value in values)


def picture(lines: Sequence[Line], path: Path) -> None:
    """Draw the residual of each gauge: pristine in percent, both increments in microstrain."""
    rows = [line for line in lines if "gauge" in line]
    figure, axes = plt.subplots(3, 1, figsize=(9, 7), sharex=True, layout="constrained")
    titles = {
        "pristine": "pristine strain, ours over published - 1 [%]",
        "mu1": "increment of mu1 = 80 %, ours - published [microstrain]",
        "mu2": "increment of mu2 = 80 %, ours - published [microstrain]",
    }
    for axis, (key, title) in zip(axes, titles.items(), strict=True):
        theirs, ours = (np.array([row[key][k] for row in rows]) for k in (0, 1))
        residual = 100.0 * (ours / theirs - 1.0) if key == "pristine" else ours - theirs
        usable = np.array([row["is_usable"] for row in rows])
        axis.bar(range(len(rows)), residual, color=np.where(usable, "#2b6ca3", "#cccccc"))
        limit = 1.15 * np.abs(residual[usable]).max()
        axis.set(title=title, ylim=(-limit, limit))
        axis.axhline(0.0, color="black", linewidth=0.8)
    axes[-1].set_xticks(range(len(rows)), [row["gauge"] for row in rows], rotation=60)
    axes[-1].set_xlabel("gauge (grey: left out of the study; bars may leave the frame)")
    figure.savefig(path, dpi=110)
    plt.close(figure)
