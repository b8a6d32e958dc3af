#!/usr/bin/env bash
# geomag 0.9.2015 beside ppigrf 2.1.0: the magnetic declination of 2026 comes from a model that ended in 2020.
#
# The package holds the World Magnetic Model 2015, valid to the end of 2019, and extrapolates to any date without a
# word. In 2017 it agrees with IGRF-14 within 1.1 degrees; in November 2026 it is off by 0.8 degrees in Anchorage, by
# 1.0 in northern Canada and by 3.3 at Resolute, which a magnetic heading then is too.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet geomag==0.9.2015 ppigrf==2.1.0 numpy==2.4.6 pandas==3.1.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import datetime
import warnings

import geomag
import numpy as np
import ppigrf

warnings.simplefilter("error", UserWarning)
for place, latitude, longitude in (("Anchorage", 61.2, -149.9), ("Canada", 60.0, -110.0), ("Resolute", 74.7, -94.97)):
    for year in (2017, 2026):
        east, north, _ = ppigrf.igrf(longitude, latitude, 0.0, datetime.datetime(year, 11, 1))
        truth = float(np.degrees(np.arctan2(east, north)).ravel()[0])
        told = geomag.declination(latitude, longitude, 0.0, datetime.date(year, 11, 1))
        print(place, year, f"IGRF {truth:.1f}, geomag {told:.1f}, difference {told - truth:.1f}")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
Anchorage 2017 IGRF 16.4, geomag 16.3, difference -0.1
Anchorage 2026 IGRF 14.0, geomag 13.2, difference -0.8
Canada 2017 IGRF 13.7, geomag 13.5, difference -0.2
Canada 2026 IGRF 12.6, geomag 11.6, difference -1.0
Resolute 2017 IGRF -21.6, geomag -22.7, difference -1.1
Resolute 2026 IGRF -14.7, geomag -17.9, difference -3.3
SEEN
