"""Every method on a table or on those of a folder: `octmip.interfaces.cli.options.compare` says how it is called."""

import argparse
import importlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from octmip.errors import DataError, OctmipError
from octmip.formats.table import read_table
from octmip.formats.table.source import form_by_ending
from octmip.input.files import make_folder, write_bytes
from octmip.input.names import visible
from octmip.interfaces.cli.answer import print_json, then_written
from octmip.interfaces.cli.arguments import limits_of
from octmip.interfaces.cli.compare_table import compared, methods_of, reasons, run_one_table, table_of
from octmip.interfaces.cli.options.compare import PICTURE, ROWS
from octmip.interfaces.cli.picture import write_picture
from octmip.interfaces.cli.samples.table_problem import read_problem
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.answer.interruption import held_back, is_heard
from octmip.trees.answer.solution import Limits

SHIFT = 1.0
"""Seconds added before the geometric mean, so that a table of milliseconds does not decide it."""
RATIOS = (1, 2, 10)
"""Times the seconds of the quickest method, of the printed profile."""


@dataclass(frozen=True, slots=True)
class Found:
    """What the methods found on one table.

    Attributes
    ----------
    table
        name of its file.
    n_samples
        its rows; 0 where it cannot be asked about.
    measures
        names of what its loss measures.
    rows
        as of `octmip compare`, one for each method that ran; with an entry `error` where it did not answer.
    notes
        sentences about what became of the table, or why it cannot be asked about.
    """

    table: str
    n_samples: int
    measures: tuple[str, ...]
    rows: Sequence[Mapping[str, Any]]
    notes: tuple[str, ...]

    def by(self, method: str) -> Mapping[str, Any]:
        """Return the row of a method, that of one without an answer where it has none."""
        return next((row for row in self.rows if row["method"] == method), {})


def run(arguments: argparse.Namespace) -> int:
    """Run all; of a folder show the methods, then the rows of each table."""
    if not Path(arguments.data).is_dir():
        if arguments.out is not None:
            raise DataError(f"--out is for a folder of tables, and {arguments.data} is none; take --json instead")
        return run_one_table(arguments)
    _refuse_of_one_table(arguments)
    limits, methods = limits_of(arguments), methods_of(arguments)
    if arguments.out:
        importlib.import_module("octmip.interfaces.plot")  # matplotlib is an extra: missing, it is named before work
        make_folder(arguments.out)
    found = _found(arguments, _tables(arguments.data), limits)
    with held_back():
        summary = [_summary(method, found, limits.seconds) for method in methods]
        write = partial(_write, found=found, methods=methods)
        with then_written(arguments.out, write, is_quiet=arguments.json):
            _show(arguments, found, summary)
    return 0


def _refuse_of_one_table(arguments: argparse.Namespace) -> None:
    """Raise a DataError where an option is given that one table alone can have."""
    for name in ("holdout", "test", "baselines"):
        if getattr(arguments, name):
            raise DataError(f"--{name} is for one table, and {arguments.data} is a folder; leave it out")


def _tables(folder: str) -> list[Path]:
    """Return the tables of a folder in the order of their names.

    Raises
    ------
    DataError
        it holds no table.
    """
    tables = [path for path in sorted(Path(folder).iterdir()) if path.is_file() and form_by_ending(path)]
    if not tables:
        raise DataError(
            f"{folder} holds no table; expected files that end with .csv, .tsv, .parquet or .gz; name another"
        )
    return tables


def _found(arguments: argparse.Namespace, tables: Sequence[Path], limits: Limits) -> list[Found]:
    """Return what was found on each table; after a signal on those that are known, if there are any.

    Raises
    ------
    OctmipError
        no table can be used, with the reason of the first.
    """
    found: list[Found] = []
    for path in tables:
        try:
            found.append(_on_table(arguments, path, limits))
        except OctmipError as error:
            if is_heard() and not found:
                raise KeyboardInterrupt from error
            if is_heard():
                break
            if len(tables) == 1:
                raise
            found.append(Found(path.name, 0, (), (), (" ".join(str(error).split()),)))
        except KeyboardInterrupt:
            if not found:
                raise
        if is_heard():
            break
    if not any(one.n_samples for one in found):
        raise DataError(f"no table of {arguments.data} can be used; the first fault: {found[0].notes[0]}")
    return found


