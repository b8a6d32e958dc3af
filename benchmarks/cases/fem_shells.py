"""The shells against the standard problems: ratio to the published answer, by mesh.

Triangles are those of the same mesh cut along either diagonal: their column has the one farther off.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product

import numpy as np

from benchmarks.shells.case import DIAGONALS, Case
from benchmarks.shells.problems import CONVERGING, LAMINATED, STRIPS, Problem
from benchmarks.shells.random_panels import random_shape
from benchmarks.shells.strips import BEAM_SHAPES, straight_beam
from benchmarks.tables import Line, markdown
from femlib.errors import MeshError, SolveError

WRONG = 0.05
"""Error of the work beyond which a panel that was accepted counts as wrong."""
SEED = 2026
FINE = 48
"""Quadrilaterals a side of the mesh that a panel is judged by."""
SIZES = (4, 8, 16, 32)
FINER = (1, 2, 4, 8)
DIRECTIONS = {"u": "extension", "v": "in plane", "w": "out of plane", "x": "twist"}
Solver = Callable[[Case], float]


def farther(solve: Solver) -> Solver:
    """Return a solver of triangles along either diagonal: the ratio farther from one."""

    def both(case: Case) -> float:
        return max((solve(case.in_triangles(d)) for d in DIAGONALS), key=lambda ratio: abs(ratio - 1.0))

    return both


SOLVERS: Mapping[str, Solver] = {
    "femlib quadrilateral": Case.ratio,
    "femlib triangle": farther(Case.ratio),
}


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each problem, mesh and solver, for each beam of MacNeal and Harder, and for the panels."""
    yield from compared({**CONVERGING, **LAMINATED}, SIZES)
    yield from compared(STRIPS, FINER)
    yield from beams()
    yield panels(200, 16, "quadrilaterals")
    for diagonal in DIAGONALS:
        yield panels(200, 32, diagonal)


def compared(problems: Mapping[str, Problem], sizes: Sequence[int]) -> Iterator[Line]:
    """Yield the ratio to the published answer of each problem, mesh and element."""
    for (name, problem), n in product(problems.items(), sizes):
        case = problem(n)
        mesh = " x ".join(str(k - 1) for k in case.node.shape)
        for solver, solve in SOLVERS.items():
            line = {"size": f"{name}, {mesh}, {solver}", "seed": 0, "problem": name, "n": n, "mesh": mesh}
            yield line | {"elements": case.shells.mesh.n_elements, "solver": solver, "ratio": solve(case)}


def beams() -> Iterator[Line]:
    """Yield the ratio to beam theory of each straight beam of six elements, by the direction of its load."""
    for shape, (letter, word), solver in product(BEAM_SHAPES, DIRECTIONS.items(), SOLVERS):
        name = f"straight beam, {shape}, {word}"
        line = {"size": f"{name}, {solver}", "seed": 0, "beam": f"{shape}, {word}", "solver": solver}
        yield line | {"ratio": SOLVERS[solver](straight_beam(shape, letter))}


def panels(count: int, n: int, kind: str) -> Line:
    """Return how many of so many random panels on n x n moved elements, or twice as many triangles, are right."""
    rng = np.random.default_rng(SEED)
    errors: list[float] = []
    for _ in range(count):
        shape = random_shape(rng)
        try:
            case = shape(n, rng)
            work, quality = (case if kind not in DIAGONALS else case.in_triangles(kind)).judged(is_refined=False)
            quality.refuse()
        except (MeshError, SolveError):
            continue
        errors.append(abs(work / shape(FINE, None).ratio() - 1.0))
    wrong = sum(error > WRONG for error in errors)
    line = {"size": f"{count} random panels, {kind}", "seed": SEED, "panels": count, "n": n, "kind": kind}
    return line | {"errors": errors, "wrong": wrong}


def summary(lines: Sequence[Line]) -> str:
    """Return the tables of docs/results/shells.md."""
    solvers = list(dict.fromkeys(line["solver"] for line in lines if "solver" in line))
    parts = [
        _table(["problem", "mesh"], "problem", lines, solvers),
        _table(["straight beam of 6"], "beam", lines, solvers),
    ]
    return "\n\n".join([*parts, *(_panels_in_words(line) for line in lines if "panels" in line)])


def _table(head: Sequence[str], key: str, lines: Sequence[Line], solvers: Sequence[str]) -> str:
    """Return a row for each problem and mesh, or for each beam, with the ratio of each solver."""
    cells: dict[tuple[str, ...], dict[str, str]] = {}
    for line in lines:
        if key in line:
            label = (line[key], line["mesh"]) if "mesh" in line else (line[key],)
            cells.setdefault(label, {})[line["solver"]] = f"{line['ratio']:.3f}"
    rows = ([*label, *(own.get(name, "") for name in solvers)] for label, own in cells.items())
    return markdown([*head, *solvers], rows)


def _panels_in_words(line: Line) -> str:
    errors = line["errors"]
    found = (
        f"{line['panels']} random panels, {line['kind']}, {line['n']} a side: {line['panels'] - len(errors)} refused"
    )
    if not errors:
        return found
    sizes = f"median {100 * np.median(errors):.2f} %, most {100 * max(errors):.2f} %"
    return f"{found}; of {len(errors)} accepted {line['wrong']} more than {100 * WRONG:g} % off, {sizes}"
