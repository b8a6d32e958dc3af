"""The rows of a problem for other hands, and the way from anybody's answer back to a Solution that is certified.

The model minimises the whole-number prices of `octmip.trees.mip.prices`: the problem's own costs where they are whole
numbers. Nothing is left out of it because a better tree is known, so that rows that are added keep their meaning.
What a solver answers is not believed: the splits are read at mid-band, every sample is routed through the tree, and the
bound is lowered by what a solver's tolerances may have added to it (`octmip.trees.mip.highs.claims`).
`pyomo_model` gives the rows to Pyomo, `rows_file` to files.
"""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError, SolverError
from octmip.input.files import PathLike
from octmip.trees.answer.certificate import certify, checked_incumbent
from octmip.trees.answer.scope import within
from octmip.trees.answer.solution import Limits, Solution, Stop
from octmip.trees.methods.options import MipOptions
from octmip.trees.mip import flow, oct, oct_h
from octmip.trees.mip.blocks.heap import place, to_tree
from octmip.trees.mip.engine import START_SLACK, Clock, Formulate, Formulation, check_heap, decode, refutation
from octmip.trees.mip.highs.claims import COARSEST_DUAL, foreign_bound
from octmip.trees.mip.highs.highs import Outcome
from octmip.trees.mip.incumbent import starting_tree
from octmip.trees.mip.prices import own_prices, whole_prices
from octmip.trees.mip.result import Known, RunResult
from octmip.trees.mip.result import solution_of as solution_of_run
from octmip.trees.mip.rows import Rows
from octmip.trees.mip.rows_file import read_values, title_of, write_rows, write_values
from octmip.trees.nodes.reached import without_empty_sides
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.question.problem_values import refuse_missing

