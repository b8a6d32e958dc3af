#!/usr/bin/env bash
# ObsPy 1.5.1, SAC: a record of 51,200 Hz is read as 50,000 Hz, every frequency in it 2.3 % too low.
#
# SAC keeps the interval of samples as a float of seconds, 1/51200 s to seven digits. The reader rounds it to whole
# microseconds (20 us); a UserWarning says so, the rate and all times are taken from the rounded number. Record: a sine
# of 1280 Hz, two seconds at 51,200 Hz, the usual rate of vibration measurements: its spectrum peaks at 1250 Hz and it
# lasts 48 ms too long. miniSEED keeps the same trace right; at 300 Hz SAC gives 300.03 Hz, at 3000 Hz 3003 Hz.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet obspy==1.5.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import struct
import warnings

import numpy as np
from obspy import Trace, read

warnings.simplefilter("ignore")

for rate in (51200.0, 3000.0, 300.0):
    time = np.arange(2 * int(rate)) / rate
    trace = Trace(np.sin(2 * np.pi * rate / 40 * time).astype(np.float32), {"sampling_rate": rate})
    for kind in ("MSEED", "SAC"):
        trace.write("trace", format=kind)
        back = read("trace", format=kind)[0]
        peak = np.fft.rfftfreq(back.stats.npts, back.stats.delta)[np.abs(np.fft.rfft(back.data)).argmax()]
        print(rate, kind, round(back.stats.sampling_rate, 3), "peak of", rate / 40, "at", round(peak, 3))
    with open("trace", "rb") as file:
        print("interval in the SAC file", f"{struct.unpack('<f', file.read(4))[0]:.6e}")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
51200.0 MSEED 51200.0 peak of 1280.0 at 1280.0
51200.0 SAC 50000.0 peak of 1280.0 at 1250.0
interval in the SAC file 1.953125e-05
3000.0 MSEED 3000.0 peak of 75.0 at 75.0
3000.0 SAC 3003.003 peak of 75.0 at 75.075
interval in the SAC file 3.333333e-04
300.0 MSEED 300.0 peak of 7.5 at 7.5
300.0 SAC 300.03 peak of 7.5 at 7.501
interval in the SAC file 3.333333e-03
SEEN
