"""Stresses, strength, reactions and buckling of structures: what laminate theory and equilibrium say."""

from dataclasses import replace

import meshio
import numpy as np
import pytest

from femlib.assembly import Shells, ply_stresses
from femlib.assembly.integration import point_strains
from femlib.assembly.recovery import _is_edge, nodal_tensors
from femlib.assembly.stresses import corner_strains
from femlib.errors import InputError, SolveError
from femlib.material import Ply, isotropic_plate, laminate
from femlib.mesh import Mesh
from femlib.rom.capability import full_limits
from femlib.strength import Strength, strain_factors, tsai_wu_factors, von_mises, yielding_at
from femlib.structure import Structure, heated, read, thermal_buckling
from femlib.structure.strength import structure_limits
from tests.test_femlib.own_meshes import plate_mesh, plate_with_mast
from tests.test_femlib.plates import grid_mesh

CARBON = Strength(1500e6, 900e6, 40e6, 150e6, 70e6)
LAMINA = {"young_1": 130e9, "young_2": 9e9, "poisson_12": 0.3, "shear_12": 5e9, "shear_13": 5e9, "shear_23": 3e9}


def cantilever(section, n_x=24, width=0.05):
    """A strip 0.2 m long, held at its left edge."""
    mesh = plate_mesh(n_x, 4, 0.2, width)
    shells = meshio.Mesh(
        mesh.points[:-2],
        [("quad", mesh.cells[0].data)],
        point_sets={name: mesh.point_sets[name] for name in ("left", "right")},
        cell_sets={name: [mesh.cell_sets[name][0]] for name in ("skin", "middle")},
    )
    return Structure(read(shells), {"skin": section}, {"left": "clamped"}, damage=("middle",))


def test_tsai_wu_and_max_strain_fail_a_ply_at_its_own_strengths():
    signs = np.array([[1500e6, 0, 0], [-900e6, 0, 0], [0, 40e6, 0], [0, -150e6, 0], [0, 0, 70e6], [0, 0, -70e6]])
    np.testing.assert_allclose(tsai_wu_factors(CARBON, signs / 2), 2.0)
    moduli = (130e9, 9e9, 5e9)
    np.testing.assert_allclose(strain_factors(CARBON, moduli, signs / moduli / 4), 4.0)


def test_the_factor_of_tsai_wu_lies_on_its_surface():
    stress = np.random.default_rng(0).normal(size=(50, 3)) * [500e6, 50e6, 40e6]
    s1, s2, s12 = (tsai_wu_factors(CARBON, stress)[:, None] * stress).T
    f11, f22 = 1 / (1500e6 * 900e6), 1 / (40e6 * 150e6)
    index = f11 * s1**2 + f22 * s2**2 + (s12 / 70e6) ** 2 - np.sqrt(f11 * f22) * s1 * s2
    index += (1 / 1500e6 - 1 / 900e6) * s1 + (1 / 40e6 - 1 / 150e6) * s2
    np.testing.assert_allclose(index, 1.0, atol=1e-12)


def test_a_metal_yields_by_von_mises_in_every_criterion_of_stresses():
    stress, metal = np.random.default_rng(1).normal(size=(40, 3)) * 1e8, yielding_at(250e6)
    np.testing.assert_allclose(tsai_wu_factors(metal, stress), 250e6 / von_mises(stress))
    assert von_mises(np.array([0.0, 0.0, metal.shear_12])) == pytest.approx(250e6)


def uniform(structure, strain, curvature):
    """Displacements (n_dofs,) of strains and curvatures (3,) that are the same everywhere, order (xx, yy, xy)."""
    x, y = structure.mesh.nodes[:, :2].T
    (exx, eyy, exy), (kxx, kyy, kxy) = strain, curvature
    moved = np.zeros((len(x), 6))
    moved[:, 0], moved[:, 1] = exx * x + exy * y / 2, eyy * y + exy * x / 2
    moved[:, 2] = -(kxx * x * x + kyy * y * y + kxy * x * y) / 2
    moved[:, 3], moved[:, 4] = -(kyy * y + kxy * x / 2), kxx * x + kxy * y / 2
    return moved.ravel()


