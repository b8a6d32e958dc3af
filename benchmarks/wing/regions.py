"""Which of the 28 regions is damaged, and how much: what gauges can see, by Bayes, by proven trees, by placed gauges.

    python -m benchmarks.wing.regions [--refinement 0.35] [--samples 8] [--seconds 120] [--tables FOLDER]
        [--picture FILE.png]

One region at a time loses 20, 40, 60 or 80 %, or none does. A reading is the strain at load factor 3 with the paper's
noise, over the load factor. The Bayes limit knows the mean of every state; a proven tree of depth 3 has eight leaves.
"Placed" gauges are the D-optimal 24 of the 82 for all 28 damages (`octmip.sensing.by_information`).
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.main_program import run_main
from femlib.wing import Wing, uav_wing
from femlib.wing.damage import damage_library
from octmip import ClassCosts, Limits, Problem, certify, solve
from octmip.formats.files import write_bytes
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import by_information
from octmip.trees.tree import predict

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
LEVELS = (0.2, 0.4, 0.6, 0.8)
LOAD_FACTOR, NOISE_SD = 3.0, float(np.sqrt(1000.0))
N_GAUGES, DEPTH = 24, 3
N_FRESH = 200
"""Fresh readings of each state on which limits and trees are counted."""


def main() -> None:
    """Print and write."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.regions", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.35)
    parser.add_argument("--samples", type=int, default=8, help="training readings of each damaged state")
    parser.add_argument("--seconds", type=float, default=120.0, help="limit of each proof of which region")
    parser.add_argument("--tables", help="folder for CSV files")
    parser.add_argument("--picture", help="PNG file to write")
    options = parser.parse_args()
    wing = uav_wing(candidates=True, refinement=options.refinement, regions=damage_library())
    means = state_means(wing)
    installed = np.arange(N_GAUGES)
    columns = {"installed": installed, "placed": placed(wing, means)}
    names = [wing.gauges.names[k] for k in columns["placed"]]
    print(f"placed: {', '.join(names)}", flush=True)
    rows, whole = region_rows(wing, means, columns), []
    for kind, chosen in columns.items():
        whole.append(which_row(kind, wing, means[:, chosen], chosen, options.samples, options.seconds))
        print(whole[-1], flush=True)
    amounts = amount_rows(wing, means[:, columns["placed"]], columns["placed"], options.samples)
    for name, table in {"regions-seen": rows, "regions-which": whole, "regions-amount": amounts}.items():
        print(f"\n{name}\n{markdown_table(table)}", flush=True)
        if options.tables:
            Path(options.tables).mkdir(parents=True, exist_ok=True)
            write_bytes(Path(options.tables) / f"{name}.csv", pd.DataFrame(table).to_csv(index=False).encode())
    if options.picture:
        picture(rows).savefig(options.picture, dpi=110)


def state_means(wing: Wing) -> Floats:
    """Return the strains (1 + 28 x 4, n_gauges) per unit of load: sound, then each region's levels."""
    n = len(wing.parameters)
    rows = [wing.strains_microstrain(np.zeros((1, n)), 1.0)]
    for k in range(n):  # region by region: a state's ports are then few
        rows.append(wing.strains_microstrain(np.outer(LEVELS, np.eye(n)[k]), 1.0))
    return np.concatenate(rows)


def labels() -> tuple[Ints, Ints]:
    """Return the region (0: none) and the level (0: none) of each state."""
    n_levels = len(LEVELS)
    region = np.concatenate([[0], 1 + np.repeat(np.arange(28), n_levels)])
    return region, np.concatenate([[0], np.tile(1 + np.arange(n_levels), 28)])


def placed(wing: Wing, means: Floats) -> Ints:
    """Return the D-optimal gauges (24,) for the slopes of all damages at 20 %, usable ones alone."""
    usable = np.flatnonzero(wing.gauges.is_usable)
    slopes = ((means[1 :: len(LEVELS)] - means[0]) / LEVELS[0]).T[usable]
    names = [wing.gauges.names[k] for k in usable]
    blank = Problem(np.zeros((2, len(names))), np.arange(2), depth=1, feature_names=tuple(names))
    design = by_information(blank, N_GAUGES, slopes)
    return np.sort([wing.gauges.names.index(name) for name in design.sensors])


def drawn(means: Floats, n: int, seed: int) -> tuple[Floats, Ints]:
    """Return n readings of each state, of the sound one four times as many (m, n_gauges), and their states (m,)."""
    counts = np.full(len(means), n)
    counts[0] *= len(LEVELS)
    state = np.repeat(np.arange(len(means)), counts)
    noise = np.random.default_rng(seed).normal(0.0, NOISE_SD / LOAD_FACTOR, (len(state), means.shape[1]))
    return means[state] + noise, state


def bayes(means: Floats, readings: Floats) -> Ints:
    """Return the most probable region (n,), each region and none as likely, its levels too."""
    region, _ = labels()
    apart = readings[:, None, :] - means[None]
    logs = -0.5 * (apart**2).sum(axis=2) / (NOISE_SD / LOAD_FACTOR) ** 2
    logs -= logs.max(axis=1, keepdims=True)
    weights = np.exp(logs) / np.bincount(region)[region]
    sums = np.stack([weights[:, region == k].sum(axis=1) for k in range(29)], axis=1)
    return np.asarray(sums.argmax(axis=1))


