#!/usr/bin/env bash
# pyOMA-2 1.4.3: its import silences NumPy's warnings of division by zero and of invalid values, in the whole program.
#
# The logarithm of -1 warns before the import and is a silent NaN after it: pyoma2.functions.ssi calls np.seterr.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pyOMA_2==1.4.3 numpy==2.3.5 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np

print({kind: np.geterr()[kind] for kind in ("divide", "invalid")})
import pyoma2.algorithms

print({kind: np.geterr()[kind] for kind in ("divide", "invalid")})
PROGRAM
diff said - <<'SEEN' && echo "as seen"
{'divide': 'warn', 'invalid': 'warn'}
{'divide': 'ignore', 'invalid': 'ignore'}
SEEN
