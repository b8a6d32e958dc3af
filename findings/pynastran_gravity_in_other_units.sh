#!/usr/bin/env bash
# pyNastran 1.4.1, convert: gravity of 9810 mm/s^2 becomes 9,810,000 m/s^2.
#
# Model: a CONM2 of 1 t, a GRAV card of 9810 and a FORCE of 1000 N, in mm, Mg (t), s. Converted to m, kg, s the mass is
# 1000 kg, the force 1000 N and gravity 9.81 m/s^2. convert scales GRAV by (unit of force) / (unit of length), a factor
# 1000, where an acceleration takes (length) / (time^2), 0.001: the weight is a million times too large. The log says
# "accel_scale (F/L) = 1000 ???". ACCEL1 goes the same way.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pyNastran==1.4.1 numpy==1.26.4 scipy==1.15.3
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
from pyNastran.bdf.bdf import BDF
from pyNastran.bdf.mesh_utils.convert import convert

model = BDF(debug=None)
model.add_grid(1, [1000.0, 0.0, 0.0])
model.add_conm2(1, 1, 1.0)
model.add_grav(1, 9810.0, [0.0, 0.0, -1.0])
model.add_force(2, 1, 1000.0, [0.0, 0.0, -1.0])
model.cross_reference()
convert(model, ["m", "kg", "s"], units=["mm", "Mg", "s"])
print("x", model.nodes[1].xyz[0], "m, mass", model.masses[1].mass, "kg")
print("force", round(model.loads[2][0].mag, 6), "N")
print("gravity", round(model.loads[1][0].scale, 6), "m/s^2")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
x 1.0 m, mass 1000.0 kg
force 1000.0 N
gravity 9810000.0 m/s^2
SEEN
