"""Meshes from files: the same plate through every format, with the names that the format keeps."""

import re

import meshio
import numpy as np
import pytest

from benchmarks.readers.universal import unv
from femlib.errors import InputError, MeshError
from femlib.structure import read
from tests.test_femlib.own_meshes import plate_mesh

GMSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
0 3 "corner"
1 1 "edge"
2 2 "skin"
$EndPhysicalNames
$Entities
1 1 2 0
1 0 0 0 1 3
1 0 0 0 0 1 0 1 1 0
1 0 0 0 1 1 0 1 2 0
2 1 0 0 2 1 0 1 2 0
$EndEntities
$Nodes
1 6 1 6
2 1 0 6
1
2
3
4
5
6
0 0 0
1 0 0
1 1 0
0 1 0
2 0 0
2 1 0
$EndNodes
$Elements
4 5 1 5
0 1 15 1
1 1
1 1 1 1
2 4 1
2 1 3 1
3 1 2 3 4
2 2 2 2
4 2 5 6
5 2 6 3
$EndElements
"""
MILLIMETRES = """    -1
   164
         5mm (milli newton)             2
   1.00000000000000000D+03   1.00000000000000000D+03   1.00000000000000000D+00
   2.73149999999999977D+02
    -1
"""
"""Units of a universal file."""


def write_med(path, source):
    """Write families as Salome has them: a group may be several, and a family in several groups."""
    mesh = meshio.read(source)
    tags = {"vertex": [-1], "line": [-2], "quad": [-3], "triangle": [-4, -4]}
    mesh.cell_data = {"cell_tags": [np.array(tags[block.type]) for block in mesh.cells]}
    mesh.cell_sets, mesh.point_data = {}, {"point_tags": np.array([2, 0, 0, 0, 0, 0])}
    mesh.cell_tags, mesh.point_tags = {-2: ["edge"], -3: ["skin"], -4: ["skin", "right"]}, {2: ["corner"]}
    meshio.write(path, mesh)


@pytest.mark.filterwarnings("ignore:.*left out of the mesh. 1 masses:femlib.errors.LeftOutWarning")
def test_a_universal_file_in_inches_of_four_digits_is_read_in_inches(tmp_path):
    path = tmp_path / "plate.unv"
    path.write_text(MILLIMETRES.replace("1.00000000000000000D+03", "3.93700D+01", 1) + unv())
    metres = tmp_path / "metres.unv"
    metres.write_text(unv())
    assert read(path, unit="in").nodes == pytest.approx(0.0254 * read(metres).nodes)


@pytest.mark.parametrize("form", ["4.1", "2.2", "unv", "quadratic unv", "med"])
@pytest.mark.filterwarnings("ignore:.*left out of the mesh. 1 masses:femlib.errors.LeftOutWarning")
def test_the_names_of_groups_are_kept(form, tmp_path):
    path = tmp_path / ("plate.unv" if "unv" in form else "plate.med" if form == "med" else "plate.msh")
    (tmp_path / "plate.msh").write_text(GMSH)
    if form == "2.2":
        meshio.write(path, meshio.read(path), file_format="gmsh22", binary=False)
    if form == "med":
        pytest.importorskip("h5py")
        write_med(path, tmp_path / "plate.msh")
    if "unv" in form:
        path.write_text(MILLIMETRES * (form == "unv") + unv(form != "unv"))
    found = read(path, unit="mm" if form == "unv" else "m", corners_only=form == "quadratic unv")
    assert found.nodes.max() == (0.002 if form == "unv" else 2.0)
    assert found.quads.tolist() == [[0, 1, 2, 3]]
    assert found.trias.tolist() == [[1, 4, 5], [1, 5, 2]]
    assert (len(found.quads), len(found.trias), len(found.lines)) == (1, 2, 1)
    assert found.elements_of("skin").tolist() == [True, True, True, False]
    assert found.nodes_of("edge").tolist() == [0, 3]
    assert found.nodes_of("corner").tolist() == [0]


GROUPS = {
    "a surface that its group turns": ("1 -2 0", True, {"edge": 1, "skin": 3}, [[5, 4, 1], [2, 5, 1]]),
    "no names, a surface in two": (
        "2 2 7 0",
        False,
        {"physical:1": 1, "physical:2": 3, "physical:7": 2},
        [[1, 4, 5], [1, 5, 2]],
    ),
}


@pytest.mark.parametrize("case", GROUPS)
def test_groups_of_gmsh_are_whole_without_names_and_with_turned_surfaces(case, tmp_path):
    entity, has_names, sets, trias = GROUPS[case]
    text = GMSH.replace("2 1 0 1 2 0\n$End", f"2 1 0 {entity}\n$End")
    (tmp_path / "plate.msh").write_text(text if has_names else re.sub(r"\$Phys(.|\n)*\$EndPhys.*\n", "", text))
    found = read(tmp_path / "plate.msh")
    assert {name: int(own.sum()) for name, own in found.element_sets.items()} == sets
    assert found.trias.tolist() == trias


@pytest.mark.parametrize(
    ("change", "told"),
    [
        # gmsh's reader makes a table as long as the largest number: 32 GB
        (("\n5\n6\n0 0 0", "\n5\n4000000000\n0 0 0"), "MemoryError"),
        (("$EndElements\n", ""), "not closed"),
        (("2 1 0\n$EndNodes", "2 1e12 0\n$EndNodes"), "node 5 lies at"),
    ],
)
def test_a_file_that_is_damaged_is_refused(change, told, tmp_path):
    (tmp_path / "plate.msh").write_text(GMSH.replace(*change))
    with pytest.raises((InputError, MeshError), match=told):
        read(tmp_path / "plate.msh")


DECK = """*HEADING
a plate of two parts
*NODE, NSET=EVERY
10, 0., 0., 0.
20, 1., 0., 0.
30, 1., 1., 0.
40, 0., 1., 0.
50, 2., 0., 0.
60, 2., 1., 0.
70, 3., 0., 0.
80, 3., 1., 0.
*ELEMENT, TYPE=S4R
5, 10, 20, 30, 40
*ELEMENT, TYPE=S4R, ELSET=Right
7, 20, 50, 60, 30
*Element, type=S3, elset=Right
8, 50, 70, 60
9, 70, 80, 60
*ELEMENT, TYPE=B31, ELSET=RIB
11, 20, 30
*ELSET, ELSET=LEFT
5
*ELSET, ELSET=BOTH, GENERATE
5, 7, 1
*ELSET, ELSET=ALL
LEFT, Right
*NSET, NSET=FOOT, GENERATE
10, 40, 30
*MATERIAL, NAME=M
"""


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("plate.inp", DECK.replace("7, 20, 50, 60, 30", "7, 20, 50, 60, 30, 40"), "element 7 has 5 nodes, expected 4"),
        ("plate.inp", DECK.replace("10, 40, 30", "10, 9000000000000000000, 30"), "as abaqus"),
        ("plate.bdf", "CEND\nBEGIN BULK\n$ nothing\n", "has no node"),
        ("plate.unv", MILLIMETRES + unv(), r"in 0\.001 m, but unit is 'm'; expected unit='mm'"),
        (
            "plate.unv",
            MILLIMETRES.replace("1.00000000000000000D+03", "1.09361D+00", 1) + unv(),
            r"in 0\.914403 m.*save it in one",
        ),
        ("plate.unv", unv()[:-200], "expected two about each dataset; was it cut"),
        (
            "plate.unv",
            unv().replace("         6         3\n", "         6        33\n"),
            r"of which \[33\] is not in the file",
        ),
        (
            "plate.unv",
            unv().replace("        94         1", "       115         1"),
            "element of kind descriptor 115",
        ),
        ("plate.unv", unv().replace("        94         1", "        91         1"), "has 4 nodes, a triangle 3"),
        ("plate.unv", unv().replace("    -1\n  2412", "    -1\n   780"), "elements in dataset 780"),
    ],
)
def test_a_file_with_too_few_or_too_many_rows_is_refused(name, text, told, tmp_path):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=told):
        read(tmp_path / name)


def test_the_sets_of_a_deck_are_its_own(tmp_path):
    """meshio alone gives RIGHT one block, ALL no blocks, and counts the blocks without the unnamed first one."""
    (tmp_path / "deck.inp").write_text(DECK)
    found = read(tmp_path / "deck.inp")
    sets = {name: np.flatnonzero(mask).tolist() for name, mask in found.element_sets.items()}
    assert sets == {"Right": [1, 2, 3], "RIB": [4], "LEFT": [0], "BOTH": [0, 1], "ALL": [0, 1, 2, 3]}
    assert found.nodes_of("FOOT").tolist() == [0, 3]
    assert len(found.nodes_of("EVERY")) == 8
    assert found.nodes_of("RIB").tolist() == [1, 2]


@pytest.mark.parametrize("ending", ["vtu", "vtk"])
def test_whole_numbers_of_vtk_are_sets(ending, tmp_path):
    mesh = plate_mesh()
    region = [np.where(np.arange(24) < 6, 1, 2), np.full(2, 7)]
    edge = np.where(mesh.points[:, 0] == 0.0, 1, 0)
    meshio.write(
        tmp_path / f"plate.{ending}",
        meshio.Mesh(
            mesh.points,
            mesh.cells,
            cell_data={"region": region, "stress": [np.ones(24), np.ones(2)]},
            point_data={"edge": edge},
        ),
    )
    found = read(tmp_path / f"plate.{ending}")
    assert {*found.element_sets} == {"region:1", "region:2", "region:7"}
    assert found.nodes_of("edge:1").tolist() == [0, 7, 14, 21, 28]


def test_shells_are_turned_to_face_away_from_a_point():
    mesh = plate_mesh()
    mesh.cells[0].data[3] = mesh.cells[0].data[3][::-1].copy()
    found = read(mesh).facing_away("skin", (0.3, 0.2, -1.0))
    turned = np.cross(*(found.nodes[found.quads[:, k]] - found.nodes[found.quads[:, 0]] for k in (1, 2)))
    assert (turned[:, 2] > 0.0).all()
