#!/usr/bin/env bash
# fatpack 0.7.8: one spike in a record hides all cycles of rainflow counting.
#
# A hundred cycles of range 100 microstrain have a hundred ranges. With one sample of 20,000, such as an electrical
# disturbance, find_rainflow_ranges returns one range, that of the spike: by default it first sorts the readings into
# k=64 classes between their least and greatest, here 313 wide, and cycles within a class are gone. Whoever drops ranges
# that no structure has afterwards is left with none, a damage of 0. With k=8192 all hundred are there.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet fatpack==0.7.8 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import fatpack
import numpy as np

clean = 50.0 * np.sin(2.0 * np.pi * np.arange(0.0, 100.0, 0.01))
spike = clean.copy()
spike[5000] = 20000.0
for name, strain, settings in (("clean", clean, {}), ("spike", spike, {}), ("spike", spike, {"k": 8192})):
    ranges = fatpack.find_rainflow_ranges(strain, **settings)
    print(name, settings, "ranges below 1000:", int((ranges < 1000.0).sum()), "above:", int((ranges > 1000.0).sum()))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
clean {} ranges below 1000: 100 above: 0
spike {} ranges below 1000: 0 above: 1
spike {'k': 8192} ranges below 1000: 100 above: 1
SEEN
