#!/usr/bin/env bash
# pyNastran 1.4.1, PBARL.J(): the torsion constant of a rectangle is 0, that of a T is negative.
#
# A solid rectangle of 2 x 3 has the torsion constant 0.196 * 3 * 2^3 = 4.70 (Saint-Venant's series, computed below).
# J() gives 0.0, no error. For the T2 section (4 x 5, flange 0.3, web 0.2), near the sum of w t^3 / 3 = 0.0485, it
# gives -0.00016. I11 and I22 of the rectangle are right.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pyNastran==1.4.1 numpy==1.26.4 scipy==1.15.3
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
from pyNastran.bdf.bdf import BDF

odd = np.arange(1, 200, 2)
series = 1 - 192 / np.pi**5 * (2 / 3) * (np.tanh(odd * np.pi * 3 / 4) / odd**5).sum()
model = BDF(debug=None)
bar = model.add_pbarl(1, 1, "BAR", [2.0, 3.0])
print("rectangle: J", bar.J(), "truth", round(3 * 2**3 / 3 * series, 2), "I", bar.I11(), bar.I22())
print("T2: J", round(model.add_pbarl(2, 1, "T2", [4.0, 5.0, 0.3, 0.2]).J(), 5))
print("near", round(4 * 0.3**3 / 3 + 4.7 * 0.2**3 / 3, 4))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
rectangle: J 0.0 truth 4.7 I 4.5 2.0
T2: J -0.00016
near 0.0485
SEEN
