"""The shells against the standard problems: the ratio to the published answer, and that it converges."""

import numpy as np
import pytest

from benchmarks.oracles.shell_problems import CONVERGING, curved_beam, mapped, straight_beam
from femlib.errors import MeshError
from femlib.material import isotropic_plate
from femlib.mesh import Mesh

# the largest error of the ratio at 8 and 16 elements a side: measured, plus a margin of a tenth of it
ERROR = {
    "Scordelis-Lo roof": (0.006, 0.004),
    "pinched cylinder": (0.29, 0.08),
    "pinched hemisphere": (0.41, 0.04),
    "Morley skew plate": (0.14, 0.07),
    "Cook's membrane": (0.02, 0.007),
    "square plate, simply supported": (0.0015, 0.0004),
    "square plate, clamped": (0.0032, 0.0008),
}


@pytest.mark.parametrize("name", CONVERGING)
def test_a_standard_problem_nears_its_published_answer(name: str) -> None:
    errors = [abs(CONVERGING[name](n) - 1.0) for n in (8, 16)]
    assert errors[0] < ERROR[name][0]
    assert errors[1] < ERROR[name][1]
    assert errors[1] < errors[0]


@pytest.mark.parametrize("clamped", ["simply supported", "clamped"])
def test_thin_plates_converge_with_the_square_of_the_step(clamped: str) -> None:
    problem = CONVERGING[f"square plate, {clamped}"]
    first, second = (abs(problem(n) - 1.0) for n in (4, 8))
    assert np.log2(first / second) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("rectangular", (0.999, 0.904, 0.980, 0.941)),
        ("trapezoidal", (0.998, 0.761, 0.963, 0.884)),
        ("parallelogram", (0.998, 0.838, 0.978, 0.849)),
    ],
)
def test_six_elements_of_a_slender_beam_are_as_good_as_documented(shape: str, expected: tuple[float, ...]) -> None:
    assert [straight_beam(shape, d) for d in "uvwx"] == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("direction", ["v", "w", "x"])
def test_a_slender_beam_converges(direction: str) -> None:
    assert straight_beam("rectangular", direction, 48, 4) == pytest.approx(1.0, abs=0.025)  # twist: corner forces


@pytest.mark.parametrize("direction", ["u", "w"])
def test_a_curved_beam_converges(direction: str) -> None:
    assert curved_beam(direction, 48, 4) == pytest.approx(1.0, abs=0.02)


def test_a_twisted_beam_is_refused_and_not_computed_wrongly() -> None:
    def place(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        angle, across = 0.5 * np.pi * u, 1.1 * (v - 0.5)
        return np.stack([12.0 * u, across * np.cos(angle), across * np.sin(angle)], axis=-1)

    with pytest.raises(
        MeshError, match=r"element \d+ has a corner 0.018 m off its mean plane at a thickness of 0.32 m"
    ):
        mapped(place, 12, 2, isotropic_plate(29e6, 0.22, 0.32))


def test_a_triangle_is_never_warped() -> None:
    nodes = np.array([[0, 0, 0], [1, 0, 0.5], [0, 1, 0.7]], dtype=float)
    none, one = np.zeros((0, 4), dtype=np.int64), np.array([[0, 1, 2]])
    assert Mesh(nodes, none, one, ("p",), np.zeros(1, dtype=np.int64)).n_elements == 1
