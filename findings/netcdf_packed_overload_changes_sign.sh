#!/usr/bin/env bash
# netCDF4-python 1.7.5.1 and xarray 2026.9.0: a peak beyond the range of packed numbers changes its sign in silence.
#
# Strains packed as 16-bit whole numbers of 0.01 (range -327.68 to 327.67), with a fill value for gaps. 400.00 does not
# fit. By definition of packing (value = stored * scale_factor) there is no stored number for it: an error, a fill value
# or the end of the range would be safe. Both libraries write 40000 modulo 65536: 400.00 comes back as -255.36 and
# -400.00 as 255.36, with no warning.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet netCDF4==1.7.5.1.post1 xarray==2026.9.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import netCDF4
import numpy as np
import xarray as xr

warnings.simplefilter("error")
strain = np.array([1.0, 327.67, 400.0, -400.0])
with netCDF4.Dataset("one.nc", "w") as file:
    file.createDimension("time", 4)
    packed = file.createVariable("strain", "i2", ("time",), fill_value=-32768)
    packed.scale_factor = 0.01
    packed[:] = strain
with netCDF4.Dataset("one.nc") as file:
    print("netCDF4", np.round(file["strain"][:], 2).tolist())
packing = {"dtype": "int16", "scale_factor": 0.01, "_FillValue": -32768}
xr.Dataset({"strain": ("time", strain)}).to_netcdf("two.nc", engine="netcdf4", encoding={"strain": packing})
print("xarray", np.round(xr.open_dataset("two.nc")["strain"].values, 2).tolist())
PROGRAM
diff said - <<'SEEN' && echo "as seen"
netCDF4 [1.0, 327.67, -255.36, 255.36]
xarray [1.0, 327.67, -255.36, 255.36]
SEEN
