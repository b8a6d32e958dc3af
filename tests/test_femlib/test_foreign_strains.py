"""Strains of another program beside femlib's: known fields, in the axes, heights and units of Nastran."""

from types import SimpleNamespace

import numpy as np
import pytest

from femlib import read
from femlib.errors import InputError
from femlib.material import isotropic_plate
from femlib.structure import Structure
from femlib.structure.foreign_strains import ForeignStrains, strains_beside, strains_of_op2
from femlib.structure.nastran import shell_numbers

STRAIN, CURVATURE = np.array([3e-4, -1e-4, 2e-4]), np.array([0.05, -0.02, 0.03])
"""xx, yy and engineering xy in global axes, at the reference surface, and their slopes along the normal [1/m]."""


def deck(n=4):
    """Return a strip of quadrilaterals and two triangles in mm, its nodes moved and its numbers mixed."""
    rng, lines, places = np.random.default_rng(3), [], {}
    for k in range(n + 2):
        for side in (0, 1):
            x, y = 100.0 * k + 8.0 * rng.normal(), 100.0 * side + 8.0 * rng.normal()
            places[10 * k + side + 1] = (x, y)
            lines.append(f"GRID    {10 * k + side + 1:8d}        {x:8.3f}{y:8.3f}      0.")
    for k in range(n):
        own = np.roll([10 * k + 1, 10 * k + 11, 10 * k + 12, 10 * k + 2], k)
        lines.append(f"CQUAD4  {500 - k:8d}       1" + "".join(f"{node:8d}" for node in own))
    for number, own in ((7, (10 * n + 1, 10 * n + 11, 10 * n + 12)), (8, (10 * n + 12, 10 * n + 2, 10 * n + 1))):
        lines.append(f"CTRIA3  {number:8d}       1" + "".join(f"{node:8d}" for node in own))
    return "BEGIN BULK\n" + "\n".join(lines) + "\nENDDATA\n"


@pytest.fixture
def strip(tmp_path):
    (tmp_path / "strip.bdf").write_text(deck())
    mesh = read(tmp_path / "strip.bdf", unit="mm")
    supports = {"held": "clamped"}
    nodes = {**mesh.node_sets, "held": [0, 1]}
    mesh = type(mesh)(mesh.nodes, mesh.quads, mesh.trias, mesh.lines, mesh.element_sets, nodes)
    plate = isotropic_plate(70e9, 0.3, 0.002, 2700.0)
    return Structure(mesh, {"property:1": plate}, supports), shell_numbers(tmp_path / "strip.bdf")


def moved(structure):
    """Return displacements (n_nodes, 6) whose strain and curvature are those above everywhere."""
    x, y, _ = structure.built.mesh.nodes.T
    (exx, eyy, exy), (kxx, kyy, kxy) = STRAIN, CURVATURE
    zero = np.zeros_like(x)
    u, v, w = exx * x + exy / 2 * y, eyy * y + exy / 2 * x, -(kxx * x**2 + kyy * y**2 + kxy * x * y) / 2
    return np.column_stack([u, v, w, -(kyy * y + kxy * x / 2), kxx * x + kxy * y / 2, zero])


def in_axes(corners, height):
    """Return the field's strain in an element's axes by the guide: x bisects the diagonals' angle, or is side 1-2."""
    if len(corners) == 3:
        angle = np.arctan2(*(corners[1] - corners[0])[[1, 0]])
    else:
        first, second = (np.arctan2(*(corners[b] - corners[a])[[1, 0]]) for a, b in ((0, 2), (3, 1)))
        angle = np.angle(np.exp(1j * first) + np.exp(1j * second))
    xx, yy, xy = STRAIN + height * CURVATURE
    tensor = np.array([[xx, xy / 2], [xy / 2, yy]])
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    own = turn @ tensor @ turn.T
    return [own[0, 0], own[1, 1], 2 * own[0, 1]]


def table(structure, numbers, kind=4, with_corners=False, **other):
    """Return what pyNastran holds of the elements with so many corners: centre rows at two heights, in mm."""
    mesh, rows, data = structure.built.mesh, [], []
    for number, k in numbers.items():
        corners = mesh.nodes[mesh.corners_of(k)]
        if len(corners) == kind:
            for place in range(1 + with_corners * kind):
                rows += [[number, place]] * 2
                data += [[z, *np.array(in_axes(corners, 1e-3 * z)) * (1 + place), 0, 0, 0, 0] for z in (-1.0, 1.0)]
    return SimpleNamespace(is_stress=False, is_fiber_distance=True, element_node=rows, data=[data], **other)


@pytest.mark.parametrize("kind", [3, 4])
@pytest.mark.parametrize("with_corners", [False, True])
def test_strains_of_one_field_do_not_differ(strip, kind, with_corners):
    structure, numbers = strip
    foreign = strains_of_op2(table(structure, numbers, kind, with_corners), metres=1e-3)
    found = strains_beside(structure, moved(structure), foreign, numbers)
    assert found["element"].tolist() == [
        number for number in ([500, 499, 498, 497] if kind == 4 else [7, 8]) for _ in "ab"
    ]
    assert found["height"].tolist() == [-1e-3, 1e-3] * (len(found) // 2)
    assert np.abs(found[["own_xx", "own_yy", "own_xy"]]).min().max() > 10.0
    for name in ("xx", "yy", "xy"):
        assert found[f"own_{name}"].to_numpy() == pytest.approx(found[f"foreign_{name}"].to_numpy(), abs=1e-6)
        assert found[f"difference_{name}"].to_numpy() == pytest.approx(0.0, abs=1e-6)


def test_what_cannot_be_compared_is_one_sentence(strip):
    structure, numbers = strip
    whole = table(structure, numbers)
    for wrong, said in (
        (SimpleNamespace(is_stress=True), "holds stresses, or strains of plies; expected those of plates"),
        (SimpleNamespace(is_stress=False, data=[]), "holds stresses, or strains of plies; expected those of plates"),
        (SimpleNamespace(is_stress=False, is_fiber_distance=False, element_node=[]), "curvatures of the reference"),
    ):
        with pytest.raises(InputError, match=said):
            strains_of_op2(wrong, metres=1e-3)
    with pytest.raises(InputError, match="step 1 of a table of 1; expected 0 to 0"):
        strains_of_op2(whole, metres=1e-3, step=1)
    with pytest.raises(InputError, match=r"strain at -1 m, which is 1e\+03 of half its thickness.*unit of length"):
        strains_beside(structure, moved(structure), strains_of_op2(whole, metres=1.0), numbers)
    with pytest.raises(InputError, match="element 9 is not in the mesh; expected one of 6"):
        strains_beside(structure, moved(structure), ForeignStrains([9], [0.0], [[0.0, 0.0, 0.0]]), numbers)


def test_a_table_of_pynastran_itself_is_read(strip):
    plates = pytest.importorskip("pyNastran.op2.tables.oes_stressStrain.real.oes_plates")
    structure, numbers = strip
    own = table(structure, numbers)
    data = np.array(own.data, dtype="float32")
    held = plates.RealPlateStrainArray.add_static_case(
        "OSTR1X", "CQUAD4", 1, np.array(own.element_node), np.ones(len(data[0]), dtype="int32"), data, 1
    )
    found = strains_beside(structure, moved(structure), strains_of_op2(held, metres=1e-3), numbers)
    assert len(found) == 8
    assert found["difference_xy"].to_numpy() == pytest.approx(0.0, abs=1e-3)
