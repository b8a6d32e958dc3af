#!/usr/bin/env bash
# xlsx2csv 0.8.6 (workbook by openpyxl 3.1.5): numbers leave a workbook as they are displayed.
#
# A cell that holds 0.123456789 and shows two decimals becomes 0.12 in the CSV, 12.345 % becomes 12%, 1.23456789e-06
# becomes 0.000001, and 10:00:00.25 becomes 10:00:00. A workbook keeps all digits whatever it shows, and a column that a
# person made narrower loses its readings on the way; no option is on and nothing is said.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet xlsx2csv==0.8.6 openpyxl==3.1.5
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import datetime

import openpyxl
import xlsx2csv

book = openpyxl.Workbook()
book.active.append(["strain", "share", "compliance", "time"])
book.active.append([0.123456789, 0.12345, 1.23456789e-6, datetime.datetime(2026, 3, 1, 10, 0, 0, 250000)])
for cell, shown in (("A2", "0.00"), ("B2", "0%"), ("C2", "0.00E+00")):
    book.active[cell].number_format = shown
book.save("book.xlsx")
print(*(cell.value for cell in openpyxl.load_workbook("book.xlsx").active[2]), sep=",")
xlsx2csv.Xlsx2csv("book.xlsx").convert("book.csv")
print(open("book.csv").read().split()[1], *open("book.csv").read().split()[2:])
PROGRAM
diff said - <<'SEEN' && echo "as seen"
0.123456789,0.12345,1.23456789e-06,2026-03-01 10:00:00.250000
0.12,12%,0.000001,2026-03-01 10:00:00
SEEN
