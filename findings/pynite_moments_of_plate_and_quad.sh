#!/usr/bin/env bash
# PyNite 3.2.0: the bending moments of add_plate and add_quad have opposite signs.
#
# Model: a simply supported square plate, 1 m, 10 mm, 8 x 8 elements with the same nodes in one order, 1 kPa on each.
# Navier's series: deflection 0.00406 q a^4 / D = 0.2217 mm, moment at the centre 47.9 N m/m. Both elements find
# both within 3 %, with deflections of one sign, but quads say +48 and plates -49: the same pressure pulls on one
# face or on the other, according to the element. Reinforcement by sign lands on the wrong face.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet PyNiteFEA==3.2.0 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
from Pynite import FEModel3D

N = 8


def solved(kind):
    model = FEModel3D()
    model.add_material("steel", 2e11, 2e11 / 2.6, 0.3, 7850.0)
    for j in range(N + 1):
        for i in range(N + 1):
            model.add_node(f"{i},{j}", i / N, j / N, 0)
            model.def_support(f"{i},{j}", True, True, i in (0, N) or j in (0, N), False, False, True)
    add, press = (getattr(model, name) for name in (f"add_{kind}", f"add_{kind}_surface_pressure"))
    for j in range(N):
        for i in range(N):
            add(f"{i},{j}", f"{i},{j}", f"{i + 1},{j}", f"{i + 1},{j + 1}", f"{i},{j + 1}", 0.01, "steel")
            press(f"{i},{j}", 1000.0)
    model.analyze(check_stability=False)
    return model


centre = f"{N // 2},{N // 2}"
plates, quads = solved("plate"), solved("quad")
for name, model, moment in (
    ("plate", plates, plates.plates[centre].moment(0, 0)),
    ("quad", quads, quads.quads[centre].moment(-1, -1)),
):
    print(name, f"{1e3 * model.nodes[centre].DZ['Combo 1']:.4f} mm", f"{np.ravel(moment)[0]:.1f} N m/m")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
plate 0.2255 mm -48.9 N m/m
quad 0.2218 mm 48.4 N m/m
SEEN