def test_every_ply_has_the_strain_of_its_height_in_its_own_axes():
    angles = (0.0, np.pi / 2, np.pi / 6)
    section = laminate([Ply(**LAMINA, thickness=1e-3, angle=a) for a in angles])
    strip = cantilever(section)
    strain, curvature = np.array([1e-3, -4e-4, 6e-4]), np.array([0.3, -0.1, 0.2])
    moved = uniform(strip, strain, curvature)
    np.testing.assert_allclose(corner_strains(strip.built, moved)[:, :3], np.tile(strain, (384, 1)), atol=1e-12)
    found = ply_stresses(strip.built, moved, strip.stiffness_left({"middle": 0.5}))
    assert sorted(set(found.height.round(12))) == [-1.5e-3, -0.5e-3, 0.5e-3, 1.5e-3]
    for number, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        own = found.ply == number
        xx, yy, xy = (strain + found.height[own, None] * curvature).T
        along, across = c * c * xx + s * s * yy + c * s * xy, s * s * xx + c * c * yy - c * s * xy
        both = np.column_stack([along, across, 2 * c * s * (yy - xx) + (c * c - s * s) * xy])
        np.testing.assert_allclose(found.strain[own], both, atol=2e-6)
        rest = 1 - 0.3**2 * 9 / 130
        left = strip.stiffness_left({"middle": 0.5})[found.element[own]]
        np.testing.assert_allclose(found.stress[own, 0], left * (130e9 * along + 2.7e9 * across) / rest, atol=4e5)
        np.testing.assert_allclose(found.stress[own, 2], left * 5e9 * both[:, 2], atol=2e4)


def test_a_bent_strip_yields_where_and_when_beam_theory_says():
    """sigma = 6 F x / (b t^2) at mid-span, in a strip without contraction across."""
    strip = cantilever(isotropic_plate(70e9, 0.0, 2e-3, strength=yielding_at(250e6)))
    load = strip.line_load("right", (0.0, 0.0, 100.0))
    found = strip.stresses({}, load)
    x = strip.mesh.nodes[found.node][:, 0]
    expected = 6.0 * 100.0 * (0.2 - x) / 4e-6
    off = np.abs(found.von_mises - expected) / expected.max()
    assert off.max() < 2e-4  # the mean of the first row of elements: 0.5 / 24
    assert found.failure_factors("von mises").min() == pytest.approx(250e6 / expected.max(), rel=2e-4)
    assert found.error < 1e-3


@pytest.mark.parametrize("is_cut", [False, True])
def test_a_strip_pulled_along_its_edge_has_one_strain_to_its_corners(is_cut):
    """For any shape of elements. With forces alone a corner had 1.5 times the strain."""
    mesh = plate_mesh(8, 3, 0.4, 0.1)
    points, quads = mesh.points[:-2].copy(), mesh.cells[0].data
    inner = (points[:, :2] > 1e-9).all(axis=1) & (points[:, 0] < 0.4 - 1e-9) & (points[:, 1] < 0.1 - 1e-9)
    points[inner, :2] += np.random.default_rng(0).uniform(-0.006, 0.006, (inner.sum(), 2))
    halves = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    kind, cells = ("triangle", halves) if is_cut else ("quad", quads)
    sets = {name: mesh.point_sets[name] for name in ("left", "right")} | {"origin": np.array([0])}
    own = meshio.Mesh(points, [(kind, cells)], point_sets=sets, cell_sets={"skin": [np.arange(len(cells))]})
    strip = Structure(read(own), {"skin": isotropic_plate(70e9, 0.3, 2e-3)}, {"left": "x z rx ry rz", "origin": "y"})
    moved = strip.solve({}, strip.line_load("right", (1e4, 0.0, 0.0)))
    strains = corner_strains(strip.built, np.asarray(moved).ravel())
    np.testing.assert_allclose(strains[:, 0], 1e4 / (70e9 * 2e-3), rtol=1e-9)
    assert moved.error < 0.01


