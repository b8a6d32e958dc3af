"""The shells against the standard problems: ratio to the published answer, by elements a side."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import product

import numpy as np

from benchmarks.oracles.shell_problems import (
    BEAM_SHAPES,
    CONVERGING,
    curved_beam,
    raasch_hook,
    random_shape,
    straight_beam,
    twisted_beam,
)
from benchmarks.tables import Line
from femlib.errors import MeshError, SolveError

WRONG = 0.05
"""Error of the work beyond which a panel that was accepted counts as wrong."""
SIZES = (4, 8, 16, 32)
DIRECTIONS = {"u": "extension", "v": "in plane", "w": "out of plane", "x": "twist"}


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each problem and size, and for each beam of MacNeal and Harder."""
    yield from plates_and_shells(SIZES)
    yield from beams()
    yield from strips((1, 2, 4, 8, 16))
    yield panels(200, 16)


def plates_and_shells(sizes: Sequence[int]) -> Iterator[Line]:
    """Yield the ratio to the published answer of each problem with so many elements a side."""
    for name, problem in CONVERGING.items():
        for n in sizes:
            yield {"size": f"{name}, {n} a side", "seed": 0, "problem": name, "n": n, "ratio": problem(n)}


def beams() -> Iterator[Line]:
    """Yield the ratio to beam theory of each beam of six elements, by the direction of its load."""
    for shape in BEAM_SHAPES:
        ratios = {DIRECTIONS[d]: straight_beam(shape, d) for d in DIRECTIONS}
        yield {"size": f"straight beam, {shape}", "seed": 0, "beam": f"straight, {shape}", "ratios": ratios}


def strips(finer: Sequence[int]) -> Iterator[Line]:
    """Yield the ratio to the published answer of each curved or twisted strip, its mesh so many times finer."""
    problems: dict[str, tuple[int, int, Callable[[int, int], float]]] = {
        "curved beam in its plane": (6, 1, lambda n, m: curved_beam("u", n, m)),
        "curved beam out of its plane": (6, 1, lambda n, m: curved_beam("w", n, m)),
        "Raasch's hook": (9, 1, raasch_hook),
    }
    for thickness, direction in product((0.32, 0.0032), "vw"):
        solve = partial(twisted_beam, thickness, direction)
        problems[f"twisted beam, t {thickness}, {direction}"] = (12, 2, solve)
    for name, (n, m, problem) in problems.items():
        for k in finer:
            mesh = f"{n * k} x {m * k}"
            yield {"size": f"{name}, {mesh}", "seed": 0, "strip": name, "mesh": mesh, "ratio": problem(n * k, m * k)}


def panels(count: int, n: int) -> Line:
    """Return how many of so many random panels on n x n moved elements are right, wrong or refused."""
    rng = np.random.default_rng(7)
    errors: list[float] = []
    for _ in range(count):
        shape = random_shape(rng)
        try:
            coarse, quality = shape(n, rng)
            quality.refuse()
        except (MeshError, SolveError):
            continue
        errors.append(abs(coarse / shape(5 * n // 2, None)[0] - 1.0))
    wrong = sum(error > WRONG for error in errors)
    return {"size": f"{count} random panels", "seed": 7, "panels": count, "errors": errors, "wrong": wrong}


def summary(lines: Sequence[Line]) -> str:
    """Return the tables of docs/wing.md."""
    sizes = sorted({line["n"] for line in lines if "n" in line})
    table = ["| problem | " + " | ".join(map(str, sizes)) + " |", "|" + "---|" * (1 + len(sizes))]
    for name in dict.fromkeys(line["problem"] for line in lines if "n" in line):
        ratios = [line["ratio"] for line in lines if line.get("problem") == name]
        table.append(f"| {name} | " + " | ".join(f"{ratio:.4f}" for ratio in ratios) + " |")
    words = list(DIRECTIONS.values())
    table += ["", "| beam, 6 elements | " + " | ".join(words) + " |", "|" + "---|" * (1 + len(words))]
    for line in lines:
        if "beam" in line:
            cells = [f"{line['ratios'][word]:.3f}" if word in line["ratios"] else "-" for word in words]
            table.append(f"| {line['beam']} | " + " | ".join(cells) + " |")
    table += ["", "| strip | mesh | ratio |", "|---|---|---|"]
    table += [f"| {line['strip']} | {line['mesh']} | {line['ratio']:.3f} |" for line in lines if "strip" in line]
    return "\n".join([*table, "", *(_panels_in_words(line) for line in lines if "panels" in line)])


def _panels_in_words(line: Line) -> str:
    errors = line["errors"]
    found = f"{line['panels']} random panels: {line['panels'] - len(errors)} refused"
    if not errors:
        return found
    sizes = f"median {100 * np.median(errors):.2f} %, most {100 * max(errors):.2f} %"
    return f"{found}; of {len(errors)} accepted {line['wrong']} more than {100 * WRONG:g} % off, {sizes}"
