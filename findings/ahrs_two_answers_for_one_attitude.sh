#!/usr/bin/env bash
# AHRS 0.4.0: one attitude has two sets of roll, pitch and yaw, by the class that is asked.
#
# An aircraft rolls by 10, pitches by 20 and yaws by 30 degrees. Quaternion(rpy=...).to_angles() gives these angles
# back. The rotation matrix of the same quaternion, asked by DCM.to_rpy, and orientation.q2euler give 1.1, -22.2 and
# -28.5: the angles of the inverse rotation. A roll alone comes back with the other sign. DCM(rpy=...) takes the three
# in reverse (its documentation says so), and its to_rpy does not give them back either.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet AHRS==0.4.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
from ahrs import DCM, Quaternion
from ahrs.common.orientation import q2euler


def degrees(angles):
    return [round(float(angle), 1) for angle in np.degrees(angles)]


for wanted in ([10.0, 20.0, 30.0], [10.0, 0.0, 0.0]):
    attitude = Quaternion(rpy=np.radians(wanted))
    print(wanted, "Quaternion.to_angles", degrees(attitude.to_angles()))
    print(wanted, "DCM.to_rpy", degrees(DCM(q=np.array(attitude)).to_rpy()))
    print(wanted, "q2euler", degrees(q2euler(np.array(attitude))))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
[10.0, 20.0, 30.0] Quaternion.to_angles [10.0, 20.0, 30.0]
[10.0, 20.0, 30.0] DCM.to_rpy [1.1, -22.2, -28.5]
[10.0, 20.0, 30.0] q2euler [1.1, -22.2, -28.5]
[10.0, 0.0, 0.0] Quaternion.to_angles [10.0, 0.0, 0.0]
[10.0, 0.0, 0.0] DCM.to_rpy [-10.0, -0.0, 0.0]
[10.0, 0.0, 0.0] q2euler [-10.0, -0.0, 0.0]
SEEN
