#!/usr/bin/env bash
# anaStruct 1.7.0: a rotational spring at the end of an element is too soft.
#
# A cantilever of 4 m (EI 5000 kNm2) with 10 kN at its tip turns at the wall on a spring of k = 10,000 kNm/rad. Its tip
# goes down by P L^3 / 3 EI + P L^2 / k = 0.0587 m. With the spring given to the element (spring={1: k}), which the
# documentation has in kNm/rad, it is 0.0960 m, as with a spring of 3,000; with k = 100,000 that of 48,305. The same
# spring as a support (add_support_spring) gives 0.0587 m.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet anastruct==1.7.0 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
from anastruct import SystemElements


def tip(spring, support):
    system = SystemElements(EI=5000.0, EA=1e8)
    system.add_element([[0.0, 0.0], [4.0, 0.0]], spring=spring)
    support(system)
    system.point_load(2, Fy=-10.0)
    system.solve()
    return -float(system.get_node_displacements(2)["uy"])


def on_spring(system):
    system.add_support_hinged(1)
    system.add_support_spring(1, translation=3, k=k)


rigid = 10.0 * 4.0**3 / (3.0 * 5000.0)
for k in (1e6, 1e5, 1e4):
    element, support = tip({1: k}, lambda system: system.add_support_fixed(1)), tip(None, on_spring)
    print(f"k {k:.0f}: right {rigid + 160.0 / k:.4f}, support {support:.4f}, element {element:.4f}")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
k 1000000: right 0.0428, support 0.0428, element 0.0430
k 100000: right 0.0443, support 0.0443, element 0.0460
k 10000: right 0.0587, support 0.0587, element 0.0960
SEEN
