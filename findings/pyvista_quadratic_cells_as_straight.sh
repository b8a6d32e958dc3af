#!/usr/bin/env bash
# PyVista 0.49.1 (VTK 9.7.2): integrals and slices of quadratic cells are those of a few linear pieces.
#
# Cell: a quadratic triangle with straight edges, (0, 0), (1, 0), (0, 1), and f = x^2, which its shape functions hold
# exactly. By definition the integral of f is 1/12 = 0.0833; integrate_data gives 0.1042, 25 % more. A quadratic
# hexahedron, the unit cube with f = x^2: the slice at x = 0.25 shows 0.125 for 0.0625; sample, which uses the shape
# functions, gives 0.0625 there. With a curved edge the area is short too (0.6 for 0.6333).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pyvista==0.49.1 vtk==9.7.2 numpy==2.3.5
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import numpy as np
import pyvista as pv

flat = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0]], dtype=float)
triangle = pv.UnstructuredGrid({pv.CellType.QUADRATIC_TRIANGLE: np.arange(6).reshape(1, 6)}, flat)
triangle["f"] = flat[:, 0] ** 2
print("integral", round(float(triangle.integrate_data()["f"][0]), 4), "truth", round(1 / 12, 4))
curved = flat.copy()
curved[3, 1] = -0.2
bulge = pv.UnstructuredGrid({pv.CellType.QUADRATIC_TRIANGLE: np.arange(6).reshape(1, 6)}, curved)
print("area", round(bulge.area, 4), "truth", round(0.5 + 2 / 3 * 0.2, 4))
low = [(0, 0), (1, 0), (1, 1), (0, 1)]
corners = np.array([(*one, z) for z in (0, 1) for one in low], dtype=float)
edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
points = np.vstack([corners, [corners[list(edge)].mean(axis=0) for edge in edges]])
cube = pv.UnstructuredGrid({pv.CellType.QUADRATIC_HEXAHEDRON: np.arange(20).reshape(1, 20)}, points)
cube["f"] = points[:, 0] ** 2
cut = cube.slice("x", origin=(0.25, 0.5, 0.5))["f"]
at = pv.PolyData([[0.25, 0.5, 0.5]]).sample(cube)["f"][0]
print("slice at 0.25:", float(cut.min()), "to", float(cut.max()), "sample", round(float(at), 4), "truth", 0.25**2)
PROGRAM
diff said - <<'SEEN' && echo "as seen"
integral 0.1042 truth 0.0833
area 0.6 truth 0.6333
slice at 0.25: 0.125 to 0.125 sample 0.0625 truth 0.0625
SEEN
