"""Show the least cost against a setting: `octmip.interfaces.cli.options.frontier` says how the command is called."""

import argparse
import contextlib
from functools import partial
from typing import Any

from joblib import parallel_config

from octmip.errors import DataError
from octmip.input.names import shown
from octmip.interfaces.cli.answer import (
    ProgressLine,
    describe,
    print_json,
    print_notes,
    rounded,
    then_written,
)
from octmip.interfaces.cli.arguments import (
    limits_of,
    method_options,
)
from octmip.interfaces.cli.picture import check_picture, write_picture
from octmip.interfaces.cli.samples.table_problem import TableProblem, read_problem
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.interruption import held_back, is_heard
from octmip.trees.answer.solution import Limits
from octmip.trees.methods.options import Options
from octmip.trees.nodes.tree import n_splits
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff import Choice, Point, choose_tree, trace_frontier


def run(arguments: argparse.Namespace) -> int:
    """Trace, show, draw."""
    limits, values = limits_of(arguments), _values(arguments)
    check_picture(arguments.out)
    if arguments.folds is not None and arguments.over == "budget":
        raise DataError("--folds chooses a depth and a penalty; expected --over depth or --over penalty")
    asked = read_problem(arguments)
    problem = asked.problem
    with method_options(arguments, problem) as options:
        points = _points(arguments, problem, values, limits, options)
        choice = None if arguments.folds is None else _choice(arguments, problem, limits, options)
    with held_back():
        rows = [_row(arguments.over, point) for point in points]
        if choice is not None:
            for row, point in zip(rows, points, strict=True):
                step = choice.step_at(point.problem.shape.depth, point.problem.shape.leaf_penalty / problem.baseline)
                row["held_out"] = step.validation_cost
        with then_written(arguments.out, partial(_draw, points=points, over=arguments.over), is_quiet=True):
            _show(arguments, asked, rows, choice)
    return 0


def _points(
    arguments: argparse.Namespace,
    problem: Problem,
    values: list[float] | None,
    limits: Limits,
    options: Options,
) -> list[Point]:
    with ProgressLine() as progress:
        return trace_frontier(
            problem,
            arguments.over,
            values,
            method=arguments.method,
            limits=limits,
            seed=arguments.seed,
            n_jobs=arguments.threads,
            progress=progress,
            options=options,
        )


def _show(
    arguments: argparse.Namespace, asked: TableProblem, rows: list[dict[str, Any]], choice: Choice | None
) -> None:
    if arguments.json:
        chosen = {} if choice is None else {"chosen": _chosen(choice)}
        found = {"over": arguments.over, "n_samples": asked.problem.samples.n_samples, "rows": rows}
        print_json(found | {"notes": list(asked.notes)} | chosen)
        return
    print_notes(asked.notes)
    print(_table(arguments.over, rows, asked.problem.loss.measured))
    if choice is not None:
        best = _chosen(choice)
        print(
            f"\nchosen: depth {best['depth']}, leaf penalty {best['penalty']:.4g} (alpha {best['alpha']:.4g}), "
            f"{best['held_out']:.4g} on samples held out"
        )


def _table(over: str, rows: list[dict[str, Any]], measures: tuple[str, ...]) -> str:
    held = ("held out",) if "held_out" in rows[0] else ()
    columns = (over, *measures, *held, "objective", "bound", "gap %", "splits", "sensors", "seconds", "stop")
    return markdown_table([_shown(row, measures) for row in rows], columns)


def _shown(row: dict[str, Any], measures: tuple[str, ...]) -> dict[str, Any]:
    """Return a row under the headings of the printed table, its figures rounded."""
    return {
        **row,
        **{name: rounded(row[name]) for name in measures},
        "held out": round(row.get("held_out", 0.0), 4),
        "gap %": None if row["gap"] is None else round(100 * row["gap"], 2),
        "splits": row["n_splits"],
        "sensors": ", ".join(map(shown, row["sensors"])),
        "seconds": round(row["seconds"], 3),
    }


def _choice(arguments: argparse.Namespace, problem: Problem, limits: Limits, options: Options) -> Choice | None:
    """Return what cross-validation chooses, its folds by the workers of a cluster, or in so many threads.

    None after a signal: there is no choice from half the folds, but a frontier to show.
    """
    if is_heard():
        return None
    with StageLine("cross-validating") as line, contextlib.suppress(KeyboardInterrupt), contextlib.ExitStack() as stack:
        # A checkpoint is this process's own: whoever keeps one takes the folds here.
        if options.cluster is None or options.checkpoint is not None:
            stack.enter_context(parallel_config(backend="threading", n_jobs=arguments.threads))
        how = {"method": arguments.method, "limits": limits, "seed": arguments.seed, "options": options}
        return choose_tree(problem, folds=arguments.folds, stage=line, **how)
    return None


def _chosen(choice: Choice) -> dict[str, Any]:
    chosen = choice.chosen
    return {
        "depth": chosen.depth,
        "penalty": choice.problem.shape.leaf_penalty,
        "alpha": chosen.alpha,
        "held_out": chosen.validation_cost,
        "n_splits": n_splits(choice.tree),
    }


def _values(arguments: argparse.Namespace) -> list[float] | None:
    if arguments.values is None:
        return None
    try:
        return [float(value) for value in arguments.values.split(",")]
    except ValueError as error:
        raise DataError(f"--values is {arguments.values!r}; expected numbers separated by commas") from error


def _row(over: str, point: Point) -> dict[str, Any]:
    return {over: point.value, **describe(point.problem, point.solution, certify(point.problem, point.solution))}


def _draw(path: str, points: list[Point], over: str) -> None:
    from octmip.interfaces.plot.curves import frontier_figure

    names = {"depth": "depth", "budget": "sensor budget", "penalty": "leaf penalty"}
    values = [point.value for point in points]
    objectives = [point.solution.objective for point in points]
    bounds = [point.solution.bound for point in points]
    write_picture(path, frontier_figure(values, objectives, bounds, names[over]))
