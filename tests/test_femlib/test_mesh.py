"""A mesh refuses what the elements cannot bear, with the element's number."""

from collections.abc import Sequence

import numpy as np
import pytest

from femlib.errors import MeshError
from femlib.geometry import grid_lines
from femlib.mesh import Mesh
from tests.test_femlib.plates import grid_mesh


def of_quads(nodes: Sequence[Sequence[float]], quads: Sequence[Sequence[int]]) -> Mesh:
    none = np.zeros((0, 3), dtype=np.int64)
    return Mesh(np.array(nodes, dtype=float), np.array(quads), none, ("p",), np.zeros(len(quads), dtype=np.int64))


@pytest.mark.parametrize(
    ("corners", "sentence"),
    [
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0.6], [0, 1, 0]], "element 1 has a warp of"),
        ([[0, 0, 0], [50, 0, 0], [50, 1, 0], [0, 1, 0]], "element 1 has an aspect ratio of 50; expected <= 40"),
        ([[0, 0, 0], [1, 0, 0], [0.2, 0.2, 0], [0, 1, 0]], "element 1 has a corner ratio of"),
        ([[0, 0, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]], "element 1 has a shortest edge of 0 m"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], "element 1 has a mean corner area of"),
    ],
)
def test_a_bad_element_is_refused_by_number(corners: list[list[float]], sentence: str) -> None:
    with pytest.raises(MeshError, match=sentence):
        of_quads([[0, 0, 9], [1, 0, 9], [1, 1, 9], [0, 1, 9], *corners], [[0, 1, 2, 3], [4, 5, 6, 7]])


def test_area_vectors_point_to_the_top_side() -> None:
    vectors = grid_mesh(np.linspace(0, 2, 5), np.linspace(0, 1, 3)).area_vectors()
    assert vectors.sum(axis=0) == pytest.approx([0, 0, 2])


def test_grid_lines_hold_every_stop_and_no_step_is_too_long() -> None:
    lines = grid_lines([1.0, 0.0, 0.24, 0.39], 0.1)
    assert set(np.round([0.0, 0.24, 0.39, 1.0], 12)) <= set(np.round(lines, 12))
    assert np.diff(lines).max() <= 0.1 + 1e-12
    assert np.diff(lines).min() > 0


@pytest.mark.parametrize("shape", ["quads", "trias"])
def test_an_element_turned_over_is_refused_by_number(shape: str) -> None:
    nodes = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]], dtype=float)
    quads, trias = np.array([[0, 1, 4, 3], [1, 4, 5, 2]]), np.array([[0, 1, 4], [1, 4, 2]])
    none = np.zeros((0, 3 if shape == "quads" else 4), dtype=np.int64)
    corners = (quads, none) if shape == "quads" else (none, trias)
    with pytest.raises(MeshError, match="element 1 has its top side where its neighbour 0 has its bottom side"):
        Mesh(nodes, *corners, ("p",), np.zeros(2, dtype=np.int64))
    assert Mesh(nodes, *corners, ("p", "q"), np.array([0, 1])).n_elements == 2  # patches may meet as they like


def test_three_elements_may_meet_at_an_edge() -> None:
    nodes = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, -1, 0], [1, -1, 0], [0, 0, 1], [1, 0, 1]]
    assert of_quads(nodes, [[0, 1, 3, 2], [0, 1, 5, 4], [0, 1, 7, 6]]).n_elements == 3
