"""Solvers outside octmip: those that Pyomo drives, and those that read a file and write another.

Each is here if its package is installed: highspy, pyscipopt, swiglpk, and pulp, which brings CBC's program.
"""

import importlib.util
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

PACKAGES = {"HiGHS": "highspy", "SCIP": "pyscipopt", "GLPK": "swiglpk", "CBC": "pulp"}
"""The package of each solver."""
DUAL_TOLERANCE = 1e-9
"""Given to each solver of `BY_PYOMO`: prices go to 10^6, and a bound is lowered by this times the sum of all ranges."""
TIGHT = {"mip_rel_gap": 0.0, "mip_abs_gap": 0.0, "dual_feasibility_tolerance": DUAL_TOLERANCE}


def is_installed(solver: str) -> bool:
    """Whether the package of a solver of `PACKAGES` is installed."""
    return importlib.util.find_spec(PACKAGES[solver]) is not None


def _highs(model: Any, seconds: float) -> Any:
    import pyomo.environ as pyo

    solver = pyo.SolverFactory("appsi_highs")
    solver.highs_options = TIGHT | {"time_limit": seconds}
    return solver.solve(model)


def _scip(model: Any, seconds: float) -> Any:
    from pyomo.contrib.solver.common.factory import SolverFactory

    options = {"numerics/dualfeastol": DUAL_TOLERANCE}
    return SolverFactory("scip_direct").solve(
        model, rel_gap=0.0, abs_gap=0.0, time_limit=seconds, solver_options=options
    )


def _cbc(model: Any, seconds: float) -> Any:
    import pulp  # type: ignore[import-untyped]  # without annotations
    import pyomo.environ as pyo

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # PuLP 4 brings CBC as a package of its own
        program = pulp.apis.PULP_CBC_CMD().path
    solver = pyo.SolverFactory("cbc", executable=program)
    solver.options.update({"ratioGap": 0, "allowableGap": 0, "dualTolerance": DUAL_TOLERANCE, "sec": seconds})
    return solver.solve(model)


BY_PYOMO: dict[str, Callable[[Any, float], Any]] = {"HiGHS": _highs, "SCIP": _scip, "CBC": _cbc}
"""Solves a ConcreteModel within so many seconds and returns Pyomo's results."""

PROGRAMS = {
    "HiGHS": """
import sys, highspy
h = highspy.Highs(); h.silent(); h.readModel(sys.argv[1]); h.run(); h.writeSolution(sys.argv[2], 0)
print(h.getInfo().mip_dual_bound)
""",
    "SCIP": """
import sys, pyscipopt
m = pyscipopt.Model(); m.hideOutput(); m.readProblem(sys.argv[1]); m.optimize(); m.writeBestSol(sys.argv[2])
print(m.getDualbound())
""",
    "GLPK": """
import sys
from swiglpk import *
glp_term_out(GLP_OFF)
P = glp_create_prob(); lp = sys.argv[1].endswith(".lp")
assert (glp_read_lp(P, None, sys.argv[1]) if lp else glp_read_mps(P, GLP_MPS_FILE, None, sys.argv[1])) == 0
c = glp_iocp(); glp_init_iocp(c); c.presolve = GLP_ON; assert glp_intopt(P, c) == 0; glp_print_mip(P, sys.argv[2])
assert glp_mip_status(P) == GLP_OPT; print(glp_mip_obj_val(P))
""",
    "CBC": """
import subprocess, sys, pulp
run = [pulp.apis.PULP_CBC_CMD().path, sys.argv[1], "ratioGap", "0", "allowableGap", "0", "solve", "solu", sys.argv[2]]
subprocess.run(run, check=True, stdout=subprocess.DEVNULL)
print(open(sys.argv[2]).readline().split("value")[1] if "Optimal" in open(sys.argv[2]).readline() else "-inf")
""",
}
"""Reads argv[1], solves it to the end, writes the solution to argv[2] and prints the bound."""


def solve_file(solver: str, model: Path, solution: Path, seconds: float) -> float:
    """Solve a model's file in a process of its own, write the solution's file and return the solver's bound.

    Raises
    ------
    subprocess.TimeoutExpired
        it takes longer than `seconds`.
    """
    command = [sys.executable, "-c", PROGRAMS[solver], str(model), str(solution)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=seconds)
    return float(done.stdout.split()[-1])
