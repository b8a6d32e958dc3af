"""From arguments and a table to the Problem that they ask."""

import argparse
from dataclasses import dataclass
from typing import Any, Literal

from octmip.errors import DataError
from octmip.formats.files import read_text
from octmip.formats.table import Table, read_costs, read_sensors, read_table
from octmip.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """A problem and the columns that it was read from."""

    problem: Problem
    label_column: str
    weights_column: str | None


def ask(arguments: argparse.Namespace) -> Question:
    """Return the problem of a command line.

    Raises
    ------
    DataError
        a file does not hold what was announced.
    ProblemError
        no tree can answer.
    """
    table = read_table(arguments.data)
    labels = table.labels(arguments.label)
    names = _feature_columns(table, arguments)
    features = table.numbers(names)
    settings: dict[str, Any] = {}
    if arguments.weights:
        settings["weights"] = table.numbers([arguments.weights], "weight")[:, 0]
    if arguments.sensor_cost:
        sensors = read_sensors(arguments.sensor_cost, names)
        settings |= {"sensor_of_feature": sensors.of_feature, "sensor_cost": dict(sensors.cost)}
    if arguments.allowed_splits:
        settings["allowed_splits"] = _groups(arguments.allowed_splits)
    if arguments.costs:
        classes = sorted(set(labels.tolist()))
        settings |= {"costs": read_costs(arguments.costs, classes), "class_names": classes}
    problem = Problem(
        features,
        labels,
        depth=arguments.depth,
        split=_split_kind(arguments),
        split_size=arguments.split_size,
        leaf_size=arguments.leaf_size,
        leaf_penalty=arguments.leaf_penalty,
        sensor_budget=arguments.budget,
        integer_normals=arguments.integer_normals,
        feature_names=tuple(names),
        **settings,
    )
    return Question(problem, arguments.label, arguments.weights)


def _feature_columns(table: Table, arguments: argparse.Namespace) -> list[str]:
    taken = [arguments.label, arguments.weights]
    if arguments.features is None:
        names = [name for name in table.columns if name not in taken]
        if not names:
            raise DataError(f"{table.name} has no column beside {arguments.label!r}; expected at least one feature")
        return names
    names = [name.strip() for name in arguments.features.split(",")]
    for name in names:
        table.column(name, "feature")
        if name in taken or names.count(name) > 1:
            use = "label or weight" if name in taken else "twice a feature"
            raise DataError(f"--features names {name!r}, which is {use}; name other columns, each once")
    return names


def _groups(path: str) -> list[list[str]]:
    """Return the groups of a text file: one a line, features separated by commas."""
    lines = [line for line in read_text(path).splitlines() if line.strip()]
    return [[name.strip() for name in line.split(",")] for line in lines]


def _split_kind(arguments: argparse.Namespace) -> Literal["axis", "hyperplane"]:
    if arguments.split:
        return "axis" if arguments.split == "axis" else "hyperplane"
    wants_hyperplanes = (arguments.split_size or 1) > 1 or arguments.integer_normals is not None
    return "hyperplane" if wants_hyperplanes else "axis"
