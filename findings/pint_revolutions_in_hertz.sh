#!/usr/bin/env bash
# pint 0.25.3: 60 rpm are 6.283 Hz, and 1 Hz is 1 rad/s; 1 milliradian is 1000 ppm.
#
# Radian and count are pure numbers to pint, so every unit of rate converts into every other without a word. A shaft of
# 60 turns in a minute has 1 Hz; a recording of its speed in rpm, converted to the Hz of a model, is 2 pi too high.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pint==0.25.3
"$folder/venv/bin/python" - <<'PROGRAM' | tee "$folder/said"
import pint

unit = pint.UnitRegistry()
print(f"60 rpm = {unit('60 rpm').to('Hz').magnitude:.3f} Hz")
print(f"1 Hz = {unit('1 Hz').to('rad/s').magnitude:.3f} rad/s")
print(f"1 mrad = {unit('1 mrad').to('ppm').magnitude:.0f} ppm")
PROGRAM
grep -qx '60 rpm = 6.283 Hz' "$folder/said"
grep -qx '1 Hz = 1.000 rad/s' "$folder/said"
grep -qx '1 mrad = 1000 ppm' "$folder/said"
