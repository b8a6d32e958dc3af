"""The readers of octmip's files, and the commands that read them, as the fuzz of files tries them."""

import contextlib
import functools
import importlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

import numpy as np
import pandas as pd

from benchmarks.readers.file_reader import Reader, run
from benchmarks.readers.mangled_arrays import mangled_parquet
from benchmarks.readers.mangling import Generator, mangled_bytes, mangled_csv, mangled_json, mangled_tokens, pick
from benchmarks.readers.monitoring import make_campaign, make_selector, read_gap, read_selector
from benchmarks.readers.regression import make_regression, regression_command
from benchmarks.recordings import make_recording, read_recording
from octmip.errors import OctmipError
from octmip.formats.table import read_costs, read_sensors, read_table
from octmip.formats.tree_file import read_tree_file, record_tree, write_tree_file
from octmip.formats.tree_schema import CONTENT, FORMAT, VERSION
from octmip.input.files import read_json_object
from octmip.interfaces.cli.samples.training import targets_of
from octmip.trees.answer.certificate import certify
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.search import local_search
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.nodes.tree import predict, predict_values, splits
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem

# Trees.


def problem_of(number: int) -> Problem:
    """Return a small problem: odd numbers have words for classes, weights, costs, groups and sensors."""
    rng = np.random.default_rng([90, number])
    x = rng.normal(size=(24, 3)).round(3)
    if number % 2 == 0:
        return Problem(x, rng.integers(0, 3, 24), depth=2, feature_names=("a", "b", "c"))
    return Problem(
        x,
        rng.choice(["low", "high"], 24),
        depth=2,
        split="hyperplane",
        split_size=2,
        weights=rng.random(24).round(2) + 0.1,
        loss=ClassCosts(np.array([[0, 2.5], [1, 0]])),
        sensor_of_feature=["left", "left", "right"],
        sensor_cost={"left": 1.5, "right": 2},
        sensor_budget=4,
        allowed_splits=[["a", "b"], ["c"]],
        feature_names=("a", "b", "c"),
    )


def trained_on(number: int) -> Problem:
    """Return the same problem; every fourth lacks readings."""
    problem = problem_of(number)
    if number % 4:
        return problem
    is_lost = np.random.default_rng([91, number]).random(problem.samples.features.shape) < 0.3
    return problem.replace(features=np.where(is_lost, np.nan, problem.samples.features))


def make_tree(number: int, folder: Path) -> None:
    """Write a tree file and the table that it was trained on."""
    problem = trained_on(number)
    solution = branch_and_bound(problem) if problem.shape.split == "axis" else local_search(problem)
    weights = None if number % 2 == 0 else "w"
    write_tree_file(folder / "tree.json", record_tree(problem, solution, "y", weights))
    write_table(problem, folder / "table.csv")


def write_table(problem: Problem, path: Path) -> None:
    """Write the samples of a problem."""
    frame = pd.DataFrame(problem.samples.features, columns=list(problem.samples.feature_names))
    frame["y"], frame["w"] = problem.samples.targets, problem.samples.weights
    frame.to_csv(path, index=False) if path.suffix == ".csv" else frame.to_parquet(path)


HOSTILE_SAMPLES = np.array([[0.0, 0.0, 0.0], [1e308, -1e308, 1e308], [5e-324, -5e-324, 0.1], [-1e300, 1e300, -0.0]])


def read_tree(rng: Generator, folder: Path) -> None:
    """Read a tree file, predict by it, and certify it or say why not."""
    agree_with_schema(folder / "tree.json")
    file = read_tree_file(folder / "tree.json")
    samples = np.resize(HOSTILE_SAMPLES, (4, len(file.feature_names)))
    if all(split.missing is not None for split in splits(file.tree)):
        samples[0] = np.nan
    if file.class_names:
        assert predict(file.tree, samples).max() < len(file.class_names)
    else:
        with np.errstate(over="ignore", invalid="ignore"), contextlib.suppress(OctmipError):
            predict_values(file.tree, samples)
    with contextlib.suppress(OctmipError):
        table = read_table(folder / "table.csv")
        labels = targets_of(file.loss, table, file.target_column or "y", file.class_names)
        weights = table.numbers([file.weights_column])[:, 0] if file.weights_column else None
        certify(file.problem(table.numbers(file.feature_names), labels, weights), file.solution)


class Validator(Protocol):
    """A checker of JSON values against a schema, as `jsonschema` makes it."""

    def is_valid(self, instance: object) -> bool:
        """Return whether a value is of the schema."""
        ...


@functools.cache
def _validator() -> Validator:
    schema = json.loads((Path(importlib.import_module("octmip").__file__ or "").parent / SCHEMA).read_text())
    validator: Validator = importlib.import_module("jsonschema").Draft202012Validator(schema)
    return validator


