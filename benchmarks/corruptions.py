"""What the fuzzers of proof logs share: ways to corrupt the lines of a log or the data, and the table of outcomes."""

import dataclasses
from collections import Counter
from collections.abc import Sequence

import numpy as np

from benchmarks.tables import Line
from octmip.problem import Problem

HEADER = 5  # lines


def body_row(rng: np.random.Generator, lines: list[str]) -> int:
    """Return a row below the header."""
    return int(rng.integers(HEADER, len(lines) - 1))


def character(rng: np.random.Generator, lines: list[str]) -> None:
    """Replace one character."""
    row = int(rng.integers(len(lines) - 1))
    column = int(rng.integers(max(len(lines[row]), 1)))
    lines[row] = lines[row][:column] + chr(rng.integers(32, 127)) + lines[row][column + 1 :]


def delete(rng: np.random.Generator, lines: list[str]) -> None:
    """Leave out a line of the body."""
    del lines[body_row(rng, lines)]


def repeat(rng: np.random.Generator, lines: list[str]) -> None:
    """Repeat a line of the body."""
    row = body_row(rng, lines)
    lines.insert(row, lines[row])


def swap(rng: np.random.Generator, lines: list[str]) -> None:
    """Exchange two lines of the body."""
    one, other = body_row(rng, lines), body_row(rng, lines)
    lines[one], lines[other] = lines[other], lines[one]


def cut_short(rng: np.random.Generator, lines: list[str]) -> None:
    """Leave out the end."""
    del lines[body_row(rng, lines) :]


def number(rng: np.random.Generator, lines: list[str]) -> None:
    """Change a whole number a little."""
    row = body_row(rng, lines)
    tokens = lines[row].split(" ")
    place = int(rng.integers(len(tokens)))
    if tokens[place].isdigit():
        tokens[place] = str(max(0, int(tokens[place]) + int(rng.integers(-2, 3))))
    lines[row] = " ".join(tokens)


def changed_data(rng: np.random.Generator, problem: Problem) -> Problem:
    """Return the problem with one feature value, label or weight changed."""
    features, codes, weights = problem.features.copy(), problem.codes.copy(), problem.weights.copy()
    row = int(rng.integers(problem.n_samples))
    name = str(rng.choice(["features", "codes", "weights"]))
    if name == "features":
        features[row, int(rng.integers(problem.n_features))] = rng.normal()
    elif name == "codes":
        codes[row] = (codes[row] + 1) % problem.n_classes
        codes = problem.codes if len(set(codes.tolist())) < 2 else codes
    else:
        weights[row] += 1.0
    labels = np.array(problem.class_names)[codes]
    return dataclasses.replace(problem, features=features, labels=labels, weights=weights)


def summary(lines: Sequence[Line]) -> str:
    """Return what became of the corruptions."""
    counts = sum((Counter(line["counts"]) for line in lines), Counter[str]())
    wrong = [seed for line in lines for seed in line["wrong"]]
    rows = [f"| {kind} | {counts[kind]} |" for kind in sorted(counts)]
    head = [
        f"{sum(counts.values())} corruptions, {len(wrong)} wrongly accepted {wrong}.",
        "",
        "| what: outcome | count |",
    ]
    return "\n".join([*head, "|---|---|", *rows])


# Any one of these is done to the lines of a log.
LINE_CHANGES = (character, delete, repeat, swap, cut_short, number)
