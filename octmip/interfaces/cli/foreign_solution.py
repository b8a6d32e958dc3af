"""The solution of a solver outside octmip, brought back from its file: `octmip solve --read-solution`."""

import argparse
import math

from octmip.errors import DataError
from octmip.input.messages import shown
from octmip.trees.answer.solution import Limits, Solution
from octmip.trees.methods.options import MipOptions, Options
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem

MODELS = ("oct", "oct_h", "flow")
"""Methods whose models have files."""


def refuse_alone(arguments: argparse.Namespace) -> None:
    """Check that nothing is said of a solution where none is read.

    Raises
    ------
    DataError
        there is.
    """
    for name in ("of_model", "stated_bound"):
        if getattr(arguments, name) is not None:
            option = f"--{name.replace('_', '-')}"
            raise DataError(
                f"{option} says something of --read-solution FILE, which is not given; add it, or leave out {option}"
            )


def read_solution(
    arguments: argparse.Namespace, problem: Problem, options: Options, limits: Limits, start: Node | None
) -> Solution:
    """Return the certified solution of a file that a solver wrote, its stated bound lowered by what tolerances may add.

    Raises
    ------
    DataError
        the method has no model, the model's file is one of another problem, or the file is no solution of it.
    SolverError
        the values break a row, or the bound is false.
    """
    from octmip.trees.mip.model_rows import model_of
    from octmip.trees.mip.rows_file import read_title

    method = arguments.method
    if arguments.of_model is not None:
        method, digest = read_title(arguments.of_model)
        if digest != problem.digest():
            raise DataError(
                f"model {arguments.of_model} is one of the problem {digest[:12]}..., but the table makes the problem "
                f"{problem.digest()[:12]}...; expected the samples, weights and classes that it was written for; give "
                "the same table and columns"
            )
        if arguments.method not in ("auto", method):
            raise DataError(
                f"model {arguments.of_model} is one of {method}, but --method is {arguments.method}; leave --method out"
            )
    if method not in MODELS:
        raise DataError(
            f"--read-solution is given with --method {method}; expected one of {', '.join(MODELS)}, as the model was "
            "written by --option write=FILE; give it, or the model's file by --of-model"
        )
    mu = options.mu if isinstance(options, MipOptions) else None
    made = model_of(problem, method, start=start, mu=mu, seed=arguments.seed, limits=limits)
    return made.read(arguments.read_solution, _bound(arguments.stated_bound))


def _bound(stated: float | None) -> float:
    """Return the bound that a solver stated, -inf without one.

    Raises
    ------
    DataError
        it is not finite, or says nothing as it is below 0.
    """
    if stated is None:
        return -math.inf
    if not math.isfinite(stated):
        raise DataError(f"--stated-bound is {shown(stated)}; expected a number; leave it out where there is none")
    if stated <= -1:
        raise DataError(
            f"--stated-bound is {shown(stated)}; expected 0 or more, as no tree costs less; where the solver left out "
            "the constant of the objective, write the model again and solve that; else leave it out"
        )
    return stated
