"""Lines that are kept: a run that is repeated, or goes on, does only what is missing.

A line is kept under a key of everything that it depends on: its cell, the mean strains, the recipe, the restarts, and
the native core that searched. After the core is built again nothing old is shown as its work.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby
from pathlib import Path

from joblib import Parallel, delayed

from benchmarks.tables import Line, whole_lines
from benchmarks.uav.complexity.cells import Cell, effort_of, run_cells
from femlib.dataset import MeanStrains, Recipe
from octmip.trees import _native


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
    known = {} if kept is None else _read(kept)
    lines = {cell: known[key] for cell, key in keys.items() if key in known}
    columns = [list(group) for _, group in groupby((c for c in cells if c not in lines), key=_column)]
    work = Parallel(n_jobs=n_jobs, return_as="generator")(
        delayed(run_cells)(column, means, recipe, restarts) for column in columns
    )
    for column, found in zip(columns, work, strict=True):
        for cell, line in zip(column, found, strict=True):
            lines[cell] = line
            if kept is not None:
                with kept.open("a") as file:
                    file.write(json.dumps({"key": keys[cell], **line}) + "\n")
    return {cell: lines[cell] for cell in cells}


def _column(cell: Cell) -> tuple[object, ...]:
    """Return what cells run one after the other share; with two gauges not much, as the pair takes seconds to find."""
    rest = () if cell.gauge_set == "two" else (cell.split_size, cell.objective)
    return cell.seed, cell.label, cell.gauge_set, *rest


def _read(kept: Path) -> dict[str, Line]:
    return {line.pop("key"): line for line in map(json.loads, whole_lines(kept))}


def _key(cell: Cell, means: MeanStrains, recipe: Recipe, restarts: int) -> str:
    sha = hashlib.sha256(Path(_native.__file__).read_bytes())
    sha.update(means.strain_microstrain.tobytes())
    method, options = effort_of(cell, restarts)
    asked = [asdict(cell), asdict(recipe), method, options.given()]
    sha.update(json.dumps(asked, sort_keys=True).encode())
    return sha.hexdigest()
