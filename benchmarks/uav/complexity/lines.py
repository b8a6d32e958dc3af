"""The lines of the complexity study: those that are kept, and the others, run and kept."""

from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby
from pathlib import Path

from joblib import Parallel, delayed

from benchmarks.tables import Line
from benchmarks.uav.complexity.cells import Cell, effort_of, run_cells
from benchmarks.uav.kept import keep, kept_lines, key_of
from femlib.dataset import MeanStrains, Recipe


def run(
    cells: Sequence[Cell],
    means: MeanStrains,
    restarts: int,
    n_jobs: int,
    kept: Path | None = None,
    recipe: Recipe = Recipe(),  # noqa: B008 (frozen)
) -> dict[Cell, Line]:
    """Return the line of every cell, those in the file `kept` read from there, the others run and added to it."""
    keys = {cell: _key(cell, means, recipe, restarts) for cell in cells}
    known = kept_lines(kept)
    lines = {cell: known[key] for cell, key in keys.items() if key in known}
    columns = [list(group) for _, group in groupby((c for c in cells if c not in lines), key=_column)]
    work = Parallel(n_jobs=n_jobs, return_as="generator")(
        delayed(run_cells)(column, means, recipe, restarts) for column in columns
    )
    for column, found in zip(columns, work, strict=True):
        for cell, line in zip(column, found, strict=True):
            lines[cell] = line
            keep(kept, keys[cell], line)
    return {cell: lines[cell] for cell in cells}


def _column(cell: Cell) -> tuple[object, ...]:
    """Return what cells run one after the other share; with two gauges not much, as the pair takes seconds to find."""
    rest = () if cell.gauge_set == "two" else (cell.split_size, cell.objective)
    return cell.seed, cell.label, cell.gauge_set, *rest


def _key(cell: Cell, means: MeanStrains, recipe: Recipe, restarts: int) -> str:
    method, options = effort_of(cell, restarts)
    return key_of(means, asdict(cell), asdict(recipe), method, options.given())
