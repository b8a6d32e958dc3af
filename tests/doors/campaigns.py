"""Campaigns of displays and loggers, and readings as other libraries hold them, at the door of the diagnosis."""

import json
from collections import namedtuple
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from octmip.gap import Recorded, diagnose, function_twin, gathered
from octmip.gap.doors import table_twin
from octmip.interfaces.report.diagnosis.recommendation import recommend
from tests.doors.row import Refused, Row

NAMES = ("tip", "mid", "near")
GAINS = np.array([1.0, 0.4, 0.1])


def beam(parameters: Mapping[str, float], loads: Mapping[str, float]) -> np.ndarray:
    """Return what the beam shows."""
    return GAINS * loads["force"] / parameters["stiffness"]


TWIN = function_twin(
    beam,
    dict.fromkeys(NAMES, "mm"),
    {"stiffness": (100.0, 70.0, 130.0, "N/mm")},
    ["force"],
)
Blocks = dict[float, Any]


def told(blocks: Blocks) -> list[str]:
    """Return the causes, channels to repair and channels to widen that a diagnosis names; those left out count too."""
    found = diagnose(gathered(TWIN, [Recorded(rows, {"force": force}) for force, rows in blocks.items()]), TWIN)
    sentence = recommend(found)
    words = [word for word in ("Repair", "Widen") if word.lower() in sentence.lower()]
    return [*found.which[0].effects, *words, *sorted(set(NAMES) - set(found.noise.gauges))]


def shown(step: float | Sequence[float], forces: Sequence[float], repeats: int, sd: float = 0.003) -> Blocks:
    """Return what displays show of a sound beam."""
    rng = np.random.default_rng(0)
    rows = {f: GAINS * f / 100.0 + sd * rng.standard_normal((repeats, 3)) for f in forces}
    return {f: np.round(values / step) * step for f, values in rows.items()}


def tared(blocks: Blocks) -> Blocks:
    """Return the readings with exact zeros where nothing is applied."""
    return {force: rows * (force > 0.0) for force, rows in blocks.items()}


def held(blocks: Blocks, force: float) -> Blocks:
    """Return the readings with one row repeated at a force."""
    return blocks | {force: np.repeat(blocks[force][:1], len(blocks[force]), axis=0)}


def always(blocks: Blocks, gauge: int, change: Callable[[np.ndarray], Any]) -> Blocks:
    """Return the readings with one gauge's changed."""
    found = {force: rows.copy() for force, rows in blocks.items()}
    for rows in found.values():
        rows[:, gauge] = change(rows[:, gauge])
    return found


def _in(case: Blocks) -> Callable[[Path], Blocks]:
    return lambda folder: case


FORCES = (0.0, 20.0, 40.0, 60.0)
DISPLAYS: dict[str, tuple[str, Blocks, list[str]]] = {
    "all repeats equal at 0": ("display, 0.01 mm", shown(0.01, FORCES, 4), []),
    "two loads": ("display, 0.01 mm", shown(0.01, (0.0, 50.0), 5), []),
    "all repeats equal": ("dial gauge, 0.05 mm", shown(0.05, FORCES, 3, sd=0.0005), []),
    "a coarse channel beside fine ones": ("two loggers", shown((0.02, 1e-4, 1e-4), FORCES, 5), []),
    "exact zeros": ("tared logger, 0.0001 mm", tared(shown(1e-4, FORCES, 4)), []),
    "two repeats of each load": ("display, 0.01 mm", shown(0.01, FORCES, 2), []),
    "two repeats, a pair repeated": ("logger that holds a sample", held(shown(1e-4, FORCES, 2), 60.0), []),
    "exact zeros, three repeats": ("tared logger, 0.0001 mm", tared(shown(1e-4, (0.0, 60.0), 3)), []),
    "exact zeros, twelve repeats": ("tared logger, 0.0001 mm", tared(shown(1e-4, FORCES, 12)), []),
    "a row repeated": ("logger that holds a sample", held(shown(1e-4, FORCES, 6), 40.0), []),
    "the greatest load repeated": ("logger that holds a sample", held(shown(1e-4, FORCES, 6), 60.0), []),
    "stuck": ("display, 0.01 mm", always(shown(0.01, FORCES, 4), 0, lambda own: 0.2), ["Repair", "tip"]),
    "clipped": ("display, 0.01 mm", always(shown(0.01, FORCES, 6), 0, lambda own: np.minimum(own, 0.3)), ["Widen"]),
}


def fine() -> dict[float, np.ndarray]:
    """Return readings in doubles, as a library holds them."""
    return shown(1e-9, FORCES, 8)


def _masked(values: np.ndarray) -> np.ma.MaskedArray:
    lost = np.zeros(values.shape, dtype=bool)
    lost[:6, 0] = True
    return np.ma.masked_array(np.where(lost, -1.0, values), lost)