def region_rows(wing: Wing, means: Floats, columns: dict[str, Ints]) -> list[dict[str, object]]:
    """Return what each set of gauges sees of each region: the distance d of 80 % from sound, and Bayes's recall."""
    region, level = labels()
    rows: list[dict[str, object]] = [
        {"region": own.name, "surface": own.surface, "eta": f"{own.eta_min:.2f} to {own.eta_max:.2f}"}
        for own in wing.regions
    ]
    for kind, chosen in columns.items():
        own = means[:, chosen]
        readings, state = drawn(own, N_FRESH, 1)
        told = bayes(own, readings)
        for k, row in enumerate(rows):
            far = own[(region == k + 1) & (level == len(LEVELS))][0] - own[0]
            row[f"d at 80 %, {kind}"] = round(float(np.linalg.norm(far)) / (NOISE_SD / LOAD_FACTOR), 1)
            mine = region[state] == k + 1
            row[f"Bayes names it %, {kind}"] = round(100 * float((told[mine] == k + 1).mean()), 1)
    return rows


def which_row(kind: str, wing: Wing, means: Floats, chosen: Ints, samples: int, seconds: float) -> dict[str, object]:
    """Return the proven tree of depth 3 that names the region, beside the Bayes limit, on fresh readings."""
    region, _ = labels()
    readings, state = drawn(means, samples, 0)
    names = [wing.gauges.names[k] for k in chosen]
    problem = Problem(readings, region[state], depth=DEPTH, feature_names=tuple(names))
    solution = solve(problem, "exact", Limits(seconds=seconds))
    certify(problem, solution)
    fresh, true = drawn(means, N_FRESH, 1)
    assert solution.tree is not None
    predicted = predict(solution.tree, fresh)
    balance = 1.0 / np.bincount(region[true])[region[true]] / 29.0
    return {
        "gauges": kind,
        "rows": len(readings),
        "tree wrong, training": round(solution.objective),
        "bound": round(float(solution.bound), 1),
        "tree names the region %": round(100 * float(balance @ (predicted == region[true])), 1),
        "Bayes names the region %": round(100 * float(balance @ (bayes(means, fresh) == region[true])), 1),
        "regions the tree can name": len(set(predicted.tolist()) - {0}),
    }


def amount_rows(wing: Wing, means: Floats, chosen: Ints, samples: int) -> list[dict[str, object]]:
    """Return for each region the proven tree of depth 3 that tells its level, where the region is known."""
    region, level = labels()
    names, rows = [wing.gauges.names[k] for k in chosen], []
    for k, own in enumerate(wing.regions):
        states = np.flatnonzero((region == k + 1) | (region == 0))
        readings, state = drawn(means[states], samples, 10 + k)
        costs = np.abs(np.subtract.outer([0.0, *LEVELS], [0.0, *LEVELS]))
        true = level[states][state]
        problem = Problem(readings, true, depth=DEPTH, loss=ClassCosts(100.0 * costs), feature_names=tuple(names))
        solution = solve(problem, "exact", Limits(seconds=20.0))
        certify(problem, solution)
        assert solution.tree is not None
        fresh, fresh_state = drawn(means[states], N_FRESH, 50 + k)
        error = 100.0 * costs[level[states][fresh_state], predict(solution.tree, fresh)]
        row: dict[str, object] = {"region": own.name, "surface": own.surface, "rows": len(readings)}
        row |= {"training MAE %": round(solution.objective / len(readings), 2)}
        row |= {
            "proven": bool(solution.bound >= solution.objective - 1e-6),
            "MAE on fresh readings %": round(error.mean(), 2),
        }
        rows.append(row)
    return rows


def picture(rows: list[dict[str, object]]) -> Figure:
    """Return how far each region's damage moves the gauges, and how often Bayes's rule names it."""
    figure = Figure(figsize=(11, 5.2), layout="constrained")
    axes = figure.subplots(2, 1, sharex=True)
    places = np.arange(len(rows))
    colours = {"installed": "#9aa3ad", "placed": "#c2410c"}
    for k, (kind, colour) in enumerate(colours.items()):
        for axis, what in zip(axes, ("d at 80 %", "Bayes names it %"), strict=True):
            axis.bar(
                places + 0.4 * k - 0.2,
                [float(str(row[f"{what}, {kind}"])) for row in rows],
                0.4,
                color=colour,
                label=kind,
            )
    axes[0].set(ylabel="d of 80 % lost, one reading", yscale="log")
    axes[0].axhline(3.0, color="#222222", lw=0.8, ls="--")
    axes[1].set(ylabel="named by Bayes's rule [%]", ylim=(0, 100))
    axes[1].set_xticks(places, [f"{row['region']}\n{str(row['surface'])[:3]}" for row in rows], fontsize=7)
    axes[0].legend(fontsize=8)
    return figure


if __name__ == "__main__":
    run_main(main)