def test_reactions_hold_the_load_and_its_moment():
    plate = plate_with_mast(finer=2)
    load = plate.pressure("skin", 50.0) + plate.point_load("top", (1.0, 2.0, 3.0)) + plate.gravity()
    held = np.asarray(plate.reactions({"middle": 0.5}, load))
    arms, force = plate.mesh.nodes, load.reshape(-1, 6)
    np.testing.assert_allclose(held[:, :3].sum(axis=0), -force[:, :3].sum(axis=0), rtol=1e-8)
    moments = [(own[:, 3:] + np.cross(arms, own[:, :3])).sum(axis=0) for own in (held, force)]
    np.testing.assert_allclose(moments[0], -moments[1], rtol=1e-7)
    assert not held[arms[:, 0] > 0].any()


@pytest.mark.long
def test_a_structure_buckles_as_euler_says_and_sooner_with_damage():
    strip = cantilever(isotropic_plate(70e9, 0.0, 2e-3))
    load = strip.line_load("right", (-1.0, 0.0, 0.0))
    factor = strip.buckling_modes({}, load)[0].factor
    assert factor == pytest.approx(np.pi**2 * 70e9 * (2e-3) ** 3 / 12 / (4 * 0.2**2), rel=0.01)
    assert strip.buckling_modes({"middle": 0.5}, load)[0].factor < 0.95 * factor


def test_a_structure_bears_what_its_plies_buckling_and_deflection_let_it():
    """Of a pushed and bent strip: each limit by the reduced model is the full model's, and Euler's for the second."""
    strip = cantilever(isotropic_plate(70e9, 0.0, 2e-3, strength=yielding_at(250e6)), 12)
    load = strip.line_load("right", (-1000.0, 0.0, 0.0)) + strip.line_load("right", (0.0, 0.0, 10.0))
    found = strip.capability(load, "right", (0.0, 0.0, 2.0), 0.2, n_states=8, n_checks=1)
    states = np.array([[0.0], [0.6]])
    limits = structure_limits(strip.mesh, "right", (0.0, 0.0, 1.0), 0.2)
    full = [full_limits(strip.damaged, limits, load, state) for state in states]
    np.testing.assert_allclose(found.limits(states), full, rtol=1e-4)
    assert found.error < 1e-4
    euler = np.pi**2 * 70e9 * (2e-3) ** 3 / 12 / (4 * 0.2**2) / 1000.0
    assert found.load_factors(states[:1]) == pytest.approx(euler, rel=0.01)
    with pytest.raises(InputError, match="has no strength"):
        cantilever(isotropic_plate(70e9, 0.0, 2e-3), 12).capability(load, "right", (0, 0, 1), 0.2)
    with pytest.raises(InputError, match="direction of the deflection"):
        strip.capability(load, "right", (0, 0, 0), 0.2)
    with pytest.raises(InputError, match="the load is 0"):
        strip.capability(0.0 * load, "right", (0, 0, 1), 0.2)


def test_a_pulled_strip_bears_strength_times_area_and_never_buckles():
    strip = cantilever(isotropic_plate(70e9, 0.0, 2e-3, strength=yielding_at(250e6)), 10)
    pull = strip.line_load("right", (1000.0, 0.0, 0.0))
    found = strip.capability(pull, "right", (1.0, 0.0, 0.0), 1.0, n_states=4, n_checks=1)
    ply, stretch = 250e6 * 2e-3 / 1000.0, 70e9 * 2e-3 / (1000.0 * 0.2)
    expected = [[ply, np.inf, stretch], [ply / 2, np.inf, stretch / (1 + strip_share(strip))]]
    np.testing.assert_allclose(found.limits(np.array([[0.0], [0.5]])), expected, rtol=1e-6)


