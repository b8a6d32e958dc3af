#!/usr/bin/env bash
# PySCIPOpt 6.3.0: under maximize the dual of a row has the other sign than the reduced cost of a column.
#
# Model: maximise 3 x + 2 y, x + y <= 4, x <= 3 (a bound). One unit more on the right side adds 2, one unit more of the
# bound adds 1, found here by solving again. getDualsolLinear says -2 for the row, getVarRedcost +1 for the bound.
# Under minimize of -3 x - 2 y both are negative and right. So no one change of sign repairs the answers of a maximum:
# the dual needs it, the reduced cost does not.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pyscipopt==6.3.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
from pyscipopt import SCIP_PARAMSETTING, Model


def solved(sign, right=4.0, bound=3.0):
    model = Model()
    model.hideOutput()
    model.setPresolve(SCIP_PARAMSETTING.OFF)
    model.setHeuristics(SCIP_PARAMSETTING.OFF)
    model.disablePropagation()
    x, y = model.addVar(lb=0, ub=bound), model.addVar(lb=0)
    row = model.addCons(x + y <= right)
    model.setObjective(sign * (3 * x + 2 * y), "maximize" if sign == 1 else "minimize")
    model.optimize()
    return model.getObjVal(), model.getDualsolLinear(row), model.getVarRedcost(x)


for sign in (1, -1):
    value, dual, reduced = solved(sign)
    print("maximize" if sign == 1 else "minimize", value)
    print("  row: adds", solved(sign, right=5.0)[0] - value, "dual", dual)
    print("  bound: adds", solved(sign, bound=4.0)[0] - value, "reduced cost", reduced)
PROGRAM
diff said - <<'SEEN' && echo "as seen"
maximize 11.0
  row: adds 2.0 dual -2.0
  bound: adds 1.0 reduced cost 1.0
minimize -11.0
  row: adds -2.0 dual -2.0
  bound: adds -1.0 reduced cost -1.0
SEEN