FORMULATIONS: Mapping[str, Formulate] = {
    "oct": oct.formulate,
    "oct_h": oct_h.formulate,
    "flow": partial(flow.formulate, fix=0),
}
"""The models that there are, by method; none of them leaves out a cut because a better tree is known."""
MOST_VIOLATION = 1e-4
"""By which a solution may break rows and integrality: ten times the coarsest default."""


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What a solver made of a model.

    Attributes
    ----------
    values
        (n_columns,) of its solution.
    bound
        its lower bound, in the units of the model's objective; -inf without one.
    solver
        its name.
    stop
        why it ended.
    added
        the names of what forbids solutions and is not the model's own: rows, sets, fixed values, narrower ends.
    activity
        the sum of the ranges of the activities of the rows among them.
    dual_tolerance
        by which its reduced costs may have the wrong sign.
    """

    values: NDArray[np.float64]
    bound: float = -math.inf
    solver: str = "another solver"
    stop: Stop = Stop.FINISHED
    added: tuple[str, ...] = ()
    activity: float = 0.0
    dual_tolerance: float = COARSEST_DUAL


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """The rows of a problem and the tree to start from; `pyomo_model` gives them to Pyomo.

    Attributes
    ----------
    problem, method
        what is asked, and the name of the formulation.
    formulation
        its rows, and the ways from a tree to a solution and back.
    known
        the tree to start from, its objective, the prices.
    """

    problem: Problem
    method: str
    formulation: Formulation
    known: Known

    def start(self, tree: Node | None = None) -> NDArray[np.float64] | None:
        """Return the values (n_columns,) of a tree, of the one to start from by default; None: the model lacks it."""
        placed = place(self.known.tree if tree is None else tree, self.formulation.heap, self.problem.samples.features)
        values = self.formulation.start(placed)
        return None if values is None or self.formulation.rows.violation(values)[0] > START_SLACK else values

    def write(self, path: PathLike) -> None:
        """Write the model to a file (.lp or .mps); its first line says the problem's digest."""
        write_rows(self.formulation.rows, path, title_of(self.problem, self.method))

    def write_start(self, path: PathLike) -> None:
        """Write the tree to start from, line by line a column and its value (.mst).

        Raises
        ------
        SolverError
            the model does not hold the tree.
        """
        if (values := self.start()) is None:
            raise SolverError(
                f"the tree to start from is outside the model, which holds {self.formulation.scope.trees}"
            )
        write_values(self.formulation.rows, values, path, title_of(self.problem, self.method))

    def read(
        self,
        path: PathLike,
        bound: float = -math.inf,
        solver: str = "another solver",
        dual_tolerance: float = COARSEST_DUAL,
    ) -> Solution:
        """Return the certified Solution of the file that a solver wrote; of its bound a file says nothing."""
        values = read_values(self.formulation.rows, path)
        return self.solution(Answer(values, bound, solver, dual_tolerance=dual_tolerance))

    def solution(self, answer: Answer) -> Solution:
        """Return the certified Solution of a solver's answer.

        Raises
        ------
        SolverError
            the values are no solution of the model, or the bound denies a tree that is one.
        CertificateError
            the tree breaks a limit of the problem.
        """
        formulation, values = self.formulation, answer.values
        worst, where = formulation.rows.violation(values)
        if worst > MOST_VIOLATION:
            raise SolverError(
                f"the solution of {answer.solver} breaks {where} by {worst:.3g}; give the "
                "method of the model that was solved, or solve it again"
            )
        decoded = decode(self.problem, formulation, values)
        price, bound = formulation.rows.objective(values), self._bound_of(answer)
        outcome = Outcome(values, price, price, answer.bound, Stop.FINISHED, "", 0, 0.0, math.inf, math.inf)
        if reason := refutation(self.problem, outcome, bound, decoded):
            raise SolverError(f"{reason.replace('HiGHS', answer.solver)}; solve it again with finer tolerances")
        tree, scope = decoded.tree, formulation.scope.trees
        if answer.added:
            tree = self._read(values)
            # Rows that no optimum needs, as other classes in sibling leaves, also narrow what an added row leaves.
            scope = (
                f"those of {scope} that are solutions of the model '{self.method}' and keep what was added to it "
                f"({named(answer.added)})"
            )
        elif (start := self.start()) is not None:
            self.refuse_above(formulation.rows.objective(start), answer)
        # A known tree outside the model, or against a row that was added, contradicts no bound.
        details: dict[str, object] = {"scope": within(self.problem, scope)} | (
            {"added": list(answer.added)} if answer.added else {}
        )
        result = RunResult(replace(self.known, tree=tree), tree, answer.stop, details, price_bound=bound)
        solution = solution_of_run(self.problem, result, method=self.method, seed=0, seconds=0.0, gap=0.0)
        certify(self.problem, solution)
        return replace(solution, version=answer.solver)

    def _bound_of(self, answer: Answer) -> int:
        """Return the price that no tree lies below by a solver's bound."""
        rows, prices = self.formulation.rows, self.formulation.prices
        return foreign_bound(rows, prices, answer.bound, answer.dual_tolerance, answer.activity)

    def _read(self, values: NDArray[np.float64]) -> Node:
        """Return the tree of values as they stand, but for splits that send all samples to one side."""
        heap, formulation = self.formulation.heap, self.formulation
        raw = to_tree(heap, formulation.splits(values), formulation.labels(values))
        return without_empty_sides(raw, self.problem.samples.features)

    def read_again(self, values: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return the values (n_columns,) of the tree of other values, None where those split the same nodes.

        A node that sends all samples to one side is a split in values, but in no tree. The nodes that both split keep
        their hyperplanes and thresholds.
        """
        formulation, families = self.formulation, self.formulation.rows.families
        read = formulation.splits(values)
        placed = place(self._read(values), formulation.heap, self.problem.samples.features)
        split = set(read)
        if "d" in families:
            split |= {m for m, j in zip(formulation.heap.branches, families["d"][0], strict=True) if values[j] > 0.5}
        if split == set(placed.splits):
            return None
        if (own := formulation.start(placed)) is None:
            return np.full_like(values, math.nan)
        for m, made in placed.splits.items():
            if m in read and read[m].features == made.features:
                columns = [families[letter][0][..., m - 1] for letter in ("a", "b") if letter in families]
                own[np.hstack(columns or [np.arange(0)])] = values[np.hstack(columns or [np.arange(0)])]
        return own

    def refuse_above(self, price: float, answer: Answer) -> None:
        """Raise a SolverError where a solver's bound denies a tree that the model holds and that keeps what was added.

        The bound is false, or it is one of another model: rows may have been taken away after it was solved.
        """
        bound = self._bound_of(answer)
        if bound > price + 0.5:
            raise SolverError(
                f"{answer.solver} claims that no tree is below {bound} but one of the model costs {price:g}: its "
                "answer is false, or that of another model; solve this one as it stands, without presolve, or with "
                "another solver"
            )


def named(names: tuple[str, ...], most: int = 4) -> str:
    """Return the first few of some names."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


def model_of(
    problem: Problem,
    method: str = "oct",
    *,
    start: Node | Solution | None = None,
    mu: float | None = None,
    seed: int = 0,
    limits: Limits = Limits(),  # noqa: B008  (frozen)
) -> Model:
    """Return the model of a problem, built within limits; the other arguments are those of `pyomo_model.model`.

    Raises
    ------
    ProblemError
        there is no such model, or none for this loss or split.
    SolverError
        a limit was reached.
    """
    if method not in FORMULATIONS:
        raise ProblemError(f"method is {method!r}; expected one of {', '.join(FORMULATIONS)}")
    if problem.loss.predicts != "class":
        raise ProblemError(f"the loss {problem.loss.name!r} has no mixed-integer model; expected classes")
    if problem.shape.leaf_weight is not None:
        raise ProblemError("leaf_weight is given, of which no model has a row; leave it out, or give a leaf_size")
    refuse_missing(problem.samples.n_missing, "the model has no side for them", "fill them in")
    rows = Rows(limit_check=Clock(limits, time.perf_counter()).check)
    check_heap(problem, rows)
    own = own_prices(problem)
    tree = starting_tree(problem, checked_incumbent(problem, start), seed)
    most = own.worst + own.penalty * (2**problem.shape.depth - 1) * problem.shape.max_split_size  # no tree costs more
    known = Known(tree, problem.objective(tree), whole_prices(problem, most), rows)
    options = MipOptions(mu=mu)
    return Model(problem, method, FORMULATIONS[method](problem, known, options), known)
