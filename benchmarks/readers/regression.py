"""Files of regression trees, and the commands that read them, as the fuzz of files tries them."""

from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.readers.file_reader import run
from benchmarks.readers.mangling import Generator, pick
from octmip.formats.tree_file import record_tree, write_tree_file
from octmip.trees.methods.options import SearchOptions
from octmip.trees.question.losses import AbsoluteError, SquaredError
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve

NAMES = ("a", "b", "c")
BROAD = ("--split", "hyperplane", "--leaf-model", "linear", "--seconds", 1)


def make_regression(number: int, folder: Path) -> None:
    """Write a regression tree and the table that it was trained on; odd ones have planes, linear leaves and sensors."""
    rng = np.random.default_rng([92, number])
    features, targets = rng.normal(size=(24, 3)).round(3), rng.normal(size=24).round(2)
    if number % 2:
        problem = Problem(
            features,
            targets,
            depth=2,
            split="hyperplane",
            leaf_model="linear",
            sensor_cost=[1.5, 2, 0],
            sensor_budget=4,
            feature_names=NAMES,
            target_name="y",
            loss=SquaredError(),
        )
    else:
        problem = Problem(features, targets, depth=2, loss=AbsoluteError(), feature_names=NAMES, target_name="y")
    solution = solve(problem, options=SearchOptions(restarts=2 if number % 2 else None))
    write_tree_file(folder / "tree.json", record_tree(problem, solution, "y"))
    frame = pd.DataFrame(features, columns=list(NAMES)).assign(y=targets)
    frame.to_csv(folder / "table.csv", index=False)


def regression_command(rng: Generator, folder: Path) -> None:
    """Give a regression tree to one of the commands that read one."""
    tree, table = folder / "tree.json", folder / "table.csv"
    commands = (
        ("report", tree, table),
        ("certify", tree, table, "--json"),
        ("predict", tree, table, "--json"),
        ("solve", table, "--target", "y", "--depth", 2, "--incumbent", tree, *BROAD),
    )
    run(*pick(rng, commands))
