#!/usr/bin/env bash
# HiGHS 1.16.0: a constant in the objective makes "Optimal" weaker: 2096 is returned for an optimum of 2125.
#
# Model: a knapsack of 60 items (whole weights and values, whole-number optimum 2125, found here by dynamic programming)
# with a constant added to the objective. A constant changes no choice. HiGHS divides its gap by the objective with the
# constant: at 1,000,000 the default mip_rel_gap of 1e-4 allows 100, so the search stops early, status Optimal.
# SCIP 10 (pyscipopt 6.3.0, default gap 0) and HiGHS with mip_rel_gap 0 give 2125 for each constant.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet highspy==1.16.0 pyscipopt==6.3.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | grep -v -e '^Running HiGHS' -e '^Includes' | tee said
import highspy
from pyscipopt import Model, quicksum

weights = [20 + (37 * i * i + 11 * i) % 79 for i in range(60)]
values = [weight + 1 + (53 * i * i + 29 * i) % 59 for i, weight in enumerate(weights)]
room = sum(weights) // 3


def highs(constant, gap=1e-4):
    model = highspy.Highs()
    model.setOptionValue("output_flag", False)
    model.setOptionValue("mip_rel_gap", gap)
    takes = [model.addBinary() for _ in weights]
    model.addConstr(sum(w * x for w, x in zip(weights, takes)) <= room)
    model.maximize(sum(v * x for v, x in zip(values, takes)) + constant)
    best = model.getInfo().objective_function_value - constant
    return round(best), model.modelStatusToString(model.getModelStatus())


def scip(constant):
    model = Model()
    model.hideOutput()
    takes = [model.addVar(vtype="B") for _ in weights]
    model.addCons(quicksum(w * x for w, x in zip(weights, takes)) <= room)
    model.setObjective(quicksum(v * x for v, x in zip(values, takes)) + constant, "maximize")
    model.optimize()
    return round(model.getObjVal() - constant)


best = [0] * (room + 1)
for weight, value in zip(weights, values):
    for left in range(room, weight - 1, -1):
        best[left] = max(best[left], best[left - weight] + value)
print("dynamic programming", best[room])
for constant in (0, 1_000_000):
    print("constant", constant, "HiGHS", *highs(constant), "gap 0", highs(constant, 0.0)[0], "SCIP", scip(constant))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
dynamic programming 2125
constant 0 HiGHS 2125 Optimal gap 0 2125 SCIP 2125
constant 1000000 HiGHS 2096 Optimal gap 0 2125 SCIP 2125
SEEN
