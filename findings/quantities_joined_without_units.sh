#!/usr/bin/env bash
# quantities 0.16.4 (the units of Neo): numpy.concatenate of metres and millimetres gives pure numbers.
#
# 2 m and 500 mm joined are (2, 0.5) m or an error. The result is a Quantity of 2.0 and 500.0 "dimensionless": it passes
# for a quantity, adds to pure numbers and refuses to become metres. Also hstack, append and insert, and for two arrays
# of one unit. searchsorted and histogram compare across units without a word: 2 m is put before 500 mm.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet quantities==0.16.4 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import numpy as np
import quantities as pq

warnings.simplefilter("error")
metres, millimetres = [2.0] * pq.m, [500.0] * pq.mm
for words, joined in (
    ("concatenate", np.concatenate([metres, millimetres])),
    ("append", np.append(metres, millimetres)),
    ("one unit", np.hstack([metres, metres])),
):
    print(words, type(joined).__name__, joined.magnitude.tolist(), joined.dimensionality.string)
print("2 m before 500 mm", np.searchsorted(millimetres, metres).tolist() == [0])
print("2 m less than 500 mm", (metres < millimetres).tolist())
PROGRAM
diff said - <<'SEEN' && echo "as seen"
concatenate Quantity [2.0, 500.0] dimensionless
append Quantity [2.0, 500.0] dimensionless
one unit Quantity [2.0, 2.0] dimensionless
2 m before 500 mm True
2 m less than 500 mm [False]
SEEN
