"""Every method on one table, side by side."""

import argparse
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from octmip.errors import DataError, ProblemError, SolverError, is_out_of_memory
from octmip.formats.tree_file import finite_or_none
from octmip.input.names import visible
from octmip.interfaces.cli.answer import ProgressLine, describe, print_json, print_notes, rounded, score_json
from octmip.interfaces.cli.arguments import limits_of, nameable, words_of
from octmip.interfaces.cli.gap_times import GAPS, GapTimes
from octmip.interfaces.cli.samples.table_problem import TableProblem, read_problem
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.answer import interruption
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.interruption import held_back
from octmip.trees.answer.solution import Limits, Stop, relative_gap
from octmip.trees.methods.options import METHODS
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import chosen_method, read_options, taken
from octmip.trees.solver import solve
from octmip.trees.tradeoff import score
from octmip.trees.tradeoff.baselines import baselines_of
from octmip.trees.tradeoff.held_out import score_of

OF_CLASSES = {"balanced accuracy": "balanced_accuracy", "AUROC": "mean_auroc"}
"""Columns of classes on rows held out, each with its entry of the score."""
TIMES = tuple(f"{100 * gap:g} %" for gap in GAPS)


def run_one_table(arguments: argparse.Namespace) -> int:
    """Run every method and show them."""
    limits = limits_of(arguments)
    asked = read_problem(arguments)
    rows = compared(arguments, asked, limits)
    baselines = _baselines(asked, arguments.seed) if arguments.baselines else []
    with held_back():
        _show(arguments, asked, rows, baselines)
    return 0


def _show(
    arguments: argparse.Namespace, asked: TableProblem, rows: list[dict[str, Any]], baselines: list[dict[str, Any]]
) -> None:
    problem = asked.problem
    if arguments.json:
        beside: dict[str, Any] = {"baselines": baselines} if arguments.baselines else {}
        notes = {"notes": list(asked.notes)}
        print_json(
            {"n_samples": problem.samples.n_samples, "baseline": problem.baseline, "rows": rows, **beside, **notes}
        )
        return
    measures = problem.loss.measured
    is_class = problem.loss.predicts == "class"
    held = (
        () if asked.held_out is None else tuple(f"{n} held out" for n in (*measures, *(OF_CLASSES if is_class else ())))
    )
    print_notes(asked.notes)
    print(table_of(rows, (*measures, *held), measures))
    if baselines:
        named = [{**_shown(row, measures), "baseline": row["method"]} for row in baselines]
        print("\n" + markdown_table(named, ("baseline", *measures, *held, "seconds")))
    if asked.held_out is not None:
        print(f"\n{problem.samples.n_samples} training samples, {len(asked.held_out.codes)} held out")
    for sentence in reasons([*rows, *baselines]):
        print(f"\n{sentence}")


def table_of(rows: Sequence[Mapping[str, Any]], columns: tuple[str, ...], measures: tuple[str, ...]) -> str:
    """Return the printed table of methods, with columns for its measures among those that all have."""
    before = ("objective", "bound", "gap %", "gap to best bound %", "splits", "tree by", "seconds")
    every = ("method", *columns, *before, *(f"to {gap}" for gap in TIMES), "stop")
    return markdown_table([_shown(row, measures) for row in rows], every)