def _on_table(arguments: argparse.Namespace, path: Path, limits: Limits) -> Found:
    own = {"data": str(path)}
    if arguments.label is None and arguments.target is None:
        own["label"] = read_table(path).columns[-1]
    of_table = argparse.Namespace(**{**vars(arguments), **own})
    asked = read_problem(of_table)
    rows = compared(of_table, asked, limits)
    problem, notes = asked.problem, tuple(f"note: {visible(note)}" for note in asked.notes)
    return Found(path.name, problem.samples.n_samples, problem.loss.measured, tuple(rows), notes)


def _summary(method: str, found: Sequence[Found], limit: float) -> dict[str, Any]:
    """Return a method's figures over all tables; a mean is None where nothing is known to take it of."""
    rows = [row for one in found if "objective" in (row := one.by(method))]
    best = [min(row["objective"] for row in one.rows if "objective" in row) for one in found if one.by(method) in rows]
    gaps = [row["gap_to_best_bound"] for row in rows if row["gap_to_best_bound"] is not None]
    proven = [seconds_to_proof(row) for row in rows]
    spent = [max(row["seconds"], 0.0 if math.isinf(limit) else limit) for row in rows]
    seconds = [end if proof is None else proof for proof, end in zip(proven, spent, strict=True)]
    ratios = ratios_of(method, found)
    return {
        "method": method,
        "tables": len(rows),
        "proven": sum(proof is not None for proof in proven),
        "best tree": sum(row["objective"] <= least for row, least in zip(rows, best, strict=True)),
        "mean gap to best bound %": round(100 * float(np.mean(gaps)), 2) if gaps else None,
        "seconds to proof": round(shifted_mean(seconds), 3) if any(proof is not None for proof in proven) else None,
        **{f"within {ratio} x": _share(ratios, ratio) for ratio in RATIOS},
    }


def seconds_to_proof(row: Mapping[str, Any]) -> float | None:
    """Return the seconds until a row's tree was proven, None where it was not."""
    return row["seconds_to_gap"]["0 %"] if row.get("is_optimal") else None


def ratios_of(method: str, found: Sequence[Found]) -> list[float]:
    """Return a method's seconds until the proof over those of the quickest, for each table that any method proves.

    +inf where it proves nothing itself.
    """
    ratios = []
    for one in found:
        proofs = {row["method"]: proof for row in one.rows if (proof := seconds_to_proof(row)) is not None}
        if proofs:
            ratios.append(proofs.get(method, math.inf) / max(min(proofs.values()), 1e-9))
    return ratios


def shifted_mean(seconds: Sequence[float]) -> float:
    """Return the geometric mean of seconds, each with `SHIFT` added, less `SHIFT`."""
    return math.exp(float(np.mean(np.log(np.array(seconds) + SHIFT)))) - SHIFT


def _share(ratios: Sequence[float], most: float) -> str | None:
    return f"{100 * sum(ratio <= most for ratio in ratios) / len(ratios):.0f} %" if ratios else None


def _show(arguments: argparse.Namespace, found: Sequence[Found], summary: list[dict[str, Any]]) -> None:
    if arguments.json:
        tables = [{"table": one.table, "n_samples": one.n_samples, "rows": list(one.rows)} for one in found]
        print_json({"methods": summary, "tables": tables})
        return
    print(markdown_table(summary))
    asked = [set(reasons(one.rows)) for one in found if one.rows]
    of_all = set.intersection(*asked)
    for sentence in sorted(of_all):
        print(f"\n{sentence}")
    for one in found:
        print(f"\n{visible(one.table)}: {one.n_samples} samples")
        if one.rows:
            print("\n" + table_of(one.rows, one.measures, one.measures))
        for sentence in (*reasons(one.rows), *one.notes):
            if sentence not in of_all:
                print(f"\n{sentence}")


def _write(folder: str, found: Sequence[Found], methods: Sequence[str]) -> None:
    """Write the rows as CSV, and profile and gaps over time as a picture."""
    from octmip.interfaces.plot.curves import benchmark_figure

    rows = [{"table": one.table, "n_samples": one.n_samples, **_flat(row)} for one in found for row in one.rows]
    write_bytes(Path(folder) / ROWS, pd.DataFrame(rows).to_csv(index=False).encode())
    answered = [name for name in methods if any("objective" in one.by(name) for one in found)]
    gaps = {name: [one.by(name).get("gaps", []) for one in found] for name in answered}
    figure = benchmark_figure({name: ratios_of(name, found) for name in answered}, gaps)
    write_picture(Path(folder) / PICTURE, figure)


def _flat(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row with one value in each entry: the seconds to a gap under its percentage."""
    plain = {name: value for name, value in row.items() if not isinstance(value, dict | list)}
    return plain | {f"seconds to {gap}": value for gap, value in row.get("seconds_to_gap", {}).items()}
