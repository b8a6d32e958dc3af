#!/usr/bin/env bash
# pint 0.25.3 and unyt 3.2.0: remainders of two units are taken of the bare numbers.
#
# 3 m hold 500 mm six times and leave 0; 370 degrees less one turn of 2 pi radians are 10 degrees. numpy.remainder and
# numpy.fmod of pint quantities give 3 m and 5.58 degrees: the second operand's unit is dropped (the operator % converts
# it). unyt does so with an operator: 3 m // 500 mm is 0, and numpy.divmod leaves 3 m. No error, no warning.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pint==0.25.3 unyt==3.2.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import numpy as np
import pint
import unyt

warnings.simplefilter("error")
quantity = pint.UnitRegistry().Quantity
long, short = quantity(3.0, "m"), quantity(500.0, "mm")
print("pint %", long % short, "remainder", np.remainder(long, short), "fmod", np.fmod(long, short))
angle, turn = quantity(370.0, "degree"), quantity(2 * np.pi, "radian")
print("pint angle %", round(angle % turn, 6), "remainder", round(np.remainder(angle, turn), 6))
long, short = unyt.unyt_quantity(3.0, "m"), unyt.unyt_quantity(500.0, "mm")
print("unyt /", (long / short).to("dimensionless"), "//", long // short, "divmod", *np.divmod(long, short))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
pint % 0.0 meter remainder 3.0 meter fmod 3.0 meter
pint angle % 10.0 degree remainder 5.575252 degree
unyt / 6.0 dimensionless // 0.0 dimensionless divmod 0.0 m 3.0 m
SEEN
