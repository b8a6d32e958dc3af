#!/usr/bin/env bash
# python-can 4.6.1, Vector ASC log: "timestamps relative" is read as if it said "absolute".
#
# The second line of an ASC log says what its stamps are: "absolute", since the start of the measurement, or "relative",
# since the event before (asc2log of can-utils adds them up for this word). Log: four messages, 10 ms from one to the
# next, so by definition at 0.01, 0.02, 0.03 and 0.04 s. ASCReader gives all four the same time, 0.01 s: its word
# is compared with "absolute" for the date alone.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet python-can==4.6.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import can

HEAD = """date Wed Jan 1 00:00:00.000 2020
base hex  timestamps {}
internal events logged
// version 9.0.0
Begin Triggerblock Wed Jan 1 00:00:00.000 2020
   0.000000 Start of measurement
"""
for word, stamps in (("absolute", (0.01, 0.02, 0.03, 0.04)), ("relative", (0.01, 0.01, 0.01, 0.01))):
    with open("log.asc", "w") as log:
        log.write(HEAD.format(word))
        for number, stamp in enumerate(stamps):
            log.write(f"   {stamp:.6f} 1  100             Rx   d 1 0{number}\n")
        log.write("End TriggerBlock\n")
    with can.LogReader("log.asc") as reader:
        print(word, [message.timestamp for message in reader])
PROGRAM
diff said - <<'SEEN' && echo "as seen"
absolute [0.01, 0.02, 0.03, 0.04]
relative [0.01, 0.01, 0.01, 0.01]
SEEN
