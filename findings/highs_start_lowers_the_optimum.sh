#!/usr/bin/env bash
# HiGHS 1.16.0: given a feasible start it says Optimal with objective 0, where its own solution costs 1.
#
# Model: 11 columns (eight of them 0 or 1) and 9 rows, objective split + r. The start keeps every row and costs 1, the
# optimum. Without a start 1.16.0 answers 1; 1.15.1 answers 1 in both cases.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat > "$folder/start.py" <<'PROGRAM'
import highspy

START = [0.0, 1, 1, 1, 1, 0, 1, 0, 0, 2, 0]

for start in (None, START):
    h = highspy.Highs()
    h.setOptionValue("output_flag", False)
    a, b, s, split, d, e, f, g = (h.addBinary() if k != 2 else h.addVariable(0, 1) for k in range(8))
    p, q, r = (h.addVariable() for _ in range(3))
    h.changeColCost(split.index, 1.0)
    h.changeColCost(r.index, 1.0)
    h.addConstrs(a + b == split, d + e == 1, f + g == 1, q - 2 * e == 2, p - 2 * e == 0)
    h.addConstrs(r - q - 4 * f >= -6, r + p - q - 4 * g >= -4, 2 * d - s <= 1, a + b - s >= 0)
    if start is not None:
        given = highspy.HighsSolution()
        given.col_value = start
        h.setSolution(given)
    h.run()
    status = h.modelStatusToString(h.getModelStatus())
    claimed, paid = h.getInfo().objective_function_value, h.val(split) + h.val(r)
    print(f"{h.version()}, {'with' if start else 'without'} a start: {status}, says {claimed:g}, costs {paid:g}")
PROGRAM
for version in 1.15.1 1.16.0; do
    python3 -m venv "$folder/$version"
    "$folder/$version/bin/pip" install --quiet "highspy==$version" numpy==2.4.6
    "$folder/$version/bin/python" "$folder/start.py"
done | grep -v -e '^Running HiGHS' -e '^Includes' | tee "$folder/said"
diff "$folder/said" - <<'SEEN' && echo "as seen"
1.15.1, without a start: Optimal, says 1, costs 1
1.15.1, with a start: Optimal, says 1, costs 1
1.16.0, without a start: Optimal, says 1, costs 1
1.16.0, with a start: Optimal, says 0, costs 1
SEEN
