#!/usr/bin/env bash
# m2cgen 0.10.0 with scikit-learn 1.9.1: the code of a tree that learnt where missing readings go sends them right.
#
# Data: x below 0 is class 0, above 0 class 1; missing x is class 0. scikit-learn's tree sends NaN left (class 0) and
# keeps that in tree_.missing_go_to_left. m2cgen exports the tree without a word; its code asks `x <= threshold`, which
# NaN fails: class 1. The code of the tree that learnt "missing is class 1" is the same text.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet m2cgen==0.10.0 scikit-learn==1.9.1 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import m2cgen
import numpy as np
from sklearn.tree import DecisionTreeClassifier

x = np.array([-2.0, -1.0, 1.0, 2.0, np.nan, np.nan]).reshape(-1, 1)
texts = []
for label_of_missing in (0, 1):
    tree = DecisionTreeClassifier(max_depth=1, random_state=0).fit(x, [0, 0, 1, 1] + [label_of_missing] * 2)
    texts.append(m2cgen.export_to_python(tree))
    code = {}
    exec(texts[-1], code)
    answers = [int(np.argmax(code["score"](row))) for row in x.tolist()]
    print("missing is", label_of_missing, "tree", tree.predict(x).tolist(), "code", answers)
print("same code", texts[0] == texts[1])
PROGRAM
diff said - <<'SEEN' && echo "as seen"
missing is 0 tree [0, 0, 1, 1, 0, 0] code [0, 0, 1, 1, 1, 1]
missing is 1 tree [0, 0, 1, 1, 1, 1] code [0, 0, 1, 1, 1, 1]
same code True
SEEN
