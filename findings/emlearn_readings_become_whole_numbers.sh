#!/usr/bin/env bash
# emlearn 0.23.2 with scikit-learn 1.9.1: convert() by its defaults cuts readings to whole numbers.
#
# Tree: class 0 below 0.5, class 1 above, readings 0.0 to 0.9; scikit-learn has them all right. emlearn.convert(tree)
# makes C code of int16_t readings and thresholds, neither scaled: 0.9 and 0.45 become 0, every reading class 1. The
# docstring says of dtype that it "can be used to enable quantization"; without it the readings are whole numbers
# already. With dtype="float" the code agrees with the tree. No warning by default. (It needs a C compiler.)
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet emlearn==0.23.2 scikit-learn==1.9.1 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import warnings

import emlearn
import numpy as np
from sklearn.tree import DecisionTreeClassifier

warnings.simplefilter("error")
readings = np.arange(10).reshape(-1, 1) / 10
tree = DecisionTreeClassifier(random_state=0).fit(readings, (readings[:, 0] > 0.45).astype(int))
print("tree", tree.predict(readings).tolist())
for words in ({}, {"dtype": "float"}):
    model = emlearn.convert(tree, method="inline", **words)
    print(words, [int(one) for one in model.predict(readings)], "int16_t" in model.save(name="model"))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
tree [0, 0, 0, 0, 0, 1, 1, 1, 1, 1]
{} [1, 1, 1, 1, 1, 1, 1, 1, 1, 1] True
{'dtype': 'float'} [0, 0, 0, 0, 0, 1, 1, 1, 1, 1] False
SEEN
