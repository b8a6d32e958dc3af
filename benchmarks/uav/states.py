"""The trees that name one of the paper's 25 states: one tree of 25 labels, and mu2's tree under every leaf of mu1's.

    python -m benchmarks.uav.states [--strains ../shared/uav/strains.csv] [--out results/uav/states]

Both learn from the study's readings (seed 0). Trees of depth 3 are proven; the 25 labels need depth 5 at least, where
the tree is one of local search. Each is written as a tree file and as a C function.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.main_program import run_main
from benchmarks.uav.bayes import class_posterior
from femlib.dataset import Dataset, Recipe, build_dataset, published_strains, simulated_strains
from femlib.wing import uav_wing
from octmip import Limits, Problem, Solution, certify, solve
from octmip.formats.tree_file import record_tree, write_tree_file
from octmip.input.files import write_bytes
from octmip.interfaces.report.markdown import markdown_table
from octmip.monitor import Library, ModelSelector, ParameterTree
from octmip.monitor.export import c_source
from octmip.trees.prediction import predict
from octmip.trees.reached import without_empty_sides
from octmip.trees.solution import Stop
from octmip.trees.tree import depth as depth_of
from octmip.trees.tree import n_splits

Ints = NDArray[np.int64]
LABELS = ("mu1", "mu2")
DEPTH_OF_ONE = 3
"""Depth of a tree of one damage, and of the proven one of 25 labels."""
DEPTHS = (DEPTH_OF_ONE, 5, 6)
"""Depths of the trees of 25 labels; five is the least that has a leaf for each."""


@dataclass(frozen=True, slots=True)
class StateTree:
    """A tree that names the state, with its training problem and the claim of its solver."""

    name: str
    problem: Problem
    solution: Solution
    note: str


def main() -> None:
    """Print the table, and write the trees."""
    parser = argparse.ArgumentParser(prog="benchmarks.uav.states", description=__doc__)
    parser.add_argument("--strains", help="published strain table (CSV); default: strains of femlib's wing")
    parser.add_argument("--out", default="results/uav/states", help="folder of tree files and C functions")
    parser.add_argument("--seconds", type=float, default=60.0, help="limit of each solve")
    options = parser.parse_args()
    means = published_strains(options.strains) if options.strains else simulated_strains(uav_wing())
    data = build_dataset(means, Recipe())
    trees = [one_tree(data, depth, options.seconds) for depth in DEPTHS] + [composed(data, options.seconds)]
    rows = [row_of(data, one) for one in trees] + [bayes_row(data)]
    print(markdown_table(rows))
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    for one in trees:
        export(folder, one)


def names_of(data: Dataset) -> tuple[str, ...]:
    """Return the 25 states in words."""
    return tuple(f"mu1={mu1} mu2={mu2}" for mu1, mu2 in data.states_percent.tolist())


def state_problem(data: Dataset, depth: int) -> Problem:
    """Return the training problem whose classes are the states: misnamed readings as objective, as in the paper."""
    features, states = data.features[data.is_train], np.array(names_of(data))[data.states[data.is_train]]
    return Problem(
        features, states, depth=depth, feature_names=data.gauges, class_names=names_of(data), target_name="state"
    )


def one_tree(data: Dataset, depth: int, seconds: float) -> StateTree:
    """Return the tree of 25 labels of a depth."""
    problem = state_problem(data, depth)
    is_provable = depth == DEPTH_OF_ONE
    solution = solve(problem, "exact" if is_provable else "search", limits=Limits(seconds=seconds))
    certify(problem, solution)
    proof = "proven" if solution.is_optimal else f"bound {solution.bound:.0f}" if is_provable else "local search"
    return StateTree(f"25 labels, depth {depth}", problem, solution, proof)


def composed(data: Dataset, seconds: float) -> StateTree:
    """Return mu2's tree under every leaf of mu1's, both of least errors, without ends that no reading reaches."""
    trees, proofs = [], []
    for label in LABELS:
        target = getattr(data, label)[data.is_train]
        problem = Problem(data.features[data.is_train], target, depth=DEPTH_OF_ONE, feature_names=data.gauges)
        solution = solve(problem, "exact", limits=Limits(seconds=seconds))
        certify(problem, solution)
        assert solution.tree is not None
        trees.append(ParameterTree(label, solution.tree, tuple(map(float, problem.class_names)), data.gauges))
        proofs.append(solution.is_optimal)
    library = Library(
        LABELS, data.states_percent.astype(float), data.gauges, data.mean_features, np.full(len(data.gauges), 1.0)
    )
    tree = without_empty_sides(ModelSelector.of_trees(library, trees).tree, data.features[data.is_train])
    problem = state_problem(data, depth_of(tree))
    solution = Solution(
        tree, problem.objective(tree), -np.inf, Stop.FINISHED, 0.0, 0, "composed", solution.version, solution.seed
    )
    certify(problem, solution)
    note = "both trees proven" if all(proofs) else "not both proven"
    return StateTree("mu2's tree under mu1's leaves", problem, solution, note)


def row_of(data: Dataset, one: StateTree) -> dict[str, object]:
    """Return the errors of a tree on its readings and on unseen ones."""
    assert one.solution.tree is not None
    told = predict(one.solution.tree, data.features)
    row: dict[str, object] = {
        "tree": one.name,
        "depth": depth_of(one.solution.tree),
        "leaves": n_splits(one.solution.tree) + 1,
        "proof": one.note,
        "training wrong %": round(100 * float((told != data.states)[data.is_train].mean()), 1),
    }
    return row | errors_of(data, told)


def errors_of(data: Dataset, told: Ints) -> dict[str, object]:
    """Return what told states (n,) are off on the unseen readings."""
    unseen = ~data.is_train
    apart = np.abs(data.states_percent[told] - data.states_percent[data.states])[unseen]
    return {
        "unseen wrong %": round(100 * float((told != data.states)[unseen].mean()), 1),
        "unseen MAE mu1 %": round(float(apart[:, 0].mean()), 2),
        "unseen MAE mu2 %": round(float(apart[:, 1].mean()), 2),
    }


def bayes_row(data: Dataset) -> dict[str, object]:
    """Return the same of Bayes's rule, which knows the mean of every state."""
    states = np.arange(len(data.mean_features))
    told = class_posterior(data.features, data.mean_features, data.noise_sd, states, len(states)).argmax(axis=1)
    row: dict[str, object] = {"tree": "Bayes's rule (no tree)", "depth": "", "leaves": "", "proof": ""}
    row["training wrong %"] = round(100 * float((told != data.states)[data.is_train].mean()), 1)
    return row | errors_of(data, told)


def export(folder: Path, one: StateTree) -> None:
    """Write a tree as a tree file and as a C function."""
    assert one.solution.tree is not None
    name = "composed" if one.solution.solver == "composed" else f"labels_25_depth_{one.problem.depth}"
    write_tree_file(folder / f"{name}.json", record_tree(one.problem, one.solution, target_column="state"))
    source = c_source(one.solution.tree, one.problem.feature_names, one.problem.class_names, name="state")
    write_bytes(folder / f"{name}.c", source.encode())


if __name__ == "__main__":
    run_main(main)
