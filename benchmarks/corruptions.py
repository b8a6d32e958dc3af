"""Shared by the fuzzers of proof logs: ways to corrupt the lines of a log or the data."""

import numpy as np

from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem

Generator = np.random.Generator
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


def raise_claim(rng: np.random.Generator, lines: list[str]) -> None:
    """Raise the claim of an axis-aligned log, and with it the bound of every record that bears it."""
    old = lines[HEADER - 1].split(" ")[1]
    new = str(int(old) + int(rng.integers(1, 3)))
    lines[HEADER - 1] = f"claim {new}"
    for row, line in enumerate(lines):
        if line.startswith("N ") and line.split(" ")[3] == old:
            lines[row] = " ".join([*line.split(" ")[:3], new])


def raise_bound(rng: np.random.Generator, lines: list[str]) -> None:
    """Raise the bound of one record of a log of numbers, and the claim with it where they are the same."""
    row = int(rng.choice([row for row, line in enumerate(lines) if line.startswith("N ")]))
    words = lines[row].split(" ")
    raised = str(max(int(words[3]) + 1, int(int(words[3]) * (1 + float(rng.choice([1e-6, 0.01, 1.0]))))))
    lines[:] = [line.replace(words[3], raised) if line.startswith("claim ") else line for line in lines]
    lines[row] = " ".join([*words[:3], raised])


def changed_data(rng: np.random.Generator, problem: Problem) -> Problem:
    """Return the problem with one feature value (or its being there), target or weight changed."""
    samples = problem.samples
    features, targets, weights = samples.features.copy(), samples.targets.copy(), samples.weights.copy()
    row = int(rng.integers(problem.samples.n_samples))
    name = str(rng.choice(["features", "targets", "weights"]))
    if name == "features":
        can_lack = problem.shape.split == "axis" and isinstance(problem.loss, ClassCosts)
        is_lost = can_lack and rng.random() < 0.3
        features[row, int(rng.integers(problem.samples.n_features))] = np.nan if is_lost else rng.normal()
    elif name == "weights":
        weights[row] += 1.0
    elif isinstance(problem.loss, ClassCosts):
        codes = problem.samples.codes.copy()
        codes[row] = (codes[row] + 1) % problem.samples.n_classes
        targets = np.array(problem.samples.class_names)[codes] if len(set(codes.tolist())) > 1 else targets
    else:
        targets[row] += rng.normal()
    return problem.replace(features=features, targets=targets, weights=weights)


# Any one of these is done to the lines of a log.
LINE_CHANGES = (character, delete, repeat, swap, cut_short, number)
