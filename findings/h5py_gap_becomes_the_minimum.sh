#!/usr/bin/env bash
# h5py (HDF5's scale-offset filter for floats): a gap (NaN) is read back as the smallest reading of its chunk.
#
# create_dataset(scaleoffset=3) keeps floats to three decimals as small whole numbers above the chunk's minimum. Data:
# 1.234, a gap, 2.5, -3.25. The gap has no place among these numbers; an error or NaN would be right. It comes back as
# -3.25, the minimum, also where fillvalue is NaN. compression="gzip" without the filter keeps the gap.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet h5py==3.16.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import h5py
import numpy as np

warnings.simplefilter("error")
readings = np.array([1.234, np.nan, 2.5, -3.25])
with h5py.File("test.h5", "w") as file:
    file.create_dataset("plain", data=readings, chunks=(4,), compression="gzip")
    file.create_dataset("scaled", data=readings, chunks=(4,), scaleoffset=3)
    file.create_dataset("filled", data=readings, chunks=(4,), scaleoffset=3, fillvalue=np.nan)
with h5py.File("test.h5") as file:
    for name in ("plain", "scaled", "filled"):
        print(name, file[name][:].tolist())
PROGRAM
diff said - <<'SEEN' && echo "as seen"
plain [1.234, nan, 2.5, -3.25]
scaled [1.234, -3.25, 2.5, -3.25]
filled [1.234, -3.25, 2.5, -3.25]
SEEN
