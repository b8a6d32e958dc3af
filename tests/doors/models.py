"""Models that go out as files to other solvers, and the solution files that these write."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from benchmarks.outside import PACKAGES, PROGRAMS, solve_file
from octmip.trees.mip.model_rows import Model, model_of
from octmip.trees.question.problem import Problem
from tests.doors.row import Refused, Row

# Ten samples that one split leaves with 3 errors. The constant of the flow model's objective is 10.
PROBLEM = Problem(
    [[3, 1], [0, 1], [1, 3], [1, 0], [1, 2], [3, 2], [3, 0], [3, 0], [2, 1], [0, 2]],
    [0, 1, 0, 0, 1, 0, 1, 1, 1, 0],
    depth=1,
)
STYLES = {0: "raw", 1: "pretty", 2: "GLPK's raw", 3: "GLPK's pretty", 4: "sparse"}
"""HiGHS's styles of a solution file."""
PYOMO = str.maketrans("[],", "()_")
"""How Pyomo spells names in files."""
Made = tuple[Path, float]


def _model(method: str) -> Model:
    return model_of(PROBLEM, method)


def _solved(solver: str, method: str, suffix: str, folder: Path) -> Made:
    """Return the solution that a solver writes for a model's file, and its bound."""
    pytest.importorskip(PACKAGES[solver])
    _model(method).write(folder / f"m{suffix}")
    return folder / "m.sol", solve_file(solver, folder / f"m{suffix}", folder / "m.sol", seconds=60)


def _styled(style: int, folder: Path) -> Made:
    """Return a solution file of HiGHS in one of its styles."""
    import highspy

    _model("oct").write(folder / "m.lp")
    highs = highspy.Highs()
    highs.silent()
    highs.readModel(str(folder / "m.lp"))
    highs.run()
    highs.writeSolution(str(folder / "m.sol"), style)
    return folder / "m.sol", highs.getInfo().mip_dual_bound


def _kept(method: str, file: str, line: str, folder: Path) -> Made:
    """Return a file in the form of a solver that is not free, a line for each column of CART's tree."""
    made = _model(method)
    given = zip(made.formulation.rows.column_names(), made.start() if made.start() is not None else [], strict=True)
    lines = [
        line.format(j=j, name=name.replace("[", "(").replace("]", ")"), value=value, pyomo=name.translate(PYOMO))
        for j, (name, value) in enumerate(given)
        if value
    ]
    (folder / "m.sol").write_text(file.format("\n".join(lines)))
    return folder / "m.sol", -math.inf


def _read(method: str, made: Made) -> tuple[float, float]:
    solution = _model(method).read(*made, "another solver")
    return solution.objective, solution.bound


def _row(writer: str, case: str, method: str, make: Callable[[Path], Made], answer: object) -> Row:
    return Row("Model.read", writer, case, make, partial(_read, method), answer)


ROWS = [
    _row(solver, f"{method}{suffix}", method, partial(_solved, solver, method, suffix), (3.0, 3.0))
    for solver in PROGRAMS
    for method, suffix in (("flow", ".mps"), ("oct", ".lp"))
]
ROWS += [
    _row("HiGHS", f"style {style}, {name}", "oct", partial(_styled, style), (3.0, 3.0))
    for style, name in STYLES.items()
    if style != 2
]
ROWS += [
    _row("HiGHS", "style 2, columns by number", "oct", partial(_styled, 2), Refused(("names no column", "--output"))),
]
KEPT: dict[str, tuple[str, str, object]] = {
    "GLPK 5.0": ("s mip 2 2 o 3\n{}\n", "j {j} {value:g}", Refused(("raw format",))),
    "Gurobi 12": ("# Objective value = 3\n{}\n# Objective value = 5\n", "{name} {value:g}", (3.0, 0.0)),
    "a solver that diverged": ("{}\n", "{name} nan", Refused(("the value nan", "expected finite numbers"))),
    "Xpress 9": ("{}\n", '"{name}","C",{value:g},0', (3.0, 0.0)),
    "Gurobi 12, JSON": ('{{"Vars":[{}]}}', '{{"VarName":"{name}","X":{value:g}}},', (3.0, 0.0)),
    "Pyomo 6.10": ("{}\n", "{pyomo} {value:g}", Refused(("as Pyomo does", "octmip.solution_of"))),
    "CPLEX 22": ("<variables>{}</variables>", '<variable name="{name}" index="{j}" value="{value:g}"/>', (3.0, 0.0)),
}
"""The form of a file, that of its lines, and the answer."""
ROWS += [
    _row(f"{writer}, kept", "its form", "oct", partial(_kept, "oct", file, line), answer)
    for writer, (file, line, answer) in KEPT.items()
]
