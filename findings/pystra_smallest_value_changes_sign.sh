#!/usr/bin/env bash
# pystra 1.6.0: a strength that is a smallest extreme value fails almost surely.
#
# GEVmin("R", 10, 2, 0.1) is to have the mean 10 and the deviation 2. Its density has the mean 8.16, and u_to_x, which
# the analyses draw from, returns the values with the other sign: its median is -8.58. With a load of 3 +- 1 the true
# probability of failure is 0.011; FORM says beta = -3.15, a probability of 0.999. A normal strength comes out right,
# and so do the distribution's own attributes mean and stdv.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet Pystra==1.6.0 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import contextlib
import io

import numpy as np
import pystra
from scipy.special import gamma
from scipy.stats import genextreme, norm

first, second = gamma(0.9), gamma(0.8)
scale = 0.2 / np.sqrt(second - first**2)
mirrored = genextreme(c=-0.1, loc=-10.0 - scale / 0.1 * (first - 1.0), scale=scale)
strength = -mirrored.rvs(1_000_000, random_state=0)
load = np.random.default_rng(0).normal(3.0, 1.0, 1_000_000)
numbers = strength.mean(), strength.std(), (strength < load).mean()
print("numpy mean {:.2f} deviation {:.2f} failure {:.3f}".format(*numbers))
x = np.linspace(-60.0, 60.0, 1_200_001)
for kind in (pystra.GEVmin("R", 10, 2, 0.1), pystra.Normal("R", 10, 2)):
    model = pystra.StochasticModel()
    model.addVariable(kind)
    model.addVariable(pystra.Normal("S", 3, 1))
    form = pystra.Form(stochastic_model=model, limit_state=pystra.LimitState(lambda R, S: R - S))
    with contextlib.redirect_stdout(io.StringIO()):
        form.run()
    mean = float(np.trapezoid(x * kind.pdf(x), x))
    median = float(kind.u_to_x(np.array([0.0]))[0])
    beta = float(np.ravel(form.getBeta())[0])
    print(type(kind).__name__, f"mean {mean:.2f} median {median:.2f} beta {beta:.2f} failure {norm.cdf(-beta):.3f}")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
numpy mean 10.00 deviation 2.00 failure 0.011
GEVmin mean 8.16 median -8.58 beta -3.15 failure 0.999
Normal mean 10.00 median 10.00 beta 3.13 failure 0.001
SEEN
