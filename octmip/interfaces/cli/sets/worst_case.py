"""Find the tree of least worst case: `octmip.interfaces.cli.options.worst_case` says how the command is called."""

import argparse
from dataclasses import replace
from functools import partial
from typing import Any

from octmip.errors import DataError
from octmip.formats.tree_file import finite_or_none, record_tree, write_tree_file
from octmip.input.messages import shown as quoted
from octmip.input.names import shown
from octmip.interfaces.cli.answer import ProgressLine, print_json, print_notes, printable, then_written
from octmip.interfaces.cli.arguments import limits_of
from octmip.interfaces.cli.samples.table_problem import TableProblem, read_problem
from octmip.interfaces.report.markdown import markdown_table
from octmip.interfaces.report.text import number, tree_text
from octmip.trees.methods.interruption import held_back
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution, Stop
from octmip.trees.tree_nodes import encode_tree
from octmip.trees.worst_case.bands import Amount
from octmip.trees.worst_case.least_worst import WorstCaseSolution, solve

FORMAT = "octmip worst-case"
VERSION = 1


def run(arguments: argparse.Namespace) -> int:
    """Search, show, write."""
    limits = limits_of(arguments)
    asked = read_problem(arguments)
    bands = bands_of(arguments.off, asked.problem)
    with ProgressLine() as progress:
        found = solve(
            asked.problem,
            bands,
            arguments.gauges_off,
            limits,
            seed=arguments.seed,
            n_jobs=arguments.threads,
            progress=progress,
        )
    with held_back():
        columns = asked.target_column, asked.weights_column, asked.preparation
        file = record_tree(asked.problem, _plain(found), *columns, None)
        with then_written(arguments.out, partial(write_tree_file, file=file), _verdict(found), is_quiet=arguments.json):
            if arguments.json:
                more = {"threads": arguments.threads, "out": arguments.out, "notes": list(asked.notes)}
                print_json(as_json(asked.problem, found) | more)
            else:
                print_notes(asked.notes)
                print(printable(_text(asked, found)))
    return 0


def bands_of(texts: list[str], problem: Problem) -> dict[str, Amount]:
    """Return the bands that arguments such as "0.3", "g1=0.2" or "g1=0.1:0.4" mean.

    Raises
    ------
    DataError
        an amount is no number.
    """
    named = [text.rpartition("=") for text in texts]
    default = [_amount(amount, text) for (name, _, amount), text in zip(named, texts, strict=True) if not name]
    bands: dict[str, Amount] = dict.fromkeys(problem.sensors, default[-1]) if default else {}
    return bands | {name: _amount(amount, text) for (name, _, amount), text in zip(named, texts, strict=True) if name}


def _amount(words: str, text: str) -> tuple[float, float]:
    below, colon, above = words.partition(":")
    try:
        return float(below), float(above if colon else below)
    except ValueError as error:
        raise DataError(
            f"--off is {quoted(text)}; expected an amount such as 0.3, g1=0.3 for one gauge, or g1=0.1:0.4 for below "
            "and above"
        ) from error


def _plain(found: WorstCaseSolution) -> Solution:
    """Return the tree as a solution of the problem without reading errors."""
    stop = Stop.OPTIMAL if found.plain_bound >= found.figures.plain else Stop.FINISHED
    bound = min(found.plain_bound, found.figures.plain)
    return replace(found.solution, objective=found.figures.plain, bound=bound, stop=stop, tolerance=0.0, details={})


def as_json(problem: Problem, found: WorstCaseSolution) -> dict[str, Any]:
    """Return the JSON object of a solution; its schema is octmip/interfaces/schemas/worst_case.schema.json."""
    solution, figures = found.solution, found.figures
    assert solution.tree is not None
    constant = figures.constant
    return {
        "format": FORMAT,
        "format_version": VERSION,
        "worst_case": solution.objective,
        "bound": finite_or_none(solution.bound),
        "is_optimal": solution.is_optimal,
        "gauges": list(figures.gauges),
        "by_gauges": [{"gauges": list(names), "cost": cost} for names, cost in figures.by_gauges.items()],
        "constant": None
        if constant is None
        else {"cost": constant.cost, "gauges": list(constant.gauges), "errors": dict(constant.errors)},
        "plain": figures.plain,
        "plain_bound": finite_or_none(found.plain_bound),
        "tree": encode_tree(solution.tree, problem.feature_names, problem.class_names),
        "stop": str(solution.stop),
        "seconds": solution.seconds,
        "n_nodes": solution.n_nodes,
    }


def _text(asked: TableProblem, found: WorstCaseSolution) -> str:
    problem, figures = asked.problem, found.figures
    assert found.solution.tree is not None
    columns = None if asked.preparation.columns.is_plain else asked.preparation.columns
    tree = tree_text(found.solution.tree, problem.feature_names, problem.class_names, None, columns)
    rows = [{"gauges off": "none", "cost": number(figures.plain)}]
    for names, cost in sorted(figures.by_gauges.items(), key=lambda item: -item[1]):
        if names:
            rows.append({"gauges off": ", ".join(map(shown, names)), "cost": number(cost)})
    if figures.constant is not None and figures.constant.gauges:
        words = ", ".join(f"{shown(name)} by {error:.6g}" for name, error in figures.constant.errors.items())
        rows.append({"gauges off": f"constant: {words}", "cost": number(figures.constant.cost)})
    head = f"worst case {number(found.solution.objective)}, without reading errors {number(figures.plain)}"
    return f"{head}\n\n{tree}\n\n{markdown_table(rows, ('gauges off', 'cost'))}\n"


def _verdict(found: WorstCaseSolution) -> str:
    solution = found.solution
    if solution.is_optimal:
        return f"Proven: no tree of this depth has a worst case below {number(solution.objective)}."
    return f"Not proven (stop: {solution.stop}): no worst case is below {number(solution.bound)}."
