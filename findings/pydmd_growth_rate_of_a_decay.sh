#!/usr/bin/env bash
# PyDMD 2025.8.1: growth_rate is not a rate of growth; a decay of 0.5 1/s is reported as a growth of 94.6 1/s.
#
# Data: 5 Hz, decaying as exp(-0.5 t), 400 samples 0.01 s apart, two modes. The eigenvalues are right: their logarithm
# over the step is -0.5 + 31.416 i. frequency takes this logarithm (5 Hz). growth_rate is the real part of the
# eigenvalue over the step: positive for each slow mode, growing or decaying. (For BOPDMD eigenvalues
# are logarithms already.)
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pydmd==2025.8.1 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import numpy as np
from pydmd import DMD, FbDMD, HODMD

warnings.simplefilter("ignore")
step = 0.01
time = np.arange(400) * step
shapes = np.random.default_rng(0).normal(size=(20, 2))
phases = np.array([np.cos(2 * np.pi * 5 * time), np.sin(2 * np.pi * 5 * time)])
snapshots = np.exp(-0.5 * time) * (shapes @ phases)
for model in (DMD(svd_rank=2), FbDMD(svd_rank=2), HODMD(svd_rank=2, d=5)):
    model.fit(snapshots)
    model.original_time["dt"] = step
    rate = np.log(model.eigs[0]).real / step
    words = [f"frequency {abs(model.frequency[0]):.2f}", f"log of the eigenvalue {rate:.2f}"]
    print(type(model).__name__, *words, f"growth_rate {model.growth_rate[0]:.1f}")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
DMD frequency 5.00 log of the eigenvalue -0.50 growth_rate 94.6
FbDMD frequency 5.00 log of the eigenvalue -0.50 growth_rate 94.6
HODMD frequency 5.00 log of the eigenvalue -0.50 growth_rate 94.6
SEEN
