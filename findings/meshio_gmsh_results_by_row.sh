#!/usr/bin/env bash
# meshio 5.3.5: results in a file of gmsh go to nodes and elements by the order of their rows, not by their numbers.
#
# A row of $NodeData and $ElementData is the number of a node or element and its value, and gmsh's manual asks for no
# order. Two squares side by side: node k has the value 10 k and element k the value 100 k, listed from the last to the
# first. meshio gives node 1 the value of node 6 and element 1 that of element 2, in MSH 2.2 and 4.1 alike.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet meshio==5.3.5 numpy==2.3.5
cd "$folder"
"$folder/venv/bin/python" - <<'PROGRAM' | tee said
import contextlib
import io
from pathlib import Path

import meshio

points = ["0 0 0", "1 0 0", "2 0 0", "0 1 0", "1 1 0", "2 1 0"]
squares = ["1 2 5 4", "2 3 6 5"]


def results(kind, name, values):
    rows = [f"{number} {value}" for number, value in sorted(values.items(), reverse=True)]
    head = ["1", f'"{name}"', "1", "0.0", "3", "0", "1", str(len(rows))]
    return [f"${kind}", *head, *rows, f"$End{kind}"]


old = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", "6"]
old += [f"{k} {one}" for k, one in enumerate(points, 1)] + ["$EndNodes", "$Elements", "2"]
old += [f"{k} 3 2 1 1 {one}" for k, one in enumerate(squares, 1)] + ["$EndElements"]
new = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$Entities", "0 0 1 0", "1 0 0 0 2 1 0 0 0", "$EndEntities"]
new += ["$Nodes", "1 6 1 6", "2 1 0 6", *map(str, range(1, 7)), *points, "$EndNodes"]
new += ["$Elements", "1 2 1 2", "2 1 3 2", *(f"{k} {one}" for k, one in enumerate(squares, 1)), "$EndElements"]
told = results("NodeData", "at nodes", {k: 10.0 * k for k in range(1, 7)})
told += results("ElementData", "of elements", {k: 100.0 * k for k in (1, 2)})
for version, lines in (("2.2", old), ("4.1", new)):
    Path("mesh.msh").write_text("\n".join([*lines, *told, ""]))
    with contextlib.redirect_stdout(io.StringIO()):
        mesh = meshio.read("mesh.msh")
    print(version, "node 1 at", mesh.points[0].tolist(), "has", mesh.point_data["at nodes"][0], "truth 10.0")
    print(version, "element 1 has", mesh.cell_data["of elements"][0][0], "truth 100.0")
PROGRAM
diff said - <<'SEEN' && echo "as seen"
2.2 node 1 at [0.0, 0.0, 0.0] has 60.0 truth 10.0
2.2 element 1 has 200.0 truth 100.0
4.1 node 1 at [0.0, 0.0, 0.0] has 60.0 truth 10.0
4.1 element 1 has 200.0 truth 100.0
SEEN
