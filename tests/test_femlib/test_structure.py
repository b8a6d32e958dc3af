"""Structures of the user's own: what is asked by name is what is solved, whole and reduced."""

import meshio
import numpy as np
import pytest

from femlib.elements import beam2
from femlib.material import isotropic_plate
from femlib.sensors import StrainGauge
from femlib.structure import ReducedStructure, Spring, Structure, read, rectangular_beam, reduce, write_vtu
from octmip.twin import Twin, predict_states
from tests.test_femlib.own_meshes import ALUMINIUM, corner_spring, plate_mesh, plate_with_mast

GAUGES = [
    StrainGauge("m1", (0.3, 0.2, 0.0), (1, 0, 0), ("middle",)),
    StrainGauge("s1", (0.1, 0.1, 0.0), (1, 0, 0), ("skin",)),
]


@pytest.fixture(scope="module")
def plate():
    return plate_with_mast(damage=("middle", "mast", "foot"), springs=(corner_spring(),), finer=2)


@pytest.fixture(scope="module")
def load(plate):
    return plate.pressure("skin", 50.0) + plate.point_load("top", (0.0, 2.0, 0.0)) + plate.gravity()


def section(**others):
    given = {"young": 70e9, "poisson": 0.3, "along_y": 0.02, "along_z": 0.05, "y_axis": (0, 1, 0), "density": 2700.0}
    return rectangular_beam(**(given | others))


def test_one_beam_bends_and_shears_as_timoshenko_says():
    own, length = section(), 0.3
    stiffness = beam2.stiffness(np.array([[[0, 0, 0], [length, 0, 0.0]]]), [own], np.zeros(1, dtype=int))[0]
    flexibility = np.diag(np.linalg.inv(stiffness[6:, 6:]))
    shear = length / (own.shear * own.area * 5 / 6)
    along_y, along_z = (length**3 / (3 * own.young * i) + shear for i in (own.inertia_z, own.inertia_y))
    expected = [length / (own.young * own.area), along_y, along_z, length / (own.shear * own.torsion)]
    np.testing.assert_allclose(flexibility[:4], expected, rtol=1e-9)


def test_a_rectangle_twists_as_the_series_says():
    assert section(along_y=1.0, along_z=1.0).torsion == pytest.approx(0.14058, rel=2e-3)
    assert section(along_y=1.0, along_z=10.0).torsion == pytest.approx(3.123, rel=2e-3)


def test_loads_by_name_have_their_resultants(plate):
    sums = [force.reshape(-1, 6)[:, :3].sum(axis=0) for force in (
        plate.pressure("skin", 100.0),
        plate.pressure("middle", 100.0),
        plate.point_load("right", (1.0, 2.0, 3.0)),
        plate.line_load("right", (0.0, 0.0, 10.0)),
        plate.line_load("mast", (0.0, 5.0, 0.0)),
        plate.gravity((0.0, 0.0, -10.0)),
    )]  # fmt: skip
    mass = 0.6 * 0.4 * 0.003 * 2700 + 0.2 * 2e-4 * 2700 + 0.5
    expected = [[0, 0, 24], [0, 0, 8], [1, 2, 3], [0, 0, 4], [0, 1, 0], [0, 0, -10 * mass]]
    np.testing.assert_allclose(sums, expected, atol=1e-9)
    assert plate.total_mass == pytest.approx(mass)


def test_damage_is_less_stiffness_of_that_set():
    plate = plate_with_mast(damage=("middle", "mast", "foot"), springs=(corner_spring(),))
    load = plate.pressure("skin", 50.0) + plate.point_load("top", (0.0, 2.0, 0.0)) + plate.gravity()
    soft = isotropic_plate(0.4 * 70e9, 0.33, 0.003, 2700.0)
    mesh = plate_mesh()
    mesh.cell_sets["outer"] = [np.setdiff1d(np.arange(24), mesh.cell_sets["middle"][0]), np.zeros(0, dtype=int)]
    mast = rectangular_beam(0.3 * 70e9, 0.33, 0.01, 0.02, (1, 0, 0), 2700.0)
    sections = {"outer": ALUMINIUM, "middle": soft, "mast": mast}
    other = Structure(read(mesh), sections, {"left": "clamped"}, (), {"top": 0.5}, (corner_spring(1e4),))
    state = {"middle": 0.6, "mast": 0.7, "foot": 0.5}
    # the mesh is coarse, and the mast twists one node of the plate, which never converges
    np.testing.assert_allclose(plate.solve(state, load, 1.0), other.solve({}, load, 1.0), rtol=1e-7, atol=1e-12)
    found = plate.strain_microstrain(state, load, GAUGES, 1.0, 1.0)
    np.testing.assert_allclose(found, other.strain_microstrain({}, load, GAUGES, 1.0, 1.0), rtol=1e-7)
    ours, theirs = ([m.frequency for m in s.natural_modes(3, w, limit=1.0)] for s, w in ((plate, state), (other, None)))
    np.testing.assert_allclose(ours, theirs, rtol=1e-7)


