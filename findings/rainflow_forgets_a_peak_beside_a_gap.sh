#!/usr/bin/env bash
# rainflow 3.2.0: a missing sample (NaN) takes the peak beside it out of the count.
#
# Stress: cycles of 10 MPa and one of 200 MPa, with a missing sample after its peak. Left out, it changes nothing: one
# cycle of 200 is counted. Given as NaN, the peak is no turning point (a slope to NaN has no sign) and the largest range
# is 10: by Miner's rule with the exponent 5 a millionth of the damage. No error, no warning.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet rainflow==3.2.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import numpy as np
import rainflow

warnings.simplefilter("error")
stress = np.array([0, 10, 0, 10, 0, 200, np.nan, 0, 10, 0, 10, 0])


def damage(series):
    return float(sum(number * span**5 for span, number in rainflow.count_cycles(series)))


for name, series in (("left out", stress[~np.isnan(stress)]), ("as NaN", stress)):
    ranges = [(float(span), float(number)) for span, number in rainflow.count_cycles(series)]
    print(name, ranges, f"damage {damage(series):.3g}")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
left out [(10.0, 4.0), (200.0, 1.0)] damage 3.2e+11
as NaN [(10.0, 4.0)] damage 4e+05
SEEN
