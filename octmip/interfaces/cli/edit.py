"""What a change of a tree costs: `octmip.interfaces.cli.options.edit` says how the command is called."""

import argparse
import time
from dataclasses import replace
from functools import partial
from typing import Any

from octmip.errors import ProblemError, SolverError
from octmip.formats.tree_file import TreeFile, finite_or_none, leaf_counts, read_tree_file, record_tree, write_tree_file
from octmip.interfaces.cli.answer import (
    ProgressLine,
    describe,
    print_json,
    printable,
    rounded,
    then_written,
    verdict,
)
from octmip.interfaces.cli.samples.parts import fixed_splits_of
from octmip.interfaces.cli.samples.training import read_training
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.report.markdown import markdown_table
from octmip.interfaces.report.text import number, solution_text, tree_text
from octmip.trees.certificate import certify
from octmip.trees.methods.interruption import held_back
from octmip.trees.part_check import n_changes
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution, Stop
from octmip.trees.solver import solve
from octmip.trees.tradeoff.edits import EditPrice, edit_prices, with_splits
from octmip.trees.tree import Node

EVERY = "?"
"""In place of a split: every column, one after the other."""


def run(arguments: argparse.Namespace) -> int:
    """Solve with the part, show it beside the tree of the file, write."""
    file = read_tree_file(arguments.tree)
    with StageLine("reading"):
        training = read_training(file, arguments.data, source=arguments.tree)
        old = certify(training.problem, file.solution).objective
    if (word := next((word for word in arguments.set if word.endswith(f"={EVERY}")), None)) is not None:
        return _show_prices(arguments, word, training.problem, file, old)
    problem = edited(training.problem, arguments.set, file, arguments.max_changes)
    with ProgressLine() as progress:
        solution = solve(problem, "exact", Limits(seconds=arguments.seconds), progress=progress)
    if solution.tree is None:
        raise SolverError(f"{solution.solver} found no tree (stop: {solution.stop}); give it more time with --seconds")
    with held_back():
        certificate = certify(problem, solution)
        columns = file.target_column, file.weights_column, file.preparation
        last = price(training.problem, file.solution, solution, old)
        write = partial(write_tree_file, file=record_tree(problem, solution, *columns))
        with then_written(arguments.out, write, last, is_quiet=arguments.json):
            if arguments.json:
                changes = n_changes(solution.tree, file.tree)
                beside = {"old_objective": old, "old_bound": finite_or_none(file.solution.bound), "n_changes": changes}
                print_json(describe(problem, solution, certificate) | beside | {"out": arguments.out})
            else:
                print(printable(solution_text(problem, solution, certificate)) + "\n")
                print(printable(_tree(file, problem, solution.tree)) + "\n")
                print(printable(verdict(problem, solution, certificate)))
    return 0


def _show_prices(arguments: argparse.Namespace, word: str, problem: Problem, file: TreeFile, old: float) -> int:
    """Show what the best tree costs with each column at a node."""
    node, others = word.rpartition("=")[0], [one for one in arguments.set if one != word]
    if arguments.out is not None:
        raise ProblemError(f"--set {word} asks for every column and --out for one tree; name a column, or leave --out")
    if others or arguments.max_changes is not None:
        problem = edited(problem, others, file, arguments.max_changes)
    with ProgressLine(f"{node}: ") as progress:
        end = time.perf_counter() + arguments.seconds
        prices = list(edit_prices(problem, node, problem.sensors, end, progress))
    rows = [_row(price, old) for price in sorted(prices, key=lambda price: price.objective)]
    if arguments.json:
        print_json({"node": node, "old_objective": old, "rows": rows})
        return 0
    shown = [{name: rounded(cell) if isinstance(cell, float) else cell for name, cell in row.items()} for row in rows]
    print(printable(markdown_table(shown, ("split", "objective", "bound", "more", "proven"))))
    print(f"\nThe best tree with each column at {node}; the file's tree has the objective {number(old)}.")
    return 0


def _row(price: EditPrice, old: float) -> dict[str, Any]:
    objective, bound = finite_or_none(price.objective), finite_or_none(price.bound)
    more = None if objective is None else objective - old
    proven = "yes" if price.stop is Stop.OPTIMAL else f"no ({price.stop})"
    proven = proven if price.is_possible else "no such tree"
    return {"split": price.sensor, "objective": objective, "bound": bound, "more": more, "proven": proven}


def edited(problem: Problem, words: list[str], file: TreeFile, max_changes: int | None) -> Problem:
    """Return the problem with the splits that words give, and at most so many changes of the tree of a file.

    Raises
    ------
    ProblemError
        nothing is asked for, or a word is no split.
    """
    given = fixed_splits_of(words, "--set", file.columns)
    if given is None and max_changes is None:
        raise ProblemError("--set is not given; expected a node and its split, such as --set ROOT=g05")
    asked = with_splits(problem, given or {})
    return asked if max_changes is None else replace(asked, old_tree=file.tree, max_changes=max_changes)


def price(problem: Problem, before: Solution, solution: Solution, old: float) -> str:
    """Return what the change costs beside the tree of the file, in a sentence."""
    least, most = solution.bound - old, solution.objective - old
    proven = "optimal" if before.is_optimal else "not proven optimal"
    file = f"the file's tree has the objective {number(old)} ({proven})"
    if solution.is_optimal:
        way = f"{number(abs(most))} {'more' if most >= 0 else 'less'}"
        return f"The best tree with this change has the objective {number(solution.objective)}, proven: {way}; {file}."
    return (
        f"The best tree with this change has an objective between {number(solution.bound)} and "
        f"{number(solution.objective)} (stop: {solution.stop}), {number(least)} to {number(most)} more; {file}."
    )


def _tree(file: TreeFile, problem: Problem, tree: Node) -> str:
    counts = leaf_counts(problem, tree)
    return tree_text(tree, problem.feature_names, problem.class_names, counts, file.columns)
