"""The estimate of a solution's error: near the true one where it was not calibrated, and refused beyond its limit."""

import numpy as np
import pytest

from benchmarks.oracles import shell_problems
from benchmarks.oracles.shell_problems import SLENDER, cook_membrane, pinched_hemisphere, straight_beam
from femlib.assembly import Quality, checked_solution, solution_quality
from femlib.components import Component, DamagedStructure
from femlib.errors import InputError, MeshError, SolveError
from femlib.material import isotropic_plate
from femlib.mesh import QualityLimits
from femlib.wing import Wing
from tests.test_femlib.plates import patch, rotation
from tests.test_femlib.warped_problems import LIFTED, Solved, saddle, slanted_roof, twisted_strip, twisted_tube


@pytest.fixture
def judged(monkeypatch: pytest.MonkeyPatch) -> list[Quality]:
    """The estimates of the standard problems, as they are solved."""
    found: list[Quality] = []
    plain = shell_problems.solved

    def solved(shells, held, load):
        moved = plain(shells, held, load)
        found.append(solution_quality(shells, moved.ravel()))
        return moved

    monkeypatch.setattr(shell_problems, "solved", solved)
    return found


@pytest.mark.parametrize("thickness", [0.32, 0.032, 0.0032])
@pytest.mark.parametrize("direction", ["v", "w"])
def test_what_warp_costs_a_twisted_strip_is_estimated_and_refused(thickness: float, direction: str) -> None:
    strip = twisted_strip(24, 2, thickness, direction)
    loss, quality = strip.loss(), strip.quality()
    assert loss > 0.5
    assert quality.warp_error > 0.5
    with pytest.raises(SolveError, match=r"by warp of the elements .most in element .*; expected at most 3 %; refine"):
        quality.refuse()


@pytest.mark.parametrize(
    "make",
    [
        lambda: twisted_strip(96, 4, 0.32, "w", 22.5),
        lambda: slanted_roof(8, 0.1),
        lambda: slanted_roof(8, 0.3),
        lambda: slanted_roof(16, 0.1),
        lambda: saddle(8, 0.2, 0.01),
        lambda: twisted_tube(20, 16, 0.001, 10.0),
    ],
    ids=["thick strip", "roof", "roof, more slanted", "roof, finer", "saddle", "tube"],
)
def test_the_estimate_is_what_warp_costs(make) -> None:
    solved: Solved = make()
    assert solved.quality().warp_error == pytest.approx(solved.loss(), rel=0.2, abs=1e-3)


def test_a_strip_too_thin_for_its_warp_is_refused_before_it_is_solved() -> None:
    for thickness in (0.032, 0.0032):
        with pytest.raises(MeshError, match=r"has a corner .* m off its mean plane at a thickness of .*; refine, take"):
            twisted_strip(96, 4, thickness, "w", limits=SLENDER)
    assert twisted_strip(96, 12, 0.32, "w", 22.5, limits=SLENDER).loss() < 0.01


def test_a_twisted_closed_section_is_accepted_by_its_result() -> None:
    """An open plate of that size could not be: what counts is the result."""
    with pytest.raises(MeshError, match=r"lift QualityLimits.warp_loss"):
        twisted_tube(20, 16, 0.001, 10.0, limits=QualityLimits())
    tube = twisted_tube(20, 16, 0.001, 10.0)
    tube.quality().refuse()
    moved = checked_solution(tube.shells, tube.supports, tube.load)
    assert np.allclose(moved, tube.moved, rtol=1e-6, atol=1e-12)
    region = Component("a", "mu", np.arange(tube.shells.mesh.n_elements) < 20)
    structure = DamagedStructure(tube.shells, tube.supports, (region,))
    assert np.isfinite(structure.solve(np.array([[0.3]]), tube.load)).all()


def test_a_damaged_structure_does_not_answer_for_a_warped_strip() -> None:
    strip = twisted_strip(24, 2, 0.032, "w")
    region = Component("a", "mu", np.arange(strip.shells.mesh.n_elements) < 4)
    structure = DamagedStructure(strip.shells, strip.supports, (region,))
    for attempt in (
        lambda: structure.solve(np.array([[0.3]]), strip.load),
        lambda: structure.solve_loads(np.array([0.3]), strip.load),
        lambda: checked_solution(strip.shells, strip.supports, strip.load),
    ):
        with pytest.raises(SolveError, match=r"displacements are estimated to be .* % off"):
            attempt()


def test_bending_of_single_elements_in_their_plane_is_estimated_and_refused(judged: list[Quality]) -> None:
    error = 1.0 - straight_beam("rectangular", "v")
    assert judged[-1].displacement_error == pytest.approx(error, rel=0.05)
    with pytest.raises(SolveError, match=r"by bending of single elements in their plane .*; take more elements over"):
        judged[-1].refuse()
    straight_beam("trapezoidal", "v")
    assert judged[-1].displacement_error > 0.15
    straight_beam("rectangular", "u")
    judged[-1].refuse()


def test_a_coarse_mesh_is_refused_and_a_fine_one_accepted(judged: list[Quality]) -> None:
    for problem, coarse, fine in ((cook_membrane, 4, 16), (pinched_hemisphere, 8, 16)):
        assert 1.0 - problem(coarse) > 0.03
        with pytest.raises(SolveError, match=r"by a coarse mesh .*; refine where the strains change"):
            judged[-1].refuse()
        assert abs(1.0 - problem(fine)) < 0.04
        judged[-1].refuse()
    cook_membrane(8)
    assert judged[-1].displacement_error == pytest.approx(1.0 - cook_membrane(8), rel=0.25)


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


def test_the_wing_is_accepted_sound_and_damaged(tiny: Wing) -> None:
    wing = tiny
    for state in ({}, {"mu1": 0.8, "mu2": 0.8}):
        factor = np.ones(wing.structure.shells.mesh.n_elements)
        for component in wing.structure.components:
            factor[component.elements] -= state.get(component.parameter, 0.0)
        quality = solution_quality(wing.structure.shells, wing.solve(state, 3.0).ravel(), factor)
        quality.refuse()
        assert quality.warp_error < 1e-8
        assert quality.displacement_error < 0.02


def test_wrong_questions_get_a_sentence() -> None:
    shells = patch(isotropic_plate(1e9, 0.3, 1e-3), "quad4")
    with pytest.raises(InputError, match=r"displacements has shape \(3,\); expected \(48,\)"):
        solution_quality(shells, np.zeros(3))
    with pytest.raises(SolveError, match=r"displacements have no strain energy"):
        solution_quality(shells, np.zeros(48))
    moved = np.zeros(48)
    moved[0] = 1.0
    with pytest.raises(InputError, match=r"limit is -1; expected a share"):
        solution_quality(shells, moved).refuse(-1)
    assert LIFTED.warp_loss == np.inf
