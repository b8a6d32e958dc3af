"""Every solution is judged: what was answered without a word is refused in one sentence, the rest has an estimate."""

import meshio
import numpy as np
import pytest

from benchmarks.shells.case import DIAGONALS
from benchmarks.shells.modes import blade, cylinder_frequency
from benchmarks.shells.plates import razzaque_skew_plate
from benchmarks.shells.strips import curved_beam, raasch_hook, straight_beam
from femlib.assembly.quality import MOST_ERROR
from femlib.errors import FemlibError, SolveError
from femlib.material import isotropic_plate
from femlib.sensors import StrainGauge
from femlib.structure import Structure, read, reduce
from tests.test_femlib.own_meshes import ALUMINIUM, plate_mesh, plate_with_mast

GAUGE = StrainGauge("m", (0.3, 0.2, 0.0), (1, 0, 0), ("skin",))


def skin(mesh=None, supports=None, **others):
    """The plate of `plate_mesh` without its mast."""
    mesh = plate_mesh(12, 8) if mesh is None else mesh
    plain = meshio.Mesh(mesh.points[:-2], [mesh.cells[0]])
    plain.cell_sets = {name: [mesh.cell_sets[name][0]] for name in ("skin", "middle")}
    plain.point_sets = {name: mesh.point_sets[name] for name in ("left", "right", "corner")}
    given = {"sections": {"skin": ALUMINIUM}, "damage": ("middle",)} | others
    return Structure(read(plain), supports=supports or {"left": "clamped"}, **given)


@pytest.mark.parametrize(
    "case",
    [
        *(straight_beam("rectangular", "x", 6 * k, k) for k in (1, 2, 4)),
        straight_beam("parallelogram", "x"),
        curved_beam("w", 6, 1),
        curved_beam("w", 12, 2),
        curved_beam("w", 12, 2).in_triangles(DIAGONALS[0]),
        raasch_hook(9, 1),
        raasch_hook(21, 2),
        razzaque_skew_plate(8),
    ],
    ids=["twist 1", "twist 2", "twist 4", "skew twist", "ring 1", "ring 2", "ring T", "hook 1", "hook 2", "Razzaque 8"],
)
def test_strips_and_plates_that_were_too_stiff_without_a_word_are_refused(case) -> None:
    ratio, quality = case.judged()
    assert quality.displacement_error > max(MOST_ERROR, 0.4 * (1.0 - ratio))
    with pytest.raises(SolveError, match="by a coarse mesh"):
        quality.refuse()


def test_a_blade_of_triangles_that_buckles_sideways_too_early_is_refused() -> None:
    error, estimate = blade(48, 1, DIAGONALS[0])
    assert error > 0.3
    assert estimate > 0.3


def test_a_coarse_cylinders_frequency_has_an_estimate() -> None:
    error, estimate = cylinder_frequency(4, 4)
    assert abs(error) > 0.03
    assert estimate > max(MOST_ERROR, 0.5 * abs(error))


def test_a_solution_carries_its_estimate_and_what_is_computed_from_it_none() -> None:
    plate = skin()
    load = plate.pressure("skin", 50.0)
    moved, strains = plate.solve({}, load), plate.strain_microstrain({"middle": 0.5}, load, [GAUGE])
    assert 0.0 < moved.error < MOST_ERROR
    assert 0.5 * moved.error < strains.error < 5.0 * moved.error
    assert np.isnan((2.0 * moved).error)
    assert all(0.0 < mode.error < MOST_ERROR for mode in plate.natural_modes(2))
    assert reduce(plate, load, [GAUGE]).mesh_error == pytest.approx(plate.strain_microstrain({}, load, [GAUGE]).error)
    with pytest.raises(SolveError, match="gauge strains are estimated"):
        plate.strain_microstrain({}, load, [GAUGE], gauge_limit=1e-9)
    with pytest.raises(SolveError, match="displacements are estimated"):
        reduce(plate, load, [GAUGE], limit=1e-9)


@pytest.mark.long
def test_a_structure_of_one_region_is_reduced_however_many_its_ports() -> None:
    plate = skin(plate_mesh(36, 24))
    load = plate.pressure("skin", 50.0)
    twin = reduce(plate, load, [GAUGE])
    expected = plate.strain_microstrain({"middle": 0.5}, load, [GAUGE])
    np.testing.assert_allclose(twin.predict({"middle": 0.5}, 1.0), expected, rtol=1e-4)
    none = reduce(plate, 0.0 * load, [GAUGE])
    np.testing.assert_array_equal(none.predict({"middle": 0.5}, 1.0), [0.0])


def open_mesh():
    """The plate cut across its middle: nodes of both halves lie at the same places."""
    mesh = plate_mesh()
    points, quads = mesh.points, mesh.cells[0].data.copy()
    seam = np.flatnonzero((np.abs(points[:, 0] - 0.3) < 1e-9) & (points[:, 2] == 0.0))[1:]
    right = points[quads].mean(axis=1)[:, 0] > 0.3
    twin = {int(node): len(points) - 2 + k for k, node in enumerate(seam)}
    quads[right] = [[twin.get(int(node), node) for node in row] for row in quads[right]]
    new = meshio.Mesh(np.concatenate([points[:-2], points[seam], points[-2:]]), [("quad", quads)])
    new.cell_sets, new.point_sets = mesh.cell_sets, mesh.point_sets
    return new


def squeezed():
    plate = skin()
    return plate.solve({}, plate.line_load("right", (-3e4, 0.0, 0.0)))


def weightless():
    plate = skin(sections={"skin": isotropic_plate(70e9, 0.33, 0.003)})
    return plate.gravity()


SILENT = {
    "open mesh": (lambda: skin(open_mesh()), "nodes 10 and 35 lie at one place, .*; merge them in the mesh program"),
    "no density": (weightless, "gravity acts on shell 0 .*has no density; .*; give it in kg"),
    "one name twice": (lambda: skin().strain_rows([GAUGE, GAUGE]), "gauges are named .*; rename one"),
    "far beyond Euler": (squeezed, "beyond the buckling load .*; lower it"),
    "20 mm off": (
        lambda: plate_with_mast().strain_rows([StrainGauge("g", (0.3, 0.2, 0.02), (1, 0, 0), ("skin",))]),
        "lies 0.02 m off element .*; move the gauge onto the surface",
    ),
}


@pytest.mark.parametrize("name", SILENT)
def test_what_was_answered_without_a_word_is_refused_in_one_sentence(name) -> None:
    make, sentence = SILENT[name]
    with pytest.raises(FemlibError, match=sentence) as told:
        make()
    assert "\n" not in str(told.value)
