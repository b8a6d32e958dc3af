#!/usr/bin/env bash
# pyNastran 1.4.1, bdf_mirror: the original half is turned over; both halves get the mirrored fibres.
#
# Model: a square CQUAD4 at y > 0, normal +z, fibres at 30 degrees to x. Mirrored about the xz plane, the copy's fibres
# run at -30 degrees and the original stays: fibres at 30 degrees, normal +z. bdf_mirror keeps the original's number
# but gives it the nodes in the order that the copy should have: its normal is -z (pressure and offsets point the other
# way) and its fibres run at -30 degrees, as the copy's do. The halves are not mirror images.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pyNastran==1.4.1 numpy==1.26.4 scipy==1.15.3
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
from pyNastran.bdf.bdf import BDF
from pyNastran.bdf.mesh_utils.mirror_mesh import bdf_mirror


def report(model):
    model.cross_reference()
    for number, element in sorted(model.elements.items()):
        axes = element.material_coordinate_system()
        fibre = np.degrees(np.arctan(axes[2][1] / axes[2][0]))
        print(number, element.node_ids, "normal z", element.Normal()[2], "fibres at", round(float(fibre), 6))


model = BDF(debug=None)
model.add_mat1(1, 2.0e11, None, 0.3)
model.add_pshell(1, 1, 0.01)
for number, xyz in enumerate(([0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 2.0, 0.0]), 1):
    model.add_grid(number, xyz)
model.add_cquad4(1, 1, [1, 2, 3, 4], theta_mcid=30.0)
print("before")
report(model)
model.uncross_reference()
print("after")
report(bdf_mirror(model, plane="xz", debug=None)[0])
PROGRAM
diff said - <<'SEEN' && echo "as seen"
before
1 [1, 2, 3, 4] normal z 1.0 fibres at 30.0
after
1 [2, 1, 4, 3] normal z -1.0 fibres at -30.0
2 [5, 6, 7, 8] normal z -1.0 fibres at -30.0
SEEN
