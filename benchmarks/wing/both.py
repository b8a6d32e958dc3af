"""All wings beside the published table: figures as Markdown, a picture and region 2's answers gauge by gauge.

python -m benchmarks.wing.both [--refinement R] [--picture FILE]
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from benchmarks.data import SHARED, tip_test, vibration_test
from benchmarks.main_program import run_main
from benchmarks.tables import Line
from benchmarks.wing.calculix import WINGS
from femlib.assembly import matrix_modes, point_masses
from femlib.dataset import MeanStrains, build_dataset, published_strains, simulated_strains
from femlib.wing import Wing
from octmip.interfaces.report.markdown import markdown_table

Floats = NDArray[np.float64]
LEVELS = (20, 40, 60, 80)
MASS_PLACES: Mapping[str, Mapping[float, str]] = {
    "none": {},
    "servos at 0.40 and 0.65, pitot at 0.80 of the span": {
        0.40: "mass_servo_1",
        0.65: "mass_servo_2",
        0.80: "mass_pitot",
    },
    "servos at 0.35 and 0.75, pitot at the tip": {0.35: "mass_servo_1", 0.75: "mass_servo_2", 1.0: "mass_pitot"},
}
"""Span fractions of the published point masses; their places were not published."""
SEEDS = (0, 1, 2)
ANSWERS = 3.0
"""Least answer of a gauge [microstrain] to 80 % of region 2; the others answer by 1.1 at most."""
STYLES = {"published table": "ko", "uav_wing": "C0-", "built_wing": "C2-.", "tapered_wing": "C1--"}


def main() -> None:
    """Print the table, draw the picture."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.both", description=__doc__)
    parser.add_argument("--refinement", type=float, default=1.0)
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    table = published_strains(SHARED / "uav" / "strains.csv")
    wings = {name: make(refinement=options.refinement) for name, make in WINGS.items()}
    means = {"published table": table, **{name: simulated_strains(wing) for name, wing in wings.items()}}
    print("\n".join(figures(means, wings)))
    print(f"\n{markdown_table(answering(means))}")
    if options.picture is not None:
        picture(means, options.picture)


def figures(means: Mapping[str, MeanStrains], wings: Mapping[str, Wing]) -> Iterator[str]:
    """Yield the lines of the table."""
    table, usable = means["published table"], means["published table"].is_usable
    yield "| figure, 20 gauges | " + " | ".join(wings) + " |\n|---|" + "---|" * len(wings)
    pristine = [100.0 * (change(means[name], 0, 0) / change(table, 0, 0) - 1.0)[usable] for name in wings]
    yield _row("pristine strain", [f"{_rms(e):.1f} % rms, {np.abs(e).max():.1f} % at most" for e in pristine])
    for number, name in enumerate(("mu1", "mu2")):
        cells = []
        for wing in wings:
            errors = []
            for level in LEVELS:
                damage = (level, 0) if number == 0 else (0, level)
                wanted = change(table, *damage)[usable]
                errors.append(100.0 * _rms(change(means[wing], *damage)[usable] - wanted) / np.abs(wanted).max())
            cells.append(" / ".join(f"{e:.1f}" for e in errors) + " %")
        yield _row(f"increments of {name} at 20 / 40 / 60 / 80 %, of the largest of the 20", cells)
    apart = [(means[name].strain_microstrain - table.strain_microstrain)[:, usable] for name in wings]
    yield _row("all 25 states", [f"{_rms(e):.0f} microstrain rms, {np.abs(e).max():.0f} at most" for e in apart])
    best = {name: np.array([least_errors(mean, seed) for seed in SEEDS]) for name, mean in means.items()}
    for number, target in enumerate(("mu1", "mu2")):
        words = {name: f"{b[:, number].min():.1f} to {b[:, number].max():.1f} %" for name, b in best.items()}
        own = words["published table"]
        yield _row(f"best possible errors on {target}, three seeds (table: {own})", [words[name] for name in wings])
    stiffness = [f"{wing.tip_stiffness() / 1000.0:.3f} N/mm" for wing in wings.values()]
    yield _row(f"tip stiffness (published model {tip_test('model').stiffness:.3f} N/mm)", stiffness)
    first, second = vibration_test().measured
    found = [list(frequencies(wing)) for wing in wings.values()]
    for k, line in enumerate(found[0]):
        cells = [", ".join(f"{f:.2f}" for f in lines[k]["ours"]) + " Hz" for lines in found]
        yield _row(f"frequencies (measured {first:.2f}, {second:.2f}), point masses: {line['places']}", cells)


