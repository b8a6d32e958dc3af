"""The mixed-integer forms beside each other on HiGHS: printed rows against flow rows, same start, limit and threads.

    oct, oct_h    the rows of Bertsimas & Dunn (unsplit nodes closed)
    flow 0        the flow rows, every cut in the model           flow h   the flow rows with hyperplanes
    flow 1        cuts fixed by class counts at the root, and at class boundaries
    flow 2        cuts fixed in pairs of root and child as well; at depth 2 these try every tree by themselves

Every form starts from the same tree, that of a local search (axis-aligned also for hyperplanes), which is not measured.
The limit is in CPU seconds of the whole process, so that a busy machine does not shorten a proof.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from benchmarks.cpu import cpu_limit, cpu_seconds
from benchmarks.data import Table, first_rows, published, synthetic_uav, uci
from benchmarks.problem_options import ProblemOptions
from benchmarks.tables import Line
from octmip.trees.certificate import certify
from octmip.trees.methods.search import local_search
from octmip.trees.mip.engine import solver_of
from octmip.trees.mip.flow import formulate, solve_flow
from octmip.trees.mip.oct import solve_oct
from octmip.trees.mip.oct_h import solve_oct_h
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution, Stop
from octmip.trees.tree import Node

Form = Callable[..., Solution]

AXIS: dict[str, Form] = {
    "oct": solve_oct,
    "flow 0": solver_of("flow", partial(formulate, fix=0)),
    "flow 1": solver_of("flow", partial(formulate, fix=1)),
    "flow 2": solve_flow,
}
HYPERPLANE: dict[str, Form] = {"oct_h": solve_oct_h, "flow h": solve_flow}


@dataclass(frozen=True, slots=True)
class Question:
    """One problem, in words and as arrays, and the forms that answer it."""

    size: str
    table: Callable[[], Table]
    options: ProblemOptions
    forms: dict[str, Form]


def questions() -> Iterator[Question]:
    """Yield the questions, short ones first."""
    for depth in (1, 2):
        for name in ("iris", "wine"):
            yield Question(f"{name}, depth {depth}", partial(uci, name), {"depth": depth}, AXIS)
        for target in ("mu1", "mu2"):
            yield Question(f"published {target}, 175 rows, depth {depth}", _rows(target, 175), {"depth": depth}, AXIS)
    for n in (350, 1750):
        yield Question(f"published mu2, {n} rows, depth 1", _rows("mu2", n), {"depth": 1}, AXIS)
    synthetic = partial(first_rows, synthetic_uav("B"), 175)
    yield Question("synthetic B, 175 rows, depth 2", synthetic, {"depth": 2}, AXIS)
    for depth in (1, 2):
        for size in (None, 2):
            for name, table in (
                ("iris", partial(uci, "iris")),
                ("wine", partial(uci, "wine")),
                ("published mu1, 175 rows", _rows("mu1", 175)),
            ):
                words = "any features" if size is None else f"at most {size} features"
                options: ProblemOptions = {"depth": depth, "split": "hyperplane", "split_size": size}
                yield Question(f"{name}, depth {depth}, hyperplanes, {words}", table, options, HYPERPLANE)


def _rows(target: str, n: int) -> Callable[[], Table]:
    return lambda: first_rows(published(target, 0), n)


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each question and form."""
    for question in questions():
        table = question.table()
        problem = Problem(table.features, table.labels, **question.options)
        axis = Problem(table.features, table.labels, depth=problem.depth)
        start = local_search(axis, limits=Limits(seconds=5)).tree
        assert start is not None
        for name, form in question.forms.items():
            for count in threads:
                measured = _measure(form, problem, start, limit, count)
                yield {"size": question.size, "form": name, "threads": count, "limit": limit, "seed": 0} | measured


def _measure(form: Form, problem: Problem, start: Node, limit: float, threads: int) -> Line:
    before = cpu_seconds()
    solution = form(problem, incumbent=start, n_jobs=threads, **cpu_limit(limit))
    cpu = cpu_seconds() - before
    certify(problem, solution)
    said = solution.details
    return {
        "objective": solution.objective,
        "bound": solution.bound,
        "gap": round(solution.gap, 4),
        "stop": "CPU limit" if solution.stop is Stop.INTERRUPTED else str(solution.stop),
        "n_nodes": solution.n_nodes,
        "root_bound": said["root_bound"],
        "start": said["start"],
        "model": said["model"],
        "cuts": said.get("cuts"),
        "mu": said.get("mu"),
        "build_seconds": said["build_seconds"],
        "cpu_seconds": round(cpu, 3),
        "wall_seconds": round(solution.seconds, 3),
        "version": solution.version,
    }


def summary(lines: list[Line]) -> str:
    """Return the table: one row per question and form."""
    head = ["case", "form", "start", "found", "root bound", "bound", "gap", "nodes", "CPU s", "wall s", "stop"]
    table = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for line in lines:
        root = "-" if line["root_bound"] is None else f"{max(line['root_bound'], 0):.3g}"
        cells = [
            line["size"],
            line["form"],
            f"{line['start']['objective']:g}",
            f"{line['objective']:g}",
            root,
            f"{line['bound']:g}",
            f"{100 * line['gap']:.0f} %",
            str(line["n_nodes"]),
            f"{line['cpu_seconds']:.3g}",
            f"{line['wall_seconds']:.3g}",
            line["stop"],
        ]
        table.append("| " + " | ".join(cells) + " |")
    return "\n".join(table)
