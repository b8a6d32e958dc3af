"""`octmip solve --target`: the best regression tree for a table, and the bound."""

import argparse
from functools import partial
from pathlib import Path

from octmip.certificate import Certificate, certify
from octmip.cli.answer import ProgressLine, print_json, print_notes, printable, then_written
from octmip.cli.regression.question import NumberQuestion, ask_numbers, tested
from octmip.cli.regression.words import (
    describe_numbers,
    errors_json,
    errors_text,
    numbers_text,
    numbers_tree_text,
    numbers_verdict,
)
from octmip.errors import DataError, SolverError
from octmip.formats.tree_file import read_tree_file, record_tree, tree_for, write_tree_file
from octmip.methods.interruption import held_back
from octmip.problem import Problem
from octmip.regression.proof_log import check_provable, write_regression_problem
from octmip.solution import Limits, ProofError, Solution
from octmip.solver import solve
from octmip.tree import Node


def solve_numbers(arguments: argparse.Namespace, limits: Limits) -> int:
    """Solve, show, write."""
    question = ask_numbers(arguments)
    options = _options(arguments, question.problem)
    unproven: ProofError | None = None
    with ProgressLine() as progress:
        try:
            solution = solve(
                question.problem,
                arguments.method,
                limits,
                _incumbent(arguments.incumbent, question),
                seed=arguments.seed,
                n_jobs=arguments.threads,
                progress=progress,
                options=options,
            )
        except ProofError as error:
            solution, unproven = error.solution, error
    if solution.tree is None:
        raise SolverError(f"{solution.solver} found no tree (stop: {solution.stop}); give it more time")
    with held_back():
        certificate = certify(question.problem, solution)
        _show(arguments, question, solution, certificate)
    if unproven is not None:
        raise unproven  # said last: the tree is shown and written all the same
    return 0


def _options(arguments: argparse.Namespace, problem: Problem) -> dict[str, object]:
    """Return the options of the solver; write the problem where that is asked, as files for a checker."""
    if arguments.write_problem:
        check_provable(problem)
        write_regression_problem(arguments.write_problem, problem)
    if not arguments.proof:
        return {}
    check_provable(problem)
    if arguments.method == "search":
        raise DataError("--proof logs what method exact proves; got --method search; leave one of the two out")
    return {"proof": Path(arguments.proof)}


def _incumbent(path: str | None, question: NumberQuestion) -> Node | None:
    """Return the tree of a file over the problem's features, which may stand in another order."""
    if path is None:
        return None
    return tree_for(question.problem, read_tree_file(path, "number"))


def _show(
    arguments: argparse.Namespace, question: NumberQuestion, solution: Solution, certificate: Certificate
) -> None:
    problem, columns = question.problem, question.preparation.columns
    file = record_tree(problem, solution, problem.target_name, question.weights_column, question.preparation)
    test = tested(arguments.test, problem, question.preparation, file.tree) if arguments.test else None
    last = numbers_verdict(problem, solution, certificate)
    with then_written(arguments.out, partial(write_tree_file, file=file), last, is_quiet=arguments.json):
        if arguments.json:
            more = {"threads": arguments.threads, "out": arguments.out, "notes": list(question.notes)}
            held = {} if test is None else {"held_out": errors_json(test)}
            print_json(describe_numbers(problem, solution, certificate) | more | held)
            return
        print_notes(question.notes)
        print(printable(numbers_text(solution, certificate, problem.loss.name, problem.n_samples)))
        print()
        of_table = None if columns.is_plain else columns
        print(printable(numbers_tree_text(file.tree, problem.feature_names, file.leaf_counts, of_table)))
        print()
        if test is not None:
            print(f"held out, {errors_text(test)}\n")