def strip_share(strip):
    """Return the share of a strip's length that its part "middle" takes."""
    corners = strip.mesh.nodes[strip.mesh.quads[strip.mesh.elements_of("middle")[: len(strip.mesh.quads)]].ravel()]
    return float(np.ptp(corners[:, 0])) / 0.2


def test_what_is_missing_for_strength_is_said():
    strip = cantilever(isotropic_plate(70e9, 0.3, 2e-3), 8)
    found = strip.stresses({}, strip.line_load("right", (0.0, 0.0, 100.0)), strain_limit=0.2)
    with pytest.raises(InputError, match="has no strength"):
        found.failure_factors()
    with pytest.raises(InputError, match="criterion is 'mises'"):
        found.failure_factors("mises")
    with pytest.raises(InputError, match="strength compression_1 is -1"):
        Strength(1.0, -1.0, 1.0, 1.0, 1.0)


def test_strains_of_a_coarse_mesh_are_refused():
    coarse = cantilever(isotropic_plate(70e9, 0.3, 2e-3), n_x=5)
    with pytest.raises(SolveError, match="estimated to be"):
        coarse.stresses({}, coarse.line_load("right", (0.0, 0.0, 100.0)), strain_limit=0.001)


@pytest.mark.long
def test_a_warm_strip_has_no_stress_where_it_is_free_and_its_own_where_it_is_held():
    """alpha T of length, whatever is damaged; E alpha T between held ends; curvature alpha T'."""
    section = isotropic_plate(70e9, 0.0, 2e-3, expansion=23e-6, strength=yielding_at(250e6))
    free, held = cantilever(section), cantilever(section)
    grown = heated(free, {"skin": (50.0, 0.0)}, strain_limit=1.0)
    tip = free.mesh.nodes_of("right")
    np.testing.assert_allclose(np.asarray(grown.displacements)[tip, 0], 23e-6 * 50.0 * 0.2, rtol=1e-6)
    inner = free.mesh.nodes[grown.stresses.node][:, 0] > 0.14  # away from the clamp, which hinders it across
    assert np.abs(grown.stresses.stress[inner]).max() < 1e-4 * 70e9 * 23e-6 * 50.0
    held = Structure(held.mesh, {"skin": section}, {"left": "clamped", "right": "x z rx ry rz"}, damage=("middle",))
    pushed = heated(held, {"skin": (10.0, 0.0)}, strain_limit=1.0).stresses
    middle = np.abs(held.mesh.nodes[pushed.node][:, 0] - 0.1) < 0.02
    np.testing.assert_allclose(pushed.stress[middle, 0], -70e9 * 23e-6 * 10.0, rtol=1e-3)
    assert pushed.failure_factors("von mises")[middle].min() == pytest.approx(250e6 / (70e9 * 23e-6 * 10.0), rel=2e-3)
    euler = np.pi**2 * 2e-3**2 / (3.0 * 23e-6 * 0.2**2)  # both ends of the strip are clamped
    assert 10.0 * thermal_buckling(held, {"skin": (10.0, 0.0)})[0].factor == pytest.approx(euler, rel=5e-3)
    with pytest.raises(SolveError, match="beyond those that buckle the shells"):
        heated(held, {"skin": (1.02 * euler, 0.0)})
    bent = np.asarray(heated(free, {"skin": (0.0, 1000.0)}, strain_limit=1.0).displacements)
    assert bent[tip, 2].mean() == pytest.approx(-0.5 * 23e-6 * 1000.0 * 0.2**2, rel=0.02)
    softer = heated(free, {"skin": (50.0, 0.0)}, {"middle": 0.5}, strain_limit=1.0)
    places = [np.asarray(found.displacements)[:, :3] for found in (softer, grown)]
    np.testing.assert_allclose(*places, atol=1e-3 * 23e-6 * 50.0 * 0.2)
    with pytest.raises(InputError, match="where no shell expands"):
        heated(cantilever(isotropic_plate(70e9, 0.0, 2e-3)), {"skin": (50.0, 0.0)})
    for bad in ((50.0, float("nan")), 50.0):
        with pytest.raises(InputError, match="expected kelvin and kelvin per metre"):
            heated(free, {"skin": bad})
    with pytest.raises(InputError, match="warmth is a list; expected temperatures by set name"):
        heated(free, [("skin", (50.0, 0.0))])


