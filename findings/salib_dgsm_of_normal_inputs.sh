#!/usr/bin/env bash
# SALib 1.6.0, dgsm: for normal inputs the index that bounds the total effect takes mean and deviation for a range.
#
# Model: y = 3 a + b, a normal with mean 0 and deviation 1, b normal with mean 10 and deviation 0.5. Variance 9 + 0.25:
# a makes 97.3 % of it, b 2.7 %. The derivative measure bounds the total effect from above: for normal inputs it is
# deviation^2 * mean squared slope / variance, here exact. SALib samples the normals rightly, but its factor is
# (second bound - first bound)^2 / pi^2, which for "dists": "norm" is (deviation - mean)^2 / pi^2: 0.099 for a, a tenth
# of the true effect, and 0.989 for b. Sobol's indices of the same problem are right.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet SALib==1.6.0 numpy==2.4.6 scipy==1.17.1 pandas==3.1.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
from SALib.analyze import dgsm, sobol
from SALib.sample import finite_diff
from SALib.sample import sobol as sobol_sample

problem = {"num_vars": 2, "names": ["a", "b"], "bounds": [[0, 1], [10, 0.5]], "dists": ["norm", "norm"]}


def y(x):
    return 3 * x[:, 0] + x[:, 1]


print("truth", [round(part / 9.25, 2) for part in (9.0, 0.25)])
x = sobol_sample.sample(problem, 1024, seed=1)
print("sobol", np.round(sobol.analyze(problem, y(x), seed=1)["ST"].astype(float), 2).tolist())
x = finite_diff.sample(problem, 1000, seed=1)
print("dgsm", np.round(np.array(dgsm.analyze(problem, x, y(x), seed=1)["dgsm"], dtype=float), 2).tolist())
PROGRAM
diff said - <<'SEEN' && echo "as seen"
truth [0.97, 0.03]
sobol [0.97, 0.03]
dgsm [0.1, 0.99]
SEEN