def reasons(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield a sentence for each method that did not answer, or whose bound is not about all trees."""
    for row in rows:
        if "error" in row:
            yield f"{row['method']}: {visible(row['error'])}"
        elif not row.get("scope_is_whole", True):
            yield f"{row['method']}: its bound holds for {visible(row['scope'])} only"


def compared(arguments: argparse.Namespace, asked: TableProblem, limits: Limits) -> list[dict[str, Any]]:
    """Return a row for each method; after a signal those that are known, if there are any.

    Each says how far it can be from the optimum, by the best bound of any method that speaks about all trees.
    """
    rows: list[dict[str, Any]] = []
    methods = methods_of(arguments)
    _refuse_options_of_none(arguments, asked.problem, methods)
    for method in methods:
        try:
            row = _row(arguments, asked, method, limits)
        except BaseException:  # between two solves a signal makes any error, of an import for instance
            if rows and interruption.is_heard():
                break
            raise
        if "error" in row and rows and interruption.is_heard():
            break
        rows.append(row)
        if row.get("stop") == Stop.INTERRUPTED:
            break
    _add_gap_to_best_bound(rows)
    return rows


def _baselines(asked: TableProblem, seed: int) -> list[dict[str, Any]]:
    """Return a row for each baseline; after a signal those that are known."""
    problem = asked.problem
    rows: list[dict[str, Any]] = []
    for name, train in baselines_of(problem).items():
        start = time.perf_counter()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # a linear model that has not converged is still a baseline
                predictor = train(seed)
        except KeyboardInterrupt:
            break
        except ValueError as error:  # scikit-learn's, of a class with one sample for instance, and ours
            rows.append({"method": name, "error": " ".join(str(error).split())})
            continue
        seconds = time.perf_counter() - start
        held = asked.held_out and score_json(score_of(problem, predictor, asked.held_out))
        training = score_json(score_of(problem, predictor))
        rows.append({"method": name, **(training or {}), "held_out": held, "seconds": seconds})
    return rows


def methods_of(arguments: argparse.Namespace) -> list[Any]:
    """Return the methods that the arguments name, all without a name."""
    if not arguments.methods:
        return list(METHODS[1:])  # those that cannot answer say why
    names = [name.strip() for name in arguments.methods.split(",")]
    unknown = [name for name in names if name not in METHODS[1:]]
    if unknown:
        raise DataError(f"--methods names {unknown[0]!r}; expected some of {', '.join(METHODS[1:])}")
    return names


def _refuse_options_of_none(arguments: argparse.Namespace, problem: Problem, methods: list[Any]) -> None:
    """Raise a DataError where none of the methods takes an option that is given; the others go without it."""
    takes = {name for method in methods for name in taken(problem, method)} & set(nameable(()))
    for name in words_of(arguments):
        if name not in takes:
            raise DataError(
                f"--option names {name!r}; expected what one of the methods takes: {', '.join(sorted(takes))}; "
                "leave it out, or name another of --methods"
            )


def _row(arguments: argparse.Namespace, asked: TableProblem, method: Any, limits: Limits) -> dict[str, Any]:
    problem = asked.problem
    try:
        chosen_method(problem, method)  # or the reason why there is none
        with ProgressLine(f"{method}: ") as progress:
            times = GapTimes(progress)
            words = {name: word for name, word in words_of(arguments).items() if name in taken(problem, method)}
            options = read_options(problem, method, words)
            run = {"seed": arguments.seed, "n_jobs": arguments.threads, "progress": times}
            solution = solve(problem, method, limits, options=options, **run)
        if solution.tree is None:
            return {"method": method, "error": f"no tree found (stop: {solution.stop})"}
        row = describe(problem, solution, certify(problem, solution))
        held = asked.held_out and score_json(score(problem, solution.tree, asked.held_out))
        by = solution.details.get("tree_by", method)
        times.end(solution)
        reached = {"seconds_to_gap": times.reached(), "gaps": times.gaps}
        return row | reached | {"method": method, "held_out": held, "tree_by": by}
    except Exception as error:
        if not isinstance(error, ProblemError | SolverError) and not is_out_of_memory(error):
            raise
        return {"method": method, "error": " ".join(str(error).split())}


def _add_gap_to_best_bound(rows: list[dict[str, Any]]) -> None:
    proven = [row for row in rows if row.get("bound") is not None]
    over_all = [row["bound"] for row in proven if row["scope_is_whole"]]
    best = max(over_all, default=float("-inf"))
    for row in rows:
        if "objective" in row:
            row["gap_to_best_bound"] = finite_or_none(relative_gap(row["objective"], best))


def _shown(row: Mapping[str, Any], measures: tuple[str, ...]) -> dict[str, Any]:
    """Return a row under the headings of the printed table, its figures rounded."""
    gaps = {"gap %": row.get("gap"), "gap to best bound %": row.get("gap_to_best_bound")}
    reached = row.get("seconds_to_gap", {})
    held = row.get("held_out") or {}
    return {
        **row,
        **{name: rounded(row.get(name)) for name in measures},
        **{f"{name} held out": rounded(held.get(name)) for name in measures},
        **{f"{name} held out": rounded(held.get(entry)) for name, entry in OF_CLASSES.items()},
        **{f"to {gap}": None if reached.get(gap) is None else round(reached[gap], 3) for gap in TIMES},
        **{name: None if gap is None else round(100 * gap, 2) for name, gap in gaps.items()},
        "splits": row.get("n_splits"),
        "tree by": row.get("tree_by"),
        "seconds": None if "seconds" not in row else round(row["seconds"], 3),
        "stop": row.get("stop", "no answer"),
    }
