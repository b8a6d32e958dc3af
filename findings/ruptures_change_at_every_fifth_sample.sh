#!/usr/bin/env bash
# ruptures 1.1.10: the exact searches for a change place it at a sample that is a multiple of five.
#
# A signal rises by 1 at sample 47, with noise of 0.01. Dynp, which finds the optimum of a cost, says 45, and Pelt 45
# and 50; where it rises at 3, both say 5. By default (jump=5) only every fifth sample may begin a segment. Their
# answers cost 1.92 and 1.24 for an optimum of 0.01. With jump=1, and by KernelCPD, it is 47. Nothing is said.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet ruptures==1.1.10 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
import ruptures

for change in (47, 3):
    signal = (np.arange(100) >= change) + np.random.default_rng(0).normal(0.0, 0.01, 100)
    cost = ruptures.costs.CostL2().fit(signal)
    for search in (ruptures.Pelt, ruptures.Dynp):
        for settings in ({}, {"jump": 1}):
            wanted = {"pen": 0.5} if search is ruptures.Pelt else {"n_bkps": 1}
            found = search(model="l2", min_size=1, **settings).fit(signal).predict(**wanted)
            print(change, search.__name__, settings, found, round(float(cost.sum_of_costs(found)), 2))
    print(change, "KernelCPD", ruptures.KernelCPD(kernel="linear", min_size=1).fit(signal).predict(n_bkps=1))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
47 Pelt {} [45, 50, 100] 1.24
47 Pelt {'jump': 1} [47, 100] 0.01
47 Dynp {} [45, 100] 1.92
47 Dynp {'jump': 1} [47, 100] 0.01
47 KernelCPD [47, 100]
3 Pelt {} [5, 100] 1.2
3 Pelt {'jump': 1} [3, 100] 0.01
3 Dynp {} [5, 100] 1.2
3 Dynp {'jump': 1} [3, 100] 0.01
3 KernelCPD [3, 100]
SEEN