def test_the_reduced_structure_is_a_twin_within_its_bound(plate, load, tmp_path):
    twin = reduce(plate, load, GAUGES)
    assert isinstance(twin, Twin)
    states = np.random.default_rng(1).uniform(0.0, 0.9, (20, 3))
    full = np.array([
        plate.strain_microstrain(dict(zip(plate.parameters, row, strict=True)), 2.0 * load, GAUGES) for row in states
    ])  # fmt: skip
    found = predict_states(twin, states, 2.0)
    assert np.abs(found - full).max() < 1e-2
    assert (np.abs(found - full) <= twin.error_bound(states, 2.0) + 1e-6).all()
    twin.save(tmp_path / "plate.npz")
    again = ReducedStructure.load_file(tmp_path / "plate.npz")
    np.testing.assert_array_equal(again.predict({"middle": 0.3}, 1.0), twin.predict({"middle": 0.3}, 1.0))


def test_a_mass_on_a_mast_swings_as_a_cantilever():
    """The plate is held; sqrt(3 E I / L^3 / (m + 33/140 of the mast))."""
    structure = plate_with_mast(supports={"skin": "clamped"}, damage=())
    own = structure.built.beams.sections[0]
    mast = own.density * own.area * 0.2
    for mode, inertia in zip(structure.natural_modes(2), sorted((own.inertia_y, own.inertia_z)), strict=True):
        expected = np.sqrt(3 * own.young * inertia / 0.2**3 / (0.5 + 33 / 140 * mast)) / (2 * np.pi)
        assert mode.frequency == pytest.approx(expected, rel=0.01)


def test_springs_between_nodes_and_to_the_ground_share_a_force():
    """Mast and spring are parallel; a spring between nodes acts along their line."""
    free = plate_with_mast(supports={"skin": "clamped"}, damage=())
    push = free.point_load("top", (0.0, 1.0, 0.0))
    own = 1.0 / free.solve({}, push)[-1, 1]
    ground = Spring("stay", "top", (0.0, 3.0 * own, 0.0, 0.0, 0.0, 0.0))
    held = plate_with_mast(supports={"skin": "clamped"}, damage=("stay",), springs=(ground,))
    assert held.solve({}, push)[-1, 1] * 4.0 * own == pytest.approx(1.0, rel=1e-9)
    assert held.solve({"stay": 0.5}, push)[-1, 1] * 2.5 * own == pytest.approx(1.0, rel=1e-9)
    between = Spring("tie", "top", 3.0 * own, to="corner")
    tie = plate_with_mast(supports={"skin": "clamped"}, damage=(), springs=(between,))
    gap = tie.mesh.nodes[tie.mesh.nodes_of("corner")[0]] - tie.mesh.nodes[-1]
    share = (gap[1] / np.linalg.norm(gap)) ** 2
    # the mast is far stiffer along itself than the tie
    assert tie.solve({}, push)[-1, 1] * own * (1.0 + 3.0 * share) == pytest.approx(1.0, rel=2e-3)


def test_a_structure_is_written_as_paraview_reads_it(plate, load, tmp_path):
    state = {"middle": 0.6}
    write_vtu(plate, tmp_path / "plate.vtu", state, load)
    found = meshio.read(tmp_path / "plate.vtu")
    moved = plate.solve(state, load)
    np.testing.assert_allclose(found.point_data["displacement_m"], moved[:, :3])
    left, top = found.cell_data["stiffness_left"], found.cell_data["strain_top_microstrain"]
    assert sorted(set(left[0])) == [0.4, 1.0]
    assert np.isnan(top[1]).all()