SCHEMA = "interfaces/schemas/tree.schema.json"


class DisagreementError(Exception):
    """The published schema and the reader differ on a value's kind or range."""


def agree_with_schema(path: Path) -> None:
    """Compare what the schema says of a tree file with what the reader says of its values' kinds and ranges."""
    content = read_json_object(path)
    try:
        CONTENT.take(content)
        takes = (
            content.get("format") == FORMAT
            and type(content.get("version")) is not bool
            and content["version"] == VERSION
        )
    except (OctmipError, KeyError):
        takes = False
    if _validator().is_valid(content) != takes:
        raise DisagreementError(f"the reader {'takes' if takes else 'refuses'} what the schema does not")


BROAD, ANEW = ("--split-size", 2), ("--method", "search", "--seconds", 1)


def tree_command(rng: Generator, folder: Path) -> None:
    """Give a tree file to one of the commands that read one."""
    tree, table = folder / "tree.json", folder / "table.csv"
    has_planes = tree.is_file() and b"hyperplane" in tree.read_bytes()
    anew = (*BROAD, *ANEW) if has_planes else ANEW
    out = folder / pick(rng, ("p.html", "p.md", "p.txt"))
    commands = (
        ("report", tree),
        ("report", tree, "--out", out),
        ("certify", tree, table),
        ("certify", tree, table, "--json"),
        ("predict", tree, table, "--proba", "--label", "y"),
        ("predict", tree, table, "--json"),
        ("solve", table, "--label", "y", "--depth", 2, "--features", "a,b,c", "--incumbent", tree, *anew),
    )
    if rng.random() < 0.03:
        run("report", tree, "--out", folder / "p.svg")
    run(*pick(rng, commands))


# Tables, and what is said beside them.


def make_table(suffix: str) -> Callable[[int, Path], None]:
    """Return what writes a table and a tree for it."""

    def make(number: int, folder: Path) -> None:
        make_tree(number, folder)
        write_table(trained_on(number), folder / f"data{suffix}")

    return make


def read_data(name: str) -> Callable[[Generator, Path], None]:
    """Return what reads a table and takes every column for numbers and for labels."""

    def read(rng: Generator, folder: Path) -> None:
        table = read_table(folder / name)
        for column in table.columns:
            for take in (lambda c: table.numbers([c]), table.labels):
                with contextlib.suppress(OctmipError):
                    take(column)
        with contextlib.suppress(OctmipError):
            Problem(table.numbers(["a", "b"]), table.labels("y"), depth=1)

    return read


def make_raw(number: int, folder: Path) -> None:
    """Write a table with text, missing readings and an index in the form of the number, and the tree of `solve`."""
    rng = np.random.default_rng([91, number])
    frame = pd.DataFrame(
        {"id": range(24), "a": rng.normal(size=24).round(2), "colour": rng.choice(["red", "blue"], 24)}
    )
    frame.loc[::5, "a"] = np.nan
    frame["y"] = rng.choice(["low", "high"], 24)
    frame.to_csv(folder / "raw.csv.gz", index=False)
    frame.to_csv(folder / "raw.tsv", index=False, sep="\t")
    words = ("--label", "y", "--depth", 1, "--index", "id", "--holdout", 0.25, "--out", folder / "raw.json")
    run("solve", folder / "raw.csv.gz", *words)


def raw_command(rng: Generator, folder: Path) -> None:
    """Give a raw table in one of its forms and its tree file to one of the commands."""
    tree, data = folder / "raw.json", folder / pick(rng, ("raw.csv.gz", "raw.tsv"))
    solve = ("solve", data, "--label", "y", "--depth", 1, "--seconds", 1)
    commands = (
        ("certify", tree, data),
        ("predict", tree, data, "--label", "y", "--proba"),
        ("predict", tree, data, "--index", "id", "--json"),
        (*solve, "--index", "id", "--missing", "drop-rows"),
        (*solve, "--drop", "id", "--categories", "order", "--drop-unlabelled", "--holdout", 0.3),
        (*solve, "--features", "a,colour", "--test", data),
    )
    run(*pick(rng, commands))


def table_command(name: str) -> Callable[[Generator, Path], None]:
    """Return what gives a table to one of the commands."""

    def read(rng: Generator, folder: Path) -> None:
        data, tree = folder / name, folder / "tree.json"
        solve = ("solve", data, "--label", "y", "--depth", 1, "--seconds", 1)
        commands = (
            (*solve, "--out", folder / "new.json"),
            (*solve, "--weights", "w", "--method", "search", "--json"),
            (*solve, "--features", "a,b", "--method", "cart"),
            ("certify", tree, data),
            ("predict", tree, data, "--label", "y"),
            ("frontier", data, "--label", "y", "--depth", 1, "--over", "depth", "--seconds", 1, "--json"),
        )
        run(*pick(rng, commands))

    return read


