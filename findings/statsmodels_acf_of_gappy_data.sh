#!/usr/bin/env bash
# statsmodels 0.15.0: acf(missing="conservative") is too small by the share of missing samples.
#
# Data: an autoregression x(t) = 0.8 x(t-1) + e(t), 30,000 samples, 30 % of them missing at random. Each pair of
# neighbours that are both there has the correlation 0.8. acf sums the pairs there and divides by all n, at lag 0
# and beyond alike: 0.49 n pairs over 0.7 n squares, so 0.56 where the mean over the pairs, pandas' autocorr and the
# Kalman filter of SARIMAX say 0.80. adjusted=True counts the pairs. The default, missing="none", gives NaN.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet statsmodels==0.15.0 numpy==2.4.6 scipy==1.17.1 pandas==3.1.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
import pandas as pd
from statsmodels.tsa.arima.model import ARIMA
from statsmodels.tsa.stattools import acf

random = np.random.default_rng(0)
noise = random.normal(size=30_000)
x = np.zeros(30_000)
for t in range(1, 30_000):
    x[t] = 0.8 * x[t - 1] + noise[t]
x[random.random(30_000) < 0.3] = np.nan
print("default", acf(x, nlags=1)[1])
print("conservative", round(acf(x, nlags=1, missing="conservative")[1], 2))
print("conservative, adjusted", round(acf(x, nlags=1, missing="conservative", adjusted=True)[1], 2))
print("pandas", round(pd.Series(x).autocorr(1), 2))
print("ARIMA", round(ARIMA(x[:5000], order=(1, 0, 0), trend="n").fit().params[0], 2))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
default nan
conservative 0.56
conservative, adjusted 0.8
pandas 0.8
ARIMA 0.8
SEEN
