#!/usr/bin/env bash
# lvm_read 1.26 (LabVIEW .lvm, of the makers of sdypy): with X_Columns Multi the last channels are lost.
#
# A LabVIEW measurement file has no column of x, one for all channels, or ("Multi") one before each channel. File: two
# channels of three samples, x a x b. read returns three of the four columns, x a x: channel b, the force, is not there
# and the last column, named X_Value, is a time. With No and One the same channels are whole. No error, no warning.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet lvm_read==1.26 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import lvm_read

warnings.simplefilter("error")
START = """LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t.
Multi_Headings\tYes
X_Columns\t{}
Time_Pref\tAbsolute
***End_of_Header***\t

Channels\t2
Samples\t3\t3
X0\t0\t0
Delta_X\t0.1\t0.1
***End_of_Header***
{}\tComment
"""
STRAIN, FORCE = (1, 2, 3), (10, 20, 30)
for columns, names in (("One", "X_Value\tstrain\tforce"), ("Multi", "X_Value\tstrain\tX_Value\tforce")):
    with open("test.lvm", "w") as file:
        file.write(START.format(columns, names))
        for number, (strain, force) in enumerate(zip(STRAIN, FORCE)):
            x = f"{number / 10:g}"
            file.write("\t".join([x, str(strain), *([x] if columns == "Multi" else []), str(force)]) + "\n")
    part = lvm_read.read("test.lvm", read_from_pickle=False, dump_file=False)[0]
    print(columns, part["Channel names"], part["data"].T.tolist())
PROGRAM
diff said - <<'SEEN' && echo "as seen"
One ['X_Value', 'strain', 'force'] [[0.0, 0.1, 0.2], [1.0, 2.0, 3.0], [10.0, 20.0, 30.0]]
Multi ['X_Value', 'strain', 'X_Value'] [[0.0, 0.1, 0.2], [1.0, 2.0, 3.0], [0.0, 0.1, 0.2]]
SEEN
