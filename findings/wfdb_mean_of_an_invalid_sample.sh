#!/usr/bin/env bash
# wfdb 4.3.1 (WaveForm DataBase): an invalid sample of a fast channel becomes a large negative reading.
#
# Record: a slow channel of 1 sample a frame and a fast one of 2, 100 frames a second, format 16, 1000 units per mV.
# In format 16 the stored number -32768 means "no sample". rdrecord and rdsamp give by default one number a frame: the
# mean of its samples. The mean is taken of the stored numbers before -32768 is looked for: frame 2 of the fast channel
# holds 0.040 mV and an invalid sample and comes back as (40 - 32768) / 2 = -16.364 mV, neither NaN nor 0.040.
# With smooth_frames=False the same file gives 0.040 and NaN.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet wfdb==4.3.1 numpy==2.4.6 pandas==3.1.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
import wfdb

stored = np.arange(10).reshape(5, 2) * 10
stored[2, 1] = -32768
frames = np.column_stack([np.arange(5), stored]).astype("<i2")
frames.tofile("test.dat")
with open("test.hea", "w") as header:
    print("test 2 100 5", file=header)
    print("test.dat 16 1000(0)/mV 16 0 0 0 0 slow", file=header)
    print("test.dat 16x2 1000(0)/mV 16 0 0 0 0 fast", file=header)
print("stored", stored.ravel().tolist())
print("default", wfdb.rdrecord("test").p_signal[:, 1].tolist())
print("rdsamp", wfdb.rdsamp("test")[0][:, 1].tolist())
print("every sample", wfdb.rdrecord("test", smooth_frames=False).e_p_signal[1].tolist())
PROGRAM
diff said - <<'SEEN' && echo "as seen"
stored [0, 10, 20, 30, 40, -32768, 60, 70, 80, 90]
default [0.005, 0.025, -16.364, 0.065, 0.085]
rdsamp [0.005, 0.025, -16.364, 0.065, 0.085]
every sample [0.0, 0.01, 0.02, 0.03, 0.04, nan, 0.06, 0.07, 0.08, 0.09]
SEEN
