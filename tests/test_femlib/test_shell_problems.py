"""The shells against the standard problems: the ratio to the published answer, and that it converges."""

import numpy as np
import pytest

from benchmarks.shells.elasticity import pagano_deflection
from benchmarks.shells.plates import pagano_plate
from benchmarks.shells.problems import CONVERGING
from benchmarks.shells.random_panels import random_shape
from benchmarks.shells.strips import curved_beam, straight_beam, twisted_beam
from femlib.assembly.quality import MOST_ERROR
from femlib.material import Ply

# the largest error of the ratio at 8 and 16 elements a side: measured, plus a margin of a tenth of it
ERROR = {
    "Scordelis-Lo roof": (0.006, 0.004),
    "the same on a slanted mesh": (0.01, 0.007),
    "pinched cylinder": (0.29, 0.08),
    "pinched hemisphere": (0.042, 0.002),
    "Morley skew plate": (0.14, 0.07),
    "Razzaque skew plate": (0.047, 0.014),
    "Cook's membrane": (0.014, 0.005),
    "square plate, simply supported": (0.0015, 0.0004),
    "square plate, clamped": (0.0032, 0.0008),
}


@pytest.mark.parametrize("name", CONVERGING)
def test_a_standard_problem_nears_its_published_answer(name: str) -> None:
    errors = [abs(CONVERGING[name](n).ratio() - 1.0) for n in (8, 16)]
    assert errors[0] < ERROR[name][0]
    assert errors[1] < ERROR[name][1]
    assert errors[1] < errors[0]


@pytest.mark.parametrize("clamped", ["simply supported", "clamped"])
def test_thin_plates_converge_with_the_square_of_the_step(clamped: str) -> None:
    problem = CONVERGING[f"square plate, {clamped}"]
    first, second = (abs(problem(n).ratio() - 1.0) for n in (4, 8))
    assert np.log2(first / second) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("rectangular", (1.001, 0.993, 0.980, 0.941)),
        ("trapezoidal", (1.001, 0.865, 0.963, 0.884)),
        ("parallelogram", (1.002, 0.910, 0.978, 0.849)),
    ],
)
def test_six_elements_of_a_slender_beam_are_as_good_as_documented(shape: str, expected: tuple[float, ...]) -> None:
    assert [straight_beam(shape, d).ratio() for d in "uvwx"] == pytest.approx(expected, abs=1e-3)


STRIPS = {
    "slender": (lambda d: straight_beam("rectangular", d, 48, 4), "vwx", 0.025),  # twist: corner forces
    "curved": (lambda d: curved_beam(d, 48, 4), "uw", 0.02),
    "curved, one element across": (lambda d: curved_beam(d, 6, 1), "u", 0.015),
    "curved, 24 along": (lambda d: curved_beam(d, 24, 1), "u", 0.015),  # 1.014: beam theory leaves out the depth
    "twisted, thick": (lambda d: twisted_beam(0.32, d), "vw", 0.03),
    "twisted, thick and fine": (lambda d: twisted_beam(0.32, d, 24, 4), "vw", 0.01),
    "twisted, thin": (lambda d: twisted_beam(0.0032, d), "vw", 0.03),
    "twisted, thin and fine": (lambda d: twisted_beam(0.0032, d, 24, 4), "vw", 0.01),
}


@pytest.mark.parametrize("name", STRIPS)
def test_a_strip_nears_the_answer_of_beam_theory(name: str) -> None:
    strip, directions, error = STRIPS[name]
    assert [strip(direction).ratio() for direction in directions] == pytest.approx([1.0] * len(directions), abs=error)


def test_randomly_warped_and_skewed_panels_are_right_or_refused() -> None:
    rng = np.random.default_rng(11)
    accepted = 0
    for _ in range(6):
        shape = random_shape(rng)
        work, quality = shape(16, rng).judged(is_refined=False)
        if quality.displacement_error <= MOST_ERROR:
            accepted += 1
            assert work == pytest.approx(shape(32, None).ratio(), rel=0.05)
    assert accepted >= 2


def test_the_elasticity_of_a_thick_plate_is_that_of_its_shells_where_one_ply_leaves_no_doubt() -> None:
    alike = Ply(1e9, 1e9, 0.25, 0.4e9, 0.4e9, 0.4e9, 1.0)
    plate = pagano_plate(16, 20.0, alike, (0.0, 0.0))
    assert plate.ratio() == pytest.approx(1.0, abs=2e-3)
    assert pagano_deflection(alike, (0.0, 0.0), 20.0) == pytest.approx(plate.reference, rel=1e-12)


@pytest.mark.parametrize(("slenderness", "error"), [(4, 0.08), (10, 0.01), (20, 0.002), (100, 0.003)])
def test_a_cross_ply_plate_has_the_deflection_of_elasticity(slenderness: float, error: float) -> None:
    assert abs(pagano_plate(16, slenderness).ratio() - 1.0) < error