def _structured(values: np.ndarray) -> np.ndarray:
    return np.rec.fromarrays(values.T[::-1], names=list(NAMES[::-1]))


def _pandas(values: np.ndarray) -> Any:
    frame = pytest.importorskip("pandas").DataFrame(values, columns=list(NAMES)).astype("Float64")
    frame.loc[:5, "tip"] = None
    return frame[list(NAMES[::-1])].assign(stamp="2026-11-28")


def _polars(values: np.ndarray) -> Any:
    return pytest.importorskip("polars").DataFrame(dict(zip(NAMES[::-1], values.T[::-1], strict=True)))


def _arrow(values: np.ndarray) -> Any:
    return pytest.importorskip("pyarrow").table(dict(zip(NAMES[::-1], values.T[::-1], strict=True)))


def _with(change: Callable[[np.ndarray], Any]) -> Callable[[Path], Blocks]:
    return lambda folder: {force: change(rows) for force, rows in fine().items()}


def _without(name: str) -> Callable[[np.ndarray], Any]:
    return lambda values: {own: values[:, k] for k, own in enumerate(NAMES) if own != name}


def readings(blocks: Blocks) -> bool:
    """Return whether the readings are those that were written, by name, the missing ones NaN."""
    found = gathered(TWIN, [Recorded(rows, {"force": force}) for force, rows in blocks.items()]).readings
    truth = np.concatenate(list(fine().values()))
    kept = np.isfinite(found)
    return bool((found[kept] == truth[kept]).all() and kept[:, 1:].all() and kept[:, 0].sum() in (8, len(truth)))


ARRAYS: dict[str, tuple[str, Callable[[np.ndarray], Any], Any]] = {
    "a mask over -1": ("numpy", _masked, True),
    "fields in another order": ("numpy", _structured, True),
    "a named tuple in another order": (
        "Python",
        lambda values: namedtuple("Row", NAMES[::-1])(*values.T[::-1]),
        True,
    ),
    "rows of masked arrays": ("numpy", lambda values: list(_masked(values)), True),
    "columns in another order, NA and a date": ("pandas", _pandas, True),
    "columns in reverse": ("polars", _polars, True),
    "columns in reverse, Arrow": ("pyarrow", _arrow, True),
    "a column is lacking": ("numpy", _without("mid"), Refused(("'mid'", "expected the names of all readings"))),
    "rows of two lengths": ("Python", lambda values: [[1.0, 2.0], [3.0]], Refused(("no numbers",))),
    "complex": ("numpy", lambda values: values.astype(complex), Refused(("complex128", "expected numbers"))),
    "decimal commas": ("numpy", lambda values: np.char.replace(values.astype(str), ".", ","), Refused(("no numbers",))),
}


def _model(units: str, cell: str = "{:g}") -> Callable[[Path], Path]:
    """Return what writes a model's table: a row of units under its names, and its cells."""

    def make(folder: Path) -> Path:
        rows = [(k, f, f / k) for k in (70.0, 100.0, 130.0) for f in (0.0, 60.0)]
        lines = ["stiffness,force,tip", units, *(f"{k:g},{f:g},{cell.format(tip)}" for k, f, tip in rows)]
        (folder / "beam.csv").write_text("\n".join(lines))
        card = {"readings": {"tip": "mm"}, "loads": ["force"], "parameters": {"stiffness": [100, 70, 130, "N/mm"]}}
        (folder / "beam.csv.json").write_text(json.dumps(card))
        return folder / "beam.csv"

    return make


def at_60_n(path: Path) -> float:
    return round(float(table_twin(path).predict({}, 60.0)[0]), 9)


MODELS = {
    "the units of its card": (_model("N/mm,N,mm"), 0.6),
    "another unit than its card": (_model("N/mm,N,m"), Refused(("column 'tip' is in 'm'; expected 'mm'", "convert"))),
    "a unit in every cell": (_model("N/mm,N,", "{:g} cm"), Refused(("'0 cm' is no number, and a model holds",))),
}
ROWS = [
    *(Row("table_twin", "a solver", case, make, at_60_n, right) for case, (make, right) in MODELS.items()),
    *(Row("diagnose", writer, case, _in(blocks), told, right) for case, (writer, blocks, right) in DISPLAYS.items()),
    *(Row("Recorded", writer, case, _with(make), readings, right) for case, (writer, make, right) in ARRAYS.items()),
    Row(
        "diagnose",
        "copied rows",
        "no repeats differ and nothing says why",
        _in({force: np.repeat(rows[:1], 4, axis=0) for force, rows in fine().items()}),
        told,
        Refused(("all repeats", "--noise")),
    ),
    Row(
        "diagnose",
        "numpy",
        "one load is read twice, all others once",
        _in({force: rows[: 1 + (force == 20.0)] for force, rows in fine().items()}),
        told,
        Refused(("at most one load of one test was read twice", "repeat the readings of two loads", "--noise")),
    ),
]
