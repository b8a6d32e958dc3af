#!/usr/bin/env bash
# chaospy 4.3.21: ChiSquared(4) has the mean 5 and the variance 12.
#
# A chi-squared variable of k degrees of freedom, the sum of k squared standard normals, has mean k and variance 2 k.
# chaospy's takes a fourth argument nc, the noncentrality, whose default is 1, not 0: mean k + 1, variance
# 2 (k + 2). F and StudentT of the same package are central by default. (nc=0 gives NaN, Gamma(2, 2) the right one.)
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet chaospy==4.3.21 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import chaospy
import numpy as np
from scipy import stats

squares = (np.random.default_rng(0).normal(size=(1_000_000, 4)) ** 2).sum(axis=1)
print("sum of 4 squares", round(squares.mean(), 1), round(squares.var(), 1))
print("scipy", *(float(one) for one in stats.chi2(4).stats()))
for one in (chaospy.ChiSquared(4), chaospy.Gamma(2, 2)):
    print(one, round(float(chaospy.E(one)), 3), round(float(chaospy.Var(one)), 3))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
sum of 4 squares 4.0 8.0
scipy 4.0 8.0
ChiSquared(4) 5.0 12.0
Gamma(2, scale=2) 4.0 8.0
SEEN
