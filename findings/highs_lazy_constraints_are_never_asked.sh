#!/usr/bin/env bash
# highspy 1.16.0: the callback for lazy constraints can be subscribed to, and is never called.
#
# kCallbackMipDefineLazyConstraints has a descriptor of its own (Highs.cbMipDefineLazyConstraints), and subscribing
# raises nothing. A knapsack of 40 items and 12 rows takes some hundred nodes. Its branch and bound calls back for
# solutions, for the user's solutions and for the pool of cuts, and not once for lazy constraints. What a callback may
# hand back (HighsCallbackInput) has no place for a row either. So a master problem is solved again for each round of
# cuts.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet highspy==1.16.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import highspy
import numpy as np

model = highspy.Highs()
model.silent()
rng = np.random.default_rng(1)
taken = [model.addBinary() for _ in range(40)]
for _ in range(12):
    sizes = rng.integers(1, 60, 40)
    model.addConstr(sum(int(size) * one for size, one in zip(sizes, taken)) <= int(sizes.sum() // 3))
calls = dict.fromkeys(["cbMipDefineLazyConstraints", "cbMipSolution", "cbMipUserSolution", "cbMipGetCutPool"], 0)


def counter(name):
    def count(event):
        calls[name] += 1

    return count


for name in calls:
    getattr(model, name).subscribe(counter(name))
model.maximize(sum(int(worth) * one for worth, one in zip(rng.integers(1, 60, 40), taken)))
offered = [name for name in dir(highspy.cb.HighsCallbackInput) if not name.startswith("_")]
print(model.version(), model.getInfo().mip_node_count, "nodes", calls, offered)
assert calls["cbMipDefineLazyConstraints"] == 0
assert min(count for name, count in calls.items() if name != "cbMipDefineLazyConstraints") > 0
assert offered == ["repairSolution", "setSolution", "user_has_solution", "user_interrupt", "user_solution"]
PYTHON
