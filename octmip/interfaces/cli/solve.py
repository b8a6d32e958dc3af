"""Find the best tree for a table: `octmip.interfaces.cli.options.solve` says how the command is called."""

import argparse
import math
from dataclasses import replace

from octmip.errors import DataError, SolverError
from octmip.formats.table.preparation import with_written_cuts
from octmip.formats.tree_file import Readings, read_tree_file, record_tree, tree_for, write_tree_file
from octmip.interfaces.cli.answer import (
    ProgressLine,
    comparison_json,
    comparison_text,
    describe,
    print_json,
    print_notes,
    printable,
    then_written,
    verdict,
)
from octmip.interfaces.cli.arguments import (
    limits_of,
    method_options,
)
from octmip.interfaces.cli.foreign_solution import read_solution, refuse_alone
from octmip.interfaces.cli.samples.table_problem import TableProblem, read_problem
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.report.new_rows import (
    choice_text,
    difference_text,
    expected_words,
    held_out_words,
    warning_text,
)
from octmip.interfaces.report.text import solution_text, tree_text
from octmip.trees.answer.certificate import Certificate, certify, leaf_counts
from octmip.trees.answer.interruption import held_back, is_heard
from octmip.trees.answer.solution import Limits, ProofError, Solution
from octmip.trees.evidence.proof import check_provable
from octmip.trees.methods.options import Options
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_file import write_problem_file
from octmip.trees.runs.registry import Run
from octmip.trees.solver import solve
from octmip.trees.tradeoff import Comparison
from octmip.trees.tradeoff.default import solve_default
from octmip.trees.tradeoff.held_out import beside_cart

MOST_SECONDS = 60.0
"""Of a choice, where no --seconds are given."""
OF_A_DEPTH: dict[str, object] = {
    "max_leaves": None,
    "monotone": None,
    "fix": [],
    "path_rule": [],
    "old_tree": None,
    "max_changes": None,
    "method": "auto",
    "gap": 0.0,
    "incumbent": None,
    "proof": None,
    "checkpoint": None,
    "option": [],
    "write_problem": None,
    "read_solution": None,
}
"""Options of a problem whose depth or price of a split is given, and what they are when they are not."""


def run(arguments: argparse.Namespace) -> int:
    """Solve, show, write."""
    limits = limits_of(arguments)
    if arguments.read_solution is None:
        refuse_alone(arguments)
    if arguments.depth is None and not arguments.leaf_penalty:
        return _choose(arguments, limits)
    with StageLine("reading the table"):  # no part of --seconds
        asked = read_problem(arguments)
    if arguments.proof:
        check_provable(asked.problem)
    if arguments.write_problem:
        write_problem_file(arguments.write_problem, asked.problem)
    incumbent = _incumbent(arguments.incumbent, asked.problem) if arguments.incumbent else None
    unproven: ProofError | None = None
    with method_options(arguments, asked.problem) as options, ProgressLine() as progress:
        try:
            if arguments.read_solution:
                solution = read_solution(arguments, asked.problem, options, limits, incumbent)
            else:
                solution = solve(
                    asked.problem,
                    arguments.method,
                    limits,
                    incumbent,
                    seed=arguments.seed,
                    n_jobs=arguments.threads,
                    progress=progress,
                    options=options,
                )
        except ProofError as error:
            solution, unproven = error.solution, error
    _show(arguments, asked, solution)
    if unproven is not None:
        raise unproven  # said last: the tree is shown and written all the same
    return 0


def _choose(arguments: argparse.Namespace, limits: Limits) -> int:
    """Choose the tree by cross-validation, show, write."""
    given = [name for name, usual in OF_A_DEPTH.items() if getattr(arguments, name) != usual]
    if given:
        option = f"--{given[0].replace('_', '-')}"
        raise DataError(
            f"{option} is given without --depth, where cross-validation chooses kind, depth and penalty of the tree; "
            f"expected --depth D or --leaf-penalty P beside it; add one, or leave {option} out"
        )
    with StageLine("reading the table"):  # no part of --seconds
        asked = read_problem(arguments)
    limits = Limits(seconds=MOST_SECONDS if math.isinf(limits.seconds) else limits.seconds)
    with method_options(arguments, asked.problem) as options, StageLine("cross-validating") as line:
        run = Run("auto", limits, arguments.seed, arguments.threads, Options(cluster=options.cluster))
        answer = solve_default(asked.problem, run, line)
    _show(arguments, replace(asked, problem=answer.problem), answer.solution)
    return 0


def _incumbent(path: str, problem: Problem) -> Node:
    return tree_for(problem, read_tree_file(path, problem.loss.predicts))


def _show(arguments: argparse.Namespace, asked: TableProblem, solution: Solution) -> None:
    problem = asked.problem
    if solution.tree is None:
        raise SolverError(f"{solution.solver} found no tree (stop: {solution.stop}); give it more time")
    solution = with_written_cuts(problem, solution, asked.preparation.columns)
    found = _beside_cart(arguments, asked, solution)
    with held_back():
        certificate = certify(problem, solution)
        held_out = asked.claim(None if found is None else found.held_out)
        columns = asked.target_column, asked.weights_column, asked.preparation
        units = Readings({name: unit for name, unit in asked.units.items() if name in asked.preparation.columns.names})
        new_rows = expected_words(problem, solution) if found is None else held_out_words(problem, found)
        last = new_rows + verdict(problem, solution, certificate)

        def write(path: str) -> None:  # a file names all the data by their sum, some time for many rows
            write_tree_file(path, record_tree(problem, solution, *columns, held_out, units))

        with then_written(arguments.out, write, last, is_quiet=arguments.json):
            if arguments.json:
                more = {"threads": arguments.threads, "out": arguments.out, "notes": list(asked.notes)}
                compared = {} if found is None else comparison_json(found)
                print_json(describe(problem, solution, certificate) | more | compared)
            else:
                _show_words(asked, solution, certificate, found)


def _beside_cart(arguments: argparse.Namespace, asked: TableProblem, solution: Solution) -> Comparison | None:
    """Return the tree beside CART on samples held out; None where there are none, or no time for it after a signal."""
    if asked.held_out is None or is_heard():
        return None
    try:
        return beside_cart(asked.problem, solution.tree, asked.held_out, arguments.seed)
    except KeyboardInterrupt:
        return None


def _show_words(asked: TableProblem, solution: Solution, certificate: Certificate, found: Comparison | None) -> None:
    problem, tree = asked.problem, solution.tree
    print_notes(asked.notes)
    if chosen := choice_text(problem, solution):
        print(f"{chosen}\n")
    if found is not None:
        print(f"{comparison_text(problem, found)}\n{difference_text(problem, found)}\n")
    print(printable(solution_text(problem, solution, certificate)))
    print()
    names, counts = (problem.samples.feature_names, problem.samples.class_names), leaf_counts(problem, tree)
    print(printable(tree_text(tree, *names, counts, asked.preparation.columns)))
    print()
    if doubt := warning_text(problem, tree):
        print(f"{doubt}\n")