def change(means: MeanStrains, mu1: int, mu2: int) -> Floats:
    """Return the undamaged strains (n_gauges,), or what a damage adds to them [microstrain]."""
    sound, damaged = (
        means.strain_microstrain[(means.states_percent == levels).all(axis=1)][0] for levels in ([0, 0], [mu1, mu2])
    )
    return np.asarray(damaged - sound if mu1 or mu2 else sound)


def answering(means: Mapping[str, MeanStrains]) -> list[dict[str, object]]:
    """Return what mu2 = 80 % adds to each gauge outside the regions that answers it [microstrain], with errors."""
    table = means["published table"]
    wanted, rows = change(table, 0, 80), list[dict[str, object]]()
    for k in np.flatnonzero(table.is_usable & (np.abs(wanted) > ANSWERS)).tolist():
        row: dict[str, object] = {"gauge": table.gauges[k], "published": round(float(wanted[k]), 1)}
        for name in list(means)[1:]:
            found = float(change(means[name], 0, 80)[k])
            row |= {name: round(found, 1), f"{name}, error %": round(100.0 * (found / float(wanted[k]) - 1.0))}
        rows.append(row)
    return rows


def frequencies(wing: Wing) -> Iterator[Line]:
    """Yield the two lowest frequencies [Hz] without point masses and with the published ones at assumed places."""
    test, shells = vibration_test(), wing.structure.shells
    for places, names in MASS_PLACES.items():
        masses = _masses(wing, {eta: test.masses[name] for eta, name in names.items()})
        mass = shells.mass() + point_masses(shells.mesh, masses)
        modes = matrix_modes(shells.stiffness(), mass, wing.structure.supports, 6)
        ours = [modes[k].frequency for k in _flapping(wing, [mode.shape for mode in modes])[:2]]
        yield {"places": places, "ours": ours}


def _flapping(wing: Wing, shapes: Sequence[Floats]) -> list[int]:
    """Return the modes whose tip moves up more than fore and aft."""
    tip_node = int(wing.grid.upper[-1, wing.grid.spar_column])
    moves = [np.abs(shape[6 * tip_node : 6 * tip_node + 3]) for shape in shapes]
    return [k for k, move in enumerate(moves) if move[2] > move[0]]


def _masses(wing: Wing, masses: Mapping[float, float]) -> dict[int, float]:
    """Return the masses at the nodes of the spar's upper cap next to their span fractions."""
    rows = {eta: int(np.abs(wing.grid.eta - eta).argmin()) for eta in masses}
    return {int(wing.grid.upper[row, wing.grid.spar_column]): masses[eta] for eta, row in rows.items()}


def least_errors(means: MeanStrains, seed: int) -> list[float]:
    """Return the share of rows [%] that the rule which knows the 25 means gets wrong, for mu1 and mu2."""
    data = build_dataset(means, seed=seed)
    square = np.square(data.features[:, None] - data.mean_features[None]).sum(axis=2)
    likely = np.exp(-0.5 * (square - square.min(axis=1, keepdims=True)) / data.noise_sd**2)
    wrong = []
    for label in data.states_percent.T:
        levels = np.unique(label)
        posterior = np.stack([likely[:, label == level].sum(axis=1) for level in levels], axis=1)
        wrong.append(100.0 * float(np.mean(levels[posterior.argmax(axis=1)] != label[data.states])))
    return wrong


def picture(means: Mapping[str, MeanStrains], path: Path) -> None:
    """Draw strains and increments of each gauge: the table's as dots, the wings' as lines."""
    usable = means["published table"].is_usable
    names = [n for n, u in zip(means["published table"].gauges, usable, strict=True) if u]
    figure, axes = plt.subplots(3, 1, figsize=(9, 8), sharex=True, layout="constrained")
    titles = {(0, 0): "undamaged, load factor 3", (80, 0): "mu1 = 80 % adds", (0, 80): "mu2 = 80 % adds"}
    for axis, (damage, title) in zip(axes, titles.items(), strict=True):
        for name, mean in means.items():
            axis.plot(change(mean, *damage)[usable], STYLES[name], label=name, markersize=4, linewidth=1.2)
        axis.set(title=title, ylabel="microstrain")
        axis.grid(alpha=0.3)
    axes[0].legend()
    axes[-1].set_xticks(range(len(names)), names, rotation=60)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _row(name: str, cells: list[str]) -> str:
    return f"| {name} | " + " | ".join(cells) + " |"


if __name__ == "__main__":
    run_main(main)
