#!/usr/bin/env bash
# m2cgen 0.10.0 and treelite 4.8.1 with scikit-learn 1.9.1: exported trees differ from the tree at round readings.
#
# Trees fitted to readings of one decimal (0.0 to 10.0), applied to readings of two decimals. scikit-learn rounds
# a reading to float32 and compares it with a threshold midway between two float32 numbers; both exports compare the
# double as it is. At 0.15, between 0.1 and 0.2, the threshold is 0.15000000223517418: float32(0.15) is above it, 0.15
# below. Of 1001 readings ten (midpoints) get another leaf. An export of a model must give what the model
# gives; given readings rounded to float32, both do.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet m2cgen==0.10.0 treelite==4.8.1 scikit-learn==1.9.1 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import m2cgen
import numpy as np
import treelite
from sklearn.ensemble import RandomForestRegressor
from sklearn.tree import DecisionTreeRegressor

train = np.round(np.arange(101) * 0.1, 1).reshape(-1, 1)
target = np.arange(101.0)
readings = np.round(np.arange(1001) * 0.01, 2).reshape(-1, 1)
tree = DecisionTreeRegressor(random_state=0).fit(train, target)
forest = RandomForestRegressor(n_estimators=1, bootstrap=False, random_state=0).fit(train, target)
code = {}
exec(m2cgen.export_to_python(tree), code)
model = treelite.sklearn.import_model(forest)
for name, rows in (("double", readings), ("float32", readings.astype(np.float32).astype(float))):
    written = np.array([code["score"](row) for row in rows.tolist()])
    other = treelite.gtil.predict(model, rows).ravel()
    print(name, "m2cgen", (written != tree.predict(rows)).sum(), "treelite", (other != forest.predict(rows)).sum())
print("at 0.15: tree", tree.predict([[0.15]])[0], "m2cgen", code["score"]([0.15]))
PROGRAM
diff said - <<'SEEN' && echo "as seen"
double m2cgen 10 treelite 10
float32 m2cgen 0 treelite 0
at 0.15: tree 2.0 m2cgen 1.0
SEEN
