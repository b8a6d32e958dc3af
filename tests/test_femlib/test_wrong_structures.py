"""Structures, loads and gauges that have no answer: each gets one sentence instead of one."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sparse

from femlib.assembly import (
    Shells,
    Supports,
    deflect,
    factorise,
    line_load,
    natural_modes,
    point_masses,
    solution_quality,
    surface_load,
    thermal_load,
)
from femlib.components import Component, DamagedStructure, damage_row, port_flexibility
from femlib.errors import InputError, SolveError
from femlib.geometry import Planform
from femlib.material import Ply, isotropic_plate, laminate
from femlib.mesh import Mesh, QualityLimits
from femlib.rom import reduce_structure
from femlib.sensors import StrainGauge, strain_rows
from femlib.wing import ReducedWing, Wing
from femlib.wing.structure import WingMaterials
from tests.test_femlib.plates import grid_mesh
from tests.test_femlib.test_wrong_input import assert_one_sentence

MESH = grid_mesh(np.linspace(0, 1, 5), np.linspace(0, 1, 5))
SHEET = isotropic_plate(7e10, 0.3, 0.01, 2700.0)
PLY = Ply(1e11, 1e10, 0.3, 5e9, 5e9, 3e9, 1e-3)
WOVEN = laminate([PLY])
NO_TRIAS = np.zeros((0, 3), dtype=np.int64)
NAN = float("nan")


def shells(card: object = SHEET, section: object = None, axis: object = (0.0, 0.0, 0.0)) -> Shells:
    number = np.zeros(16) if section is None else section
    return Shells(MESH, (card,), number, np.ones(16), axis)


PLATE = shells()
HELD = Supports.clamping(MESH, np.arange(5))
LOAD = np.zeros(MESH.n_dofs)
LOAD[-4] = 1.0
ROWS = sparse.csr_array(np.eye(1, MESH.n_dofs, MESH.n_dofs - 4))
CORNER = np.arange(16) < 4


def mesh(nodes: object = MESH.nodes, quads: object = MESH.quads, patches: object = ("p",)) -> Mesh:
    return Mesh(nodes, quads, NO_TRIAS, patches, np.zeros(len(quads)))


def damaged(elements: object = CORNER, supports: Supports = HELD) -> DamagedStructure:
    return DamagedStructure(PLATE, supports, (Component("a", "mu", elements),))


def two_plates(gap: float) -> Mesh:
    """The plate and its copy, which shares no node with it, however small the gap."""
    nodes = np.concatenate([MESH.nodes, MESH.nodes + np.array([1.0 + gap, 0.0, 0.0])])
    return mesh(nodes, np.concatenate([MESH.quads, MESH.quads + 25]))


def gauge(position: object = (0.3, 0.3, 0.0), direction: object = (1.0, 0.0, 0.0)) -> StrainGauge:
    return StrainGauge("q", position, direction, ("plate",))


WRONG: list[tuple[Callable[[], object], str]] = [
    (lambda: Supports.holding(MESH, [2, 8]), r"with node 0 .25 of 25 nodes, 1 parts. can still move as a rigid body"),
    (
        lambda: Supports.clamping(two_plates(1.0), np.arange(5)),
        r"with node 25 .25 of 50 nodes, 2 parts. can still move",
    ),
    (lambda: Supports.clamping(mesh(np.vstack([MESH.nodes, [9, 9, 9]])), range(5)), "node 25 belongs to no element"),
    (lambda: Supports.clamping(MESH, [999]), "supports name 6 degrees of freedom, not all in 0 to 149"),
    (lambda: damaged(supports=Supports(7, [1, 3])), "supports are of 7 degrees of freedom but the mesh has 150"),
    (lambda: factorise(HELD.reduce(PLATE.stiffness()), np.arange(3)), "groups name the nodes of 3 rows but"),
    (lambda: shells(section=np.full(16, 3)), "element 0 has section 3; expected 0 to 0, the laminates' numbers"),
    (lambda: shells(card=PLY), "laminates are a tuple; expected a tuple of Laminate"),
    (lambda: shells(card=WOVEN), r"axis \[0.0, 0.0, 0.0\] is zero or normal to element 0, whose laminate's"),
    (lambda: shells(card=isotropic_plate(7e10, 0.3, 1e-9)), "laminate 0 is 1e-09 m thick on a mesh 1.41 m across"),
    (lambda: PLATE.stiffness(CORNER.astype(int)), "elements are int64 of shape .16,.; expected .16,. booleans"),
    (lambda: damaged(CORNER.astype(int)), "region a has elements of int64; expected booleans, one for each"),
    (lambda: damaged(np.zeros(16, dtype=bool)), "region a holds no element"),
    (lambda: damaged(np.ones(16, dtype=bool)), "region a shares no moving node with the rest of the structure"),
    (lambda: DamagedStructure(PLATE, HELD, Component("a", "mu", CORNER)), "components are a Component; expected a"),
    (lambda: damaged().solve_loads([0.1], LOAD, np.zeros(3)), r"pristine has shape \(3,\); expected \(150,\)"),
    (lambda: damaged().solve_outputs(np.array([[0.1]]), LOAD, ROWS[:, :7]), r"rows have shape \(1, 7\); expected"),
    (lambda: port_flexibility(damaged(), LOAD, ROWS, ()), "0 output names but 1 rows; expected one name per row"),
    (lambda: reduce_structure(damaged(), LOAD, ROWS[:, :7], ("a",)), r"rows have shape \(1, 7\); expected"),
    (lambda: damage_row({"mu": True}, ("mu",)), "state has {'mu': True}; expected fractions"),
    (lambda: damage_row([0.1], ("mu",)), "state is a list; expected damages by parameter name"),
    (lambda: line_load(MESH, [0, 6], np.ones(3)), "line load goes from node 0 to node 6, 0.354 m away, which no"),
    (lambda: surface_load(MESH, np.full((16, 3), NAN)), r"traction\[0, 0\] is nan; expected finite numbers"),
    (lambda: thermal_load(PLATE, np.zeros(3), np.zeros(16)), r"warming has shape \(3,\); expected \(16,\)"),
    (lambda: point_masses(MESH, {2: -1.0}), "point mass -1.0 kg at node 2; expected 0 kg or more"),
    (lambda: point_masses(MESH, [1.0]), r"point masses are \[1.0\]; expected masses by node"),
    (lambda: deflect(PLATE, HELD, LOAD, (1.0, 0.5)), r"load fractions are \[1.0, 0.5\]; expected increasing numbers"),
    (lambda: deflect(PLATE, HELD, np.zeros(3)), r"load has shape \(3,\); expected \(150,\)"),
    (
        lambda: deflect(PLATE, HELD, LOAD, thermal=(np.zeros((3, 3)), np.zeros((0, 18)))),
        r"thermal forces has shape \(3, 3\); expected \(16, 24\)",
    ),
    (lambda: deflect(PLATE, HELD, LOAD, tolerance=-1.0), "tolerance is -1.0; expected a share of the load"),
    (lambda: deflect(PLATE, HELD, LOAD, stiffness_factor=-np.ones(16)), "stiffness factor of element 0 is -1.0"),
    (lambda: solution_quality(PLATE, np.zeros(3)), r"displacements has shape \(3,\); expected \(150,\)"),
    (lambda: solution_quality(PLATE, LOAD).refuse(-1), "limit is -1; expected a share"),
    (lambda: laminate([]), "laminate got 0 plies"),
    (lambda: laminate(PLY), "laminate got a Ply; expected a list of Ply"),
    (
        lambda: replace(WOVEN, coupling=1e9 * np.eye(3)),
        "laminate membrane, coupling and bending is not positive definite",
    ),
    (lambda: replace(WOVEN, bending=np.triu(np.ones((3, 3)))), "laminate membrane, .* is not symmetric"),
    (lambda: replace(WOVEN, mass=NAN), "laminate mass is nan; expected a finite number"),
    (lambda: mesh(patches="p"), "mesh patches are 'p'; expected a tuple of names"),
    (lambda: mesh(patches=("p", "p")), "mesh patches are .*; expected each name once"),
    (lambda: mesh(quads=np.concatenate([MESH.quads, MESH.quads[2:3]])), "element 16 has the same corners as element 2"),
    (lambda: Mesh(MESH.nodes, MESH.quads, NO_TRIAS, ("p",), np.zeros(16), None), "mesh limits are None; expected"),
    (lambda: QualityLimits(warp=-1.0), "quality limit warp is -1.0; expected a number of 0 or more"),
    (lambda: QualityLimits(aspect=NAN), "quality limit aspect is nan; expected a number of 0 or more"),
    (lambda: strain_rows(MESH, np.full(16, 0.01), [gauge((0.3, 0.3, 0.3))]), r"lies 0.3 m off element 5 of .'plate'"),
    (lambda: strain_rows(MESH, np.full(16, 0.01), [gauge(direction=(0, 0, 1))]), "measures along the shell's normal"),
    (lambda: strain_rows(MESH, np.full(16, -0.01), [gauge()]), "thickness of element 0 is -0.01 m; expected more"),
    (lambda: strain_rows(MESH, np.full(16, 0.01), gauge()), "gauges are a StrainGauge; expected a list"),
    (
        lambda: Planform(1828.8, 435.61, 261.112, 0.3),
        "planform span is 1828.8 m; expected 0.001 to 100 m; give lengths",
    ),
    (lambda: WingMaterials(skin_young=1.11e3), "skin_young is 1110.0 Pa; expected 1e.06 to 1e.13 Pa"),
]


@pytest.mark.parametrize(("attempt", "sentence"), WRONG, ids=[sentence[:40] for _, sentence in WRONG])
def test_what_has_no_answer_gets_a_sentence(attempt: Callable[[], object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as told:
        attempt()
    assert_one_sentence(told.value)


@pytest.mark.parametrize(
    "attempt",
    [
        lambda: factorise(PLATE.stiffness(), np.arange(MESH.n_dofs) // 6),
        lambda: DamagedStructure(PLATE, Supports(MESH.n_dofs, np.arange(MESH.n_dofs)), ()).solve(
            np.zeros((1, 0)), LOAD
        ),
        lambda: natural_modes(PLATE, Supports(MESH.n_dofs, np.arange(1, MESH.n_dofs)), n_modes=1),
    ],
    ids=["factors", "components", "modes"],
)
def test_a_structure_that_is_not_held_has_no_factors(attempt: Callable[[], object]) -> None:
    with pytest.raises(
        SolveError, match=r"degrees of freedom is singular .*expected .*; hold its rigid motions"
    ) as told:
        attempt()
    assert_one_sentence(told.value)


def test_thin_structures_are_not_taken_for_singular() -> None:
    found = []
    for thickness in (1e-3, 1e-5, 1e-6):
        thin = shells(card=isotropic_plate(7e10, 0.3, thickness))
        moved = factorise(HELD.reduce(thin.stiffness()), HELD.groups).solve(LOAD[HELD.free])
        found.append(np.abs(moved).max() * thickness**3)
    assert found == pytest.approx([found[0]] * 3, rel=1e-3)


def test_answers_beyond_linear_analysis_are_refused(tiny: Wing, tiny_reduced: ReducedWing) -> None:
    for model in (tiny, tiny_reduced):
        with pytest.raises(
            InputError, match=r"strain would be .*e\+09 microstrain; expected at most 50000, beyond which"
        ):
            model.strain_microstrain({"mu1": 0.4}, 1e6)
        with pytest.raises(
            InputError, match=r"would .*; expected at most .*, beyond which linear analysis is meaningless"
        ):
            model.solve({"mu1": 0.4}, 1e6)
        assert np.isfinite(model.strain_microstrain({"mu1": 0.4}, -3.0)).all()
    with pytest.raises(InputError, match="strain would be"):
        tiny.strain_microstrain({}, 1.0, 1e6 * tiny.lift)
    with pytest.raises(InputError, match="strain would be"):
        tiny.strain_map(1e6)(np.zeros((1, 2)))
