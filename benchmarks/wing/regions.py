"""Which of the 28 regions is damaged, and how much: what gauges can see, by Bayes, by proven trees, by placed gauges.

    python -m benchmarks.wing.regions [--refinement 0.35] [--seconds 240]
        [--picture FILE.png] [--confusion FILE.png]

One region at a time loses 20, 40, 60 or 80 %, or none does. A reading is the strain at load factor 3 with the paper's
noise, over the load factor. The Bayes limit knows the mean of every state; a proven tree of depth 3 has eight leaves.
"Placed" gauges are the D-optimal 24 of the 82 for all 28 damages (`octmip.sensing.by_information`). The confusion is
which region either rule takes for which.
"""

import argparse
from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.main_program import run_main
from femlib.wing import Wing, uav_wing
from femlib.wing.damage import damage_library
from octmip import ClassCosts, Limits, Problem, certify, solve
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import by_information
from octmip.trees.solution import Solution
from octmip.trees.tree import predict

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
LEVELS = (0.2, 0.4, 0.6, 0.8)
LOAD_FACTOR, NOISE_SD = 3.0, float(np.sqrt(1000.0))
N_GAUGES, DEPTH = 24, 3
N_FRESH = 200
"""Fresh readings of each state on which limits and trees are counted."""
Named = Callable[[Floats], Ints]
"""Readings (n, n_gauges) -> the region (n,) that a rule names."""
SAMPLES = 6
"""Training readings of each damaged state."""
N_NAMES = 29
"""No damage, and each region."""
SHOWN = 0.05
"""Least share of the readings of one region for which a pair stands in the table."""


def main() -> None:
    """Print the tables, and draw what is asked for."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.regions", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.35)
    parser.add_argument("--seconds", type=float, default=240.0, help="limit of each proof of which region")
    parser.add_argument("--picture", help="PNG file of what the gauges see")
    parser.add_argument("--confusion", help="PNG file of which region is taken for which")
    options = parser.parse_args()
    wing = uav_wing(candidates=True, refinement=options.refinement, regions=damage_library())
    means = state_means(wing)
    installed = np.arange(N_GAUGES)
    columns = {"installed": installed, "placed": placed(wing, means)}
    names = [wing.gauges.names[k] for k in columns["placed"]]
    print(f"placed: {', '.join(names)}", flush=True)
    rows, whole, found = region_rows(wing, means, columns), [], dict[str, Floats]()
    for kind, chosen in columns.items():
        own = means[:, chosen]
        solution = named_by_tree(own, SAMPLES, options.seconds)
        assert solution.tree is not None
        found[f"Bayes's rule, {kind}"] = confusion(own, partial(bayes, own))
        found[f"tree, {kind}"] = confusion(own, partial(predict, solution.tree))
        whole.append(which_row(kind, solution, *list(found.values())[-2:]))
        print(whole[-1], flush=True)
    amounts = amount_rows(wing, means[:, columns["placed"]], columns["placed"], SAMPLES)
    pairs = pair_rows(found, ["none", *(own.name for own in wing.regions)])
    tables = {"seen": rows, "which": whole, "amount": amounts, "confusion": pairs}
    for name, table in tables.items():
        print(f"\nregions-{name}\n{markdown_table(table)}", flush=True)
    if options.picture:
        picture(rows).savefig(options.picture, dpi=110)
    if options.confusion:
        confusion_picture(found, ["none", *(own.name for own in wing.regions)]).savefig(options.confusion, dpi=100)


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


def named_by_tree(means: Floats, samples: int, seconds: float) -> Solution:
    """Return the proven tree of depth 3 that names the region."""
    region, _ = labels()
    readings, state = drawn(means, samples, 0)
    problem = Problem(readings, region[state], depth=DEPTH)
    solution = solve(problem, "exact", Limits(seconds=seconds))
    certify(problem, solution)
    return solution


def which_row(kind: str, solution: Solution, by_bayes: Floats, by_tree: Floats) -> dict[str, object]:
    """Return how often that tree and Bayes's rule name the region, each region as often, of their confusions."""
    return {
        "gauges": kind,
        "tree wrong, training": round(solution.objective),
        "bound": round(float(solution.bound), 1),
        "tree names the region %": round(100 * float(np.diag(by_tree).mean()), 1),
        "Bayes names the region %": round(100 * float(np.diag(by_bayes).mean()), 1),
        "regions the tree can name": int((by_tree[:, 1:].sum(axis=0) > 0).sum()),
    }


def confusion(means: Floats, name: Named) -> Floats:
    """Return the share (29, 29) of the fresh readings of each region (rows) that are named so (columns)."""
    region, _ = labels()
    readings, state = drawn(means, N_FRESH, 1)
    counts = np.zeros((N_NAMES, N_NAMES))
    np.add.at(counts, (region[state], name(readings)), 1.0)
    return np.asarray(counts / counts.sum(axis=1, keepdims=True))


def pair_rows(found: dict[str, Floats], names: list[str]) -> list[dict[str, object]]:
    """Return true and named region of every pair that is frequent by some rule, with the shares [%]."""
    rows = []
    frequent = np.max(list(found.values()), axis=0) >= SHOWN
    for true, named in np.argwhere(frequent):
        row: dict[str, object] = {"true": names[true], "named": names[named]}
        rows.append(row | {f"{kind} %": round(100 * float(table[true, named]), 1) for kind, table in found.items()})
    return rows


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


def confusion_picture(found: dict[str, Floats], names: list[str]) -> Figure:
    """Return the four tables as pictures, a region's readings in each row."""
    figure = Figure(figsize=(13, 13), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True, sharey=True)
    for axis, (kind, table) in zip(axes.T.ravel(), found.items(), strict=True):
        image = axis.imshow(100 * table, cmap="Blues", vmin=0, vmax=100)
        axis.set(title=kind, xlabel="named", ylabel="damaged")
        axis.set_xticks(range(N_NAMES), names, rotation=90, fontsize=7)
        axis.set_yticks(range(N_NAMES), names, fontsize=7)
    figure.colorbar(image, ax=axes, shrink=0.5, label="% of a region's readings")
    return figure


if __name__ == "__main__":
    run_main(main)
