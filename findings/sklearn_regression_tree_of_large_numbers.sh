#!/usr/bin/env bash
# scikit-learn 1.9.1, DecisionTreeRegressor: an offset of the target takes the tree away.
#
# Target: pressures of 0, 1, 3 and 4 Pa in four blocks of five rows, plus an offset. By definition the squared error of
# a split does not change when a constant is added to the target: four leaves, error 0. With the offset 1e8 (a pressure
# of 1000 bar in Pa) there is one leaf and an error of 2 Pa: the variance is the mean of squares less the square of the
# mean, its digits are gone (-4 here), and a node of no variance is not split. No warning.
# criterion="absolute_error" keeps the tree.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet scikit-learn==1.9.1 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
from sklearn.tree import DecisionTreeRegressor

reading = np.arange(20.0).reshape(-1, 1)
pressure = np.repeat([0.0, 1.0, 3.0, 4.0], 5)
for offset in (0.0, 1e8):
    for criterion in ("squared_error", "absolute_error"):
        tree = DecisionTreeRegressor(criterion=criterion, max_depth=2, random_state=0)
        error = np.abs(tree.fit(reading, pressure + offset).predict(reading) - offset - pressure).max()
        words = [f"offset {offset:.0f}", criterion, tree.get_n_leaves(), "leaves, largest error", error]
        print(*words, "impurity", tree.tree_.impurity[0])
PROGRAM
diff said - <<'SEEN' && echo "as seen"
offset 0 squared_error 4 leaves, largest error 0.0 impurity 2.5
offset 0 absolute_error 4 leaves, largest error 0.0 impurity 1.5
offset 100000000 squared_error 1 leaves, largest error 2.0 impurity -4.0
offset 100000000 absolute_error 4 leaves, largest error 0.0 impurity 1.5
SEEN
