#!/usr/bin/env bash
# unyt 3.2.0: numpy.einsum gives a product the unit of one factor; numpy.hstack of two rows makes a table.
#
# a = (3, 4) m: a . a is 25 m^2, a . a for readings in mm is 25e6 mm^2, the same area. einsum says 25 m and
# 25,000,000 mm: converted to m, two answers for one pair of vectors, both of the wrong dimension. dot and @ are right.
# hstack of two rows of two numbers is by definition a row of four; of unyt arrays it is 2 x 2, vstack's answer.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet unyt==3.2.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import numpy as np
import unyt

warnings.simplefilter("error")
a = unyt.unyt_array([3.0, 4.0], "m")
for row in (a, a.to("mm")):
    print("einsum", np.einsum("i,i->", row, row).to("m"), "dot", np.dot(row, row).to("m**2"))
print("hstack", np.hstack([a, a]).shape, "of numbers", np.hstack([a.value, a.value]).shape)
PROGRAM
diff said - <<'SEEN' && echo "as seen"
einsum 25.0 m dot 25.0 m**2
einsum 25000.0 m dot 25.0 m**2
hstack (2, 2) of numbers (4,)
SEEN
