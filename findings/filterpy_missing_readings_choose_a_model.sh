#!/usr/bin/env bash
# filterpy 1.4.5: readings that are missing make the estimator of several models sure of one of them.
#
# `update(None)` is the documented way to say that a step has no reading. The state stays, as it should. But the
# likelihood of the filter is then that of a reading equal to the prediction, under the spread of the last step that had
# one, so the model of the smaller noise wins at every gap. Two models of a sensor, alike but for noise of variance 1
# and 25: after one reading 0.78 for the first, after four missing ones 0.998. `log_likelihood` counts gaps likewise.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet filterpy==1.4.5 numpy==2.4.6 scipy==1.17.1 matplotlib==3.11.2
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
from filterpy.kalman import IMMEstimator, KalmanFilter


def model(variance):
    kalman = KalmanFilter(dim_x=1, dim_z=1)
    kalman.F = kalman.H = kalman.P = np.eye(1)
    kalman.Q, kalman.R = 0.1 * np.eye(1), variance * np.eye(1)
    return kalman


models = IMMEstimator([model(1.0), model(25.0)], np.array([0.5, 0.5]), np.eye(2))
for reading in (0.1, None, None, None, None):
    models.predict()
    models.update(reading)
    logs = [float(np.round(kalman.log_likelihood, 3)) for kalman in models.filters]
    print(reading, "probabilities", [float(share) for share in models.mu.round(4)], "log likelihoods", logs)
PROGRAM
diff said - <<'SEEN' && echo "as seen"
0.1 probabilities [0.7786, 0.2214] log likelihoods [-1.292, -2.55]
None probabilities [0.9254, 0.0746] log likelihoods [-1.29, -2.55]
None probabilities [0.9776, 0.0224] log likelihoods [-1.29, -2.55]
None probabilities [0.9936, 0.0064] log likelihoods [-1.29, -2.55]
None probabilities [0.9982, 0.0018] log likelihoods [-1.29, -2.55]
SEEN
