#!/usr/bin/env bash
# Neo 0.14.6, AsciiSignalIO: with all columns in one signal, the first channel's readings become the time stamps.
#
# File: a column of time with a gap (0, 0.1, 0.2, then 60.0, 60.1 s), a strain and a force. timecolumn=0 names the time.
# By definition both ways of grouping must say these five times. signal_group_mode="split-all" does;
# "all-in-one" takes column 0 of the table after the time is cut out of it: the strain is returned as time in seconds.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet neo==0.14.6 quantities==0.16.4 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import numpy as np
from neo.io import AsciiSignalIO

warnings.simplefilter("ignore")
time = [0, 0.1, 0.2, 60.0, 60.1]
np.savetxt("test.txt", np.column_stack([time, [7, 8, 9, 10, 11], [70, 80, 90, 100, 110]]), fmt="%g")
for mode in ("split-all", "all-in-one"):
    reader = AsciiSignalIO(
        "test.txt", delimiter=" ", timecolumn=0, time_units="s", units="mV", signal_group_mode=mode
    )
    signal = reader.read_block().segments[0].irregularlysampledsignals[0]
    print(mode, [round(float(one), 3) for one in signal.times], signal.times.dimensionality.string)
PROGRAM
diff said - <<'SEEN' && echo "as seen"
split-all [0.0, 0.1, 0.2, 60.0, 60.1] s
all-in-one [7.0, 8.0, 9.0, 10.0, 11.0] s
SEEN
