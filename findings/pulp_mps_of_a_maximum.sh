#!/usr/bin/env bash
# PuLP 3.3.2: a maximum that goes through an MPS file comes back as a minimum, without its constant, and one reader
# takes its whole numbers for 0 or 1.
#
# Model: maximise 2 x + y + 5, x whole and >= 0, 0 <= y <= 7, x + y <= 9.5. Its optimum is 23.5 (x = 9, y = 0.5).
# writeMPS keeps the sense in a comment alone and leaves the constant out. PuLP's own fromMPS then returns a minimum
# (sense 1) with the constant 0, and HiGHS 1.16.0 minimises: 0. Maximised by hand, HiGHS has 18.5, but GLPK 5.0
# (swiglpk 5.0.13) 9.0: x, which has a lower bound and no upper one in the file, gets the upper bound 1 there.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pulp==3.3.2 highspy==1.16.0 swiglpk==5.0.13
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | grep -v -e '^Running HiGHS' -e '^Includes' | tee said
import highspy
import pulp
import swiglpk as glpk

model = pulp.LpProblem("maximum", pulp.LpMaximize)
x = pulp.LpVariable("x", 0, None, cat="Integer")
y = pulp.LpVariable("y", 0, 7)
model += 2 * x + y + 5
model += x + y <= 9.5
model.solve(pulp.HiGHS(msg=False))
print("PuLP", pulp.value(model.objective))
model.writeMPS("model.mps")
_, back = pulp.LpProblem.fromMPS("model.mps")
print("back: sense", back.sense, "constant", back.objective.constant)
highs = highspy.Highs()
highs.setOptionValue("output_flag", False)
highs.readModel("model.mps")
highs.run()
print("HiGHS", highs.getInfo().objective_function_value, "upper bound", highs.getLp().col_upper_[0])
highs.changeObjectiveSense(highspy.ObjSense.kMaximize)
highs.run()
print("HiGHS maximised", highs.getInfo().objective_function_value)
glpk.glp_term_out(0)
problem = glpk.glp_create_prob()
glpk.glp_read_mps(problem, glpk.GLP_MPS_FILE, None, "model.mps")
glpk.glp_create_index(problem)
print("GLPK upper bound", glpk.glp_get_col_ub(problem, glpk.glp_find_col(problem, "x")))
glpk.glp_set_obj_dir(problem, glpk.GLP_MAX)
options = glpk.glp_iocp()
glpk.glp_init_iocp(options)
options.presolve = 1
glpk.glp_intopt(problem, options)
print("GLPK maximised", glpk.glp_mip_obj_val(problem))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
PuLP 23.5
back: sense 1 constant 0.0
HiGHS 0.0 upper bound inf
HiGHS maximised 18.5
GLPK upper bound 1.0
GLPK maximised 9.0
SEEN
