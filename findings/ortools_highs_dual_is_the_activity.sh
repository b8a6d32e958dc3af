#!/usr/bin/env bash
# OR-Tools 9.15.6755, linear_solver with HIGHS_LP: dual_value() is the row's activity, reduced_cost() is 0.
#
# Model: maximise 3 x + 2 y, x + y <= 40, x <= 30 (a bound): optimum 110 at (30, 10). The dual of the row is 2 and the
# reduced cost of x is 1 (one unit more of either adds as much); GLOP and CLP say so. Through HiGHS the same calls give
# 40, which is x + y, and 0. The objective and the values are right, and nothing tells.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet ortools==9.15.6755 numpy==2.4.6 pandas==3.1.1 protobuf==6.33.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | grep -v -e '^Running HiGHS' | tee said
from ortools.linear_solver import pywraplp

for name in ("GLOP", "CLP", "HIGHS_LP"):
    solver = pywraplp.Solver.CreateSolver(name)
    solver.SuppressOutput()
    x = solver.NumVar(0, 30, "x")
    y = solver.NumVar(0, solver.infinity(), "y")
    row = solver.Add(x + y <= 40)
    solver.Maximize(3 * x + 2 * y)
    status = solver.Solve()
    value = round(solver.Objective().Value(), 6)
    words = [name, status == solver.OPTIMAL, value, "dual", round(row.dual_value(), 6)]
    print(*words, "reduced cost", round(x.reduced_cost(), 6), flush=True)
PROGRAM
diff said - <<'SEEN' && echo "as seen"
GLOP True 110.0 dual 2.0 reduced cost 1.0
CLP True 110.0 dual 2.0 reduced cost 1.0
HIGHS_LP True 110.0 dual 40.0 reduced cost 0.0
SEEN
