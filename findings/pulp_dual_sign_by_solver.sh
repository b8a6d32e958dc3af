#!/usr/bin/env bash
# PuLP 3.3.2: the sign of a constraint's dual (pi) and of a reduced cost (dj) under Maximize depends on the solver.
#
# Model: maximise 3 x + 2 y, x + y <= 4, x <= 3: optimum 11 at (3, 1). One unit more on the right side of the row adds
# 2, one unit more of the bound on x adds 1: d objective / d right side = +2, reduced cost +1.
# CBC (PuLP's own) reports these; HiGHS reports -2 and -1 for the same model and the same optimum. Under Minimize of
# -3 x - 2 y both report -2 and -1, as they should.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pulp==3.3.2 highspy==1.16.0
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | grep -v -e '^Running HiGHS' -e '^Includes' | tee said
import pulp

for sense, sign in ((pulp.LpMaximize, 1), (pulp.LpMinimize, -1)):
    for solver in (pulp.PULP_CBC_CMD(msg=False), pulp.HiGHS(msg=False)):
        model = pulp.LpProblem("model", sense)
        x = pulp.LpVariable("x", 0, 3)
        y = pulp.LpVariable("y", 0)
        model += sign * (3 * x + 2 * y)
        model += (x + y <= 4, "row")
        model.solve(solver)
        words = ["Maximize" if sign == 1 else "Minimize", solver.name, pulp.value(model.objective)]
        print(*words, "pi", model.constraints["row"].pi, "dj", x.dj)
PROGRAM
diff said - <<'SEEN' && echo "as seen"
Maximize PULP_CBC_CMD 11.0 pi 2.0 dj 1.0
Maximize HiGHS 11.0 pi -2.0 dj -1.0
Minimize PULP_CBC_CMD -11.0 pi -2.0 dj -1.0
Minimize HiGHS -11.0 pi -2.0 dj -1.0
SEEN