@pytest.mark.parametrize("is_cut", [False, True])
@pytest.mark.parametrize(("n", "n_y", "length"), [(20, 20, 0.2), (20, 2, 0.2), (4, 4, 0.05), (4, 4, 0.0)])
def test_a_strain_over_a_length_is_the_mean_of_what_its_part_has_within_it(n, n_y, length, is_cut):
    """A sector of angle t has its middle 4 d sin(t / 2) / (3 t) away; a disc has the mean of x^2 and d^2 / 4."""
    mesh, q = grid_mesh(np.linspace(0.0, 1.0, n + 1), np.linspace(0.0, 1.0, n_y + 1)), 5.0 * (n == 20)
    if is_cut:
        trias = np.concatenate([mesh.quads[:, [0, 1, 2]], mesh.quads[:, [0, 2, 3]]])
        mesh = Mesh(mesh.nodes, np.zeros((0, 4), int), trias, ("plate",), np.zeros(len(trias), int))
    cells = mesh.trias if is_cut else mesh.quads
    scale = np.where(mesh.nodes[cells].mean(axis=1)[:, 0] < 0.5, 1.0, 9.0)
    axis = np.array([1.0, 0.0, 0.0])
    shells = Shells(mesh, (isotropic_plate(70e9, 0.3, 1e-3),), np.zeros(len(cells), int), scale, axis)

    def value(part, x, y):
        return np.where(part == 0, 1.0 + 2.0 * x + 3.0 * y + q * x**2, -5.0 - x + 4.0 * y)

    kinds = [k for k in point_strains(shells, np.zeros((len(mesh.nodes), 6)), np.ones(len(cells))) if len(k.corners)]
    for k, kind in enumerate(kinds):
        x, y = np.moveaxis((kind.shapes @ kind.points)[..., :2], -1, 0)
        strains = np.zeros_like(kind.strains)
        strains[..., :2] = value(kind.group[:, :1] % 2, x, y)[..., None, None]
        kinds[k] = replace(kind, strains=strains)
    names, found = nodal_tensors(shells, kinds, length)
    node = mesh.nodes[names // 2]
    assert np.array_equal(_is_edge(kinds, names), np.isclose(node[:, :2] % 0.5, 0.0)[:, 0] | (node[:, 1] % 1.0 == 0.0))
    far = 4.0 * length / (3.0 * np.pi)
    places = {(0, 0.25, 0.5): (0.0, 0.0), (0, 0.25, 0.0): (0.0, far), (0, 0.0, 1.0): (far, -far)}
    places |= {(0, 0.5, 0.5): (-far, 0.0), (1, 0.5, 0.5): (far, 0.0), (1, 1.0, 0.0): (-far, far)}
    if n_y < n:  # elements are long along the edge at x = 0.5 alone
        places = {at: middle for at, middle in places.items() if at[2] == 0.5}
    for (part, x, y), (dx, dy) in places.items():
        node = int(np.flatnonzero(np.isclose(mesh.nodes[:, 0], x) & np.isclose(mesh.nodes[:, 1], y))[0])
        tensor = found[np.flatnonzero(names == 2 * node + part)[0]].reshape(2, 3, 3)
        mean = float(value(part, x + dx, y + dy))
        if part == 0 and q:
            square = {0.25: x**2 + length**2 / 4.0, 0.0: length**2 / 4.0, 0.5: x**2 + 2.0 * x * dx + length**2 / 4.0}
            mean += q * (square[x] - (x + dx) ** 2)
        expected = pytest.approx(mean, abs={20: 0.012, 2: 0.045}[n_y] * length if n == 20 else 1e-9)
        assert (tensor[0, 0, 0], tensor[1, 1, 1]) == (expected, expected)
