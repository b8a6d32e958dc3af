"""The least cost against depth, sensor budget or leaf penalty: one row a value, each with its bound.

The limits hold for each value by itself. Each value starts from the tree of the one before, and bounds proven under
wider limits serve the tighter ones.
"""

import argparse
import io
from pathlib import Path
from typing import Any

from octmip.certificate import certify
from octmip.cli.answer import ProgressLine, describe, print_json
from octmip.cli.arguments import add_method_argument, add_problem_arguments, add_run_arguments, limits_of
from octmip.cli.question import ask
from octmip.errors import DataError
from octmip.files import check_writable, write_bytes
from octmip.plot import frontier_figure
from octmip.report.markdown import markdown_table
from octmip.tradeoff import OVERS, Point, trace_frontier

PICTURES = (".svg", ".png", ".pdf")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip frontier`."""
    add_problem_arguments(parser)
    add_run_arguments(parser, seconds=60.0)
    add_method_argument(parser)
    parser.add_argument("--over", choices=OVERS, required=True, help="what is varied")
    parser.add_argument(
        "--values",
        metavar="A,B,...",
        help="its values (default: depths 1 to D; 1, 2, ... sensors; a penalty for each tree that is best for one)",
    )
    parser.add_argument("--out", metavar="FILE", help=f"draw the frontier here, one of {', '.join(PICTURES)}")


def run(arguments: argparse.Namespace) -> int:
    """Trace, show, draw."""
    limits, values = limits_of(arguments), _values(arguments)
    if arguments.out:
        if Path(arguments.out).suffix not in PICTURES:
            raise DataError(f"--out {arguments.out} is no picture; expected one of {', '.join(PICTURES)}")
        check_writable(arguments.out)
    problem = ask(arguments).problem
    with ProgressLine() as progress:
        points = trace_frontier(
            problem,
            arguments.over,
            values,
            method=arguments.method,
            limits=limits,
            seed=arguments.seed,
            n_jobs=arguments.threads,
            progress=progress,
        )
    rows = [_row(arguments.over, point) for point in points]
    if arguments.out:
        _draw(arguments, points)
    if arguments.json:
        print_json({"over": arguments.over, "n_samples": problem.n_samples, "rows": rows})
        return 0
    columns = (arguments.over, "errors", "objective", "bound", "gap", "n_splits", "sensors", "seconds", "stop")
    shown = [row | {"sensors": ", ".join(row["sensors"]), "seconds": round(row["seconds"], 3)} for row in rows]
    print(markdown_table(shown, columns))
    return 0


def _values(arguments: argparse.Namespace) -> list[float] | None:
    if arguments.values is None:
        return None
    try:
        return [float(value) for value in arguments.values.split(",")]
    except ValueError as error:
        raise DataError(f"--values is {arguments.values!r}; expected numbers separated by commas") from error


def _row(over: str, point: Point) -> dict[str, Any]:
    return {over: point.value, **describe(point.problem, point.solution, certify(point.problem, point.solution))}


def _draw(arguments: argparse.Namespace, points: list[Point]) -> None:
    names = {"depth": "depth", "budget": "sensor budget", "penalty": "leaf penalty"}
    values = [point.value for point in points]
    objectives = [point.solution.objective for point in points]
    bounds = [point.solution.bound for point in points]
    buffer = io.BytesIO()
    figure = frontier_figure(values, objectives, bounds, names[arguments.over])
    figure.savefig(buffer, format=Path(arguments.out).suffix[1:], dpi=150)
    write_bytes(arguments.out, buffer.getvalue())