def make_words(number: int, folder: Path) -> None:
    """Write a table with its costs and sensors."""
    write_table(problem_of(2 * number), folder / "data.csv")
    (folder / "costs.csv").write_text("true,0,1,2\n0,0,1,2.5\n1,10,0,1\n2,1,1,0\n")
    rows = ("sensor,cost", "a,1", "b,2.5", "c,0") if number % 2 else ("feature,sensor,cost", "a,l,1", "b,l,1", "c,r,2")
    (folder / "sensors.csv").write_text("\n".join(rows) + "\n")


def words_command(name: str, option: str) -> Callable[[Generator, Path], None]:
    """Return what solves a problem with a file of costs or sensors, and reads the file by itself."""

    def read(rng: Generator, folder: Path) -> None:
        readers: Mapping[str, Callable[[], object]] = {
            "--costs": lambda: read_costs(folder / name, [0, 1, 2]),
            "--sensor-cost": lambda: read_sensors(folder / name, ["a", "b", "c"]),
        }
        if option in readers and rng.random() < 0.5:
            readers[option]()
            return
        budget = ("--budget", 2) if option == "--sensor-cost" else ()
        solve = ("solve", folder / "data.csv", "--label", "y", "--features", "a,b,c", "--depth", 1, "--seconds", 1)
        run(*solve, option, folder / name, *budget)

    return read


# Proof logs.


def make_log(number: int, folder: Path) -> None:
    """Write the log of a problem: of two-feature trees for odd numbers."""
    problem = problem_of(2 * number)
    if number % 2 == 0:
        solution = branch_and_bound(problem, options=ExactOptions(proof=folder / "proof.log"))
    else:
        names = ("a", "b")
        problem = Problem(
            problem.samples.features[:, :2],
            problem.samples.targets,
            depth=1,
            split="hyperplane",
            split_size=2,
            feature_names=names,
        )
        solution = two_feature_branch_and_bound(problem, options=ExactOptions(proof=folder / "proof.log"))
    write_tree_file(folder / "tree.json", record_tree(problem, solution, "y"))
    write_table(problem, folder / "table.csv")


def read_log(rng: Generator, folder: Path) -> None:
    """Check a log, or have it checked by the command."""
    if rng.random() < 0.1:
        run("certify", folder / "tree.json", folder / "table.csv", "--proof", folder / "proof.log")
    file, table = read_tree_file(folder / "tree.json"), read_table(folder / "table.csv")
    problem = file.problem(table.numbers(file.feature_names), table.labels("y"), None)
    assert check_proof(problem, folder / "proof.log").bound <= file.solution.objective


OCTMIP = {
    "tree file": Reader(make_tree, "tree.json", mangled_json, read_tree),
    "tree file, commands": Reader(make_tree, "tree.json", mangled_json, tree_command),
    "table .csv": Reader(make_table(".csv"), "data.csv", mangled_csv, read_data("data.csv")),
    "table .csv, commands": Reader(make_table(".csv"), "data.csv", mangled_csv, table_command("data.csv")),
    "table .parquet": Reader(make_table(".parquet"), "data.parquet", mangled_parquet, read_data("data.parquet")),
    "table .parquet, commands": Reader(
        make_table(".parquet"), "data.parquet", mangled_parquet, table_command("data.parquet")
    ),
    "raw table .csv.gz": Reader(make_raw, "raw.csv.gz", mangled_bytes, raw_command),
    "raw table .tsv": Reader(make_raw, "raw.tsv", mangled_csv, raw_command),
    "tree file of a raw table": Reader(make_raw, "raw.json", mangled_json, raw_command),
    "costs": Reader(make_words, "costs.csv", mangled_csv, words_command("costs.csv", "--costs")),
    "sensors": Reader(make_words, "sensors.csv", mangled_csv, words_command("sensors.csv", "--sensor-cost")),
    "proof log": Reader(make_log, "proof.log", mangled_tokens, read_log),
    "selector": Reader(make_selector, "selector.json", mangled_json, read_selector),
    "recording": Reader(make_recording, "run", mangled_bytes, read_recording),
    "campaign": Reader(make_campaign, "campaign.csv", mangled_csv, read_gap),
    "regression tree": Reader(make_regression, "tree.json", mangled_json, read_tree),
    "regression tree, commands": Reader(make_regression, "tree.json", mangled_json, regression_command),
}
