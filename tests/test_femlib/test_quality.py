"""The estimate of a solution's error: near the true one where it was not calibrated, and refused beyond its limit."""

import numpy as np
import pytest

from benchmarks.shells.curved import pinched_cylinder, pinched_hemisphere
from benchmarks.shells.plates import cook_membrane
from femlib.assembly import solution_quality
from femlib.errors import SolveError
from femlib.material import isotropic_plate
from tests.test_femlib.plates import patch, rotation


def test_a_coarse_mesh_is_refused_and_a_fine_one_accepted() -> None:
    for problem, coarse, fine in ((cook_membrane, 4, 16), (pinched_hemisphere, 8, 16)):
        ratio, quality = problem(coarse).judged()
        assert 1.0 - ratio > 0.03
        with pytest.raises(SolveError, match=r"by a coarse mesh .*; refine where the strains change"):
            quality.refuse()
        ratio, quality = problem(fine).judged()
        assert abs(1.0 - ratio) < 0.04
        quality.refuse()
    ratio, quality = cook_membrane(8).judged()
    assert quality.displacement_error == pytest.approx(1.0 - ratio, rel=0.25)


def test_flat_triangles_of_a_pinched_cylinder_hide_no_error_from_the_estimate_of_their_strains() -> None:
    """Without the weight of triangles the estimate is half of it, 0.16, and the true error 0.28."""
    ratio, quality = pinched_cylinder(8).in_triangles("first diagonal").judged(is_refined=False)
    assert quality.finer == 0
    assert 1.0 - ratio <= quality.displacement_error <= 1.3 * (1.0 - ratio)


@pytest.mark.parametrize("shape", ["quad4", "tria3"])
def test_constant_strain_and_rigid_motion_cost_nothing(shape: str) -> None:
    turn = rotation(3)
    shells = patch(isotropic_plate(1e9, 0.3, 1e-3), shape, turn)
    gradient = turn @ np.array([[1e-3, 4e-4, 0.0], [2e-4, -5e-4, 0.0], [0.0, 0.0, 0.0]]) @ turn.T
    moved = np.zeros((len(shells.mesh.nodes), 6))
    moved[:, :3] = shells.mesh.nodes @ gradient.T + [1e-3, 2e-3, 3e-3]
    spin = 0.5 * np.array(
        [gradient[2, 1] - gradient[1, 2], gradient[0, 2] - gradient[2, 0], gradient[1, 0] - gradient[0, 1]]
    )
    moved[:, 3:] = spin
    assert solution_quality(shells, moved.ravel()).displacement_error < 1e-8


def test_displacements_without_strain_have_no_quality() -> None:
    with pytest.raises(SolveError, match=r"displacements have no strain energy"):
        solution_quality(patch(isotropic_plate(1e9, 0.3, 1e-3), "quad4"), np.zeros(48))
