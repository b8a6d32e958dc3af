#!/usr/bin/env bash
# pint 0.25.3: 60 revolutions a minute are 6.283 Hz.
#
# A shaft of 60 rpm turns once a second: 1 Hz, the place of its first order in a spectrum. pint takes a turn for 2 pi
# (the radian is dimensionless) and a hertz for 1/s, so the conversion answers 6.283 Hz and 50 Hz is 477 rpm; 1 cycle
# is 6.283 too, yet "1 Hz" is not "1 cycle a second". No error, no warning.
# unyt 3.2.0 and astropy refuse the conversion.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pint==0.25.3 unyt==3.2.0 astropy==8.0.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import astropy.units
import pint
import unyt

quantity = pint.UnitRegistry().Quantity
print("pint 60 rpm", round(quantity(60, "rpm").to("Hz").magnitude, 3), "Hz")
print("pint 50 Hz", round(quantity(50, "Hz").to("rpm").magnitude, 1), "rpm")
print("pint 1 cycle/s", round(quantity(1, "cycle/s").to("Hz").magnitude, 3), "Hz")
try:
    print("unyt", unyt.unyt_quantity(60, "rpm").to("Hz"))
except unyt.exceptions.UnitConversionError:
    print("unyt refuses")
try:
    print("astropy", (60 * astropy.units.cycle / astropy.units.min).to("Hz"))
except astropy.units.UnitConversionError:
    print("astropy refuses")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
pint 60 rpm 6.283 Hz
pint 50 Hz 477.5 rpm
pint 1 cycle/s 6.283 Hz
unyt refuses
astropy refuses
SEEN
