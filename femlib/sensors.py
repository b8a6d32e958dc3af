"""Strain gauges: strain at a point, along a direction, on a side of a shell, as a linear map of the displacements.

The strain inside one element is first-order accurate away from its centre. A gauge therefore reads the nodal averages
of its element: at each corner the mean of the centre strains of the adjoining elements of the same patch, weighted by
1 / area (exact for a linear field on a rectangular grid), then the element's own shape functions between the corners.
Elements of other patches never enter, so a damage region's edge, where strain jumps, is not smeared. In a triangle the
corners have the value of a linear fit to the mean strains of all elements around them, `LEAST_FITTED` at least: the
triangles at a node do not lie evenly about it, as rectangles do.

Source of the fit: O. C. Zienkiewicz, J. Z. Zhu, Int. J. Numer. Meth. Engng 33 (1992) 1331-1364 (patch recovery).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.elements.frame import StrainOperator
from femlib.elements.middle import middles
from femlib.elements.surface import shape
from femlib.errors import InputError, frozen_floats, is_number
from femlib.mesh import Mesh, dofs_of_nodes, shell_sides

STEEPEST = 0.1
"""Least share of a gauge's direction that must lie in the surface: 6 degrees from the normal."""
SAGITTA = 0.25
"""Distance of a gauge from its element, over the longest edge times the sine of the angle to an element around it, that
a curved surface explains; an arc leaves its chord by 0.125. Besides, a gauge may stand off by the thickness."""
SMOOTH = 0.7
"""Cosine of the angle between elements of one curved surface, at least."""
LEAST_FITTED = 6
"""Elements of a triangle's fit at a corner, if the patch has so many within two rings."""
N_NEAREST = 96
"""Elements, nearest by centroid, among which a gauge's element is looked for."""
MOST_STRAIN = 50_000.0
"""Largest strain [microstrain] of linear analysis: carbon breaks at a third of it, metals yield at a tenth."""


@dataclass(frozen=True, slots=True, eq=False)
class StrainGauge:
    """One gauge on a shell patch.

    Attributes
    ----------
    name : str
        Name.
    position : FloatArray
        Point (3,) [m]; it is projected on the element.
    direction : FloatArray
        Measuring direction (3,), projected on the element; its length does not matter.
    patches : tuple of str
        Patches in which the gauge's element is looked for.
    side : float
        Height over half the thickness: 1 top, 0 middle, -1 bottom.

    Examples
    --------
    >>> StrainGauge("g1", position=(0.5, 0.5, 0.0), direction=(1, 0, 0), patches=("skin",)).position.tolist()
    [0.5, 0.5, 0.0]
    """

    name: str
    position: FloatArray | Any  # given as lists too
    direction: FloatArray | Any
    patches: tuple[str, ...]
    side: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen_floats(self.position, f"gauge {self.name} position", (3,)))
        object.__setattr__(self, "direction", frozen_floats(self.direction, f"gauge {self.name} direction", (3,)))
        if not self.direction.any():
            raise InputError(f"gauge {self.name} direction is zero; expected a direction along the surface; give one")
        if isinstance(self.patches, str) or not self.patches:
            raise InputError(f"gauge {self.name} patches are {self.patches!r}; expected a list of names; name one")
        if not is_number(self.side) or not -1.0 <= self.side <= 1.0:
            raise InputError(f"gauge {self.name} side is {self.side!r}; expected -1 (bottom) to 1 (top); correct it")


@dataclass(frozen=True, slots=True)
class Spot:
    """The place of a gauge: element number and natural coordinates in it (area coordinates 2 and 3 of a triangle)."""

    element: int
    xi: float
    eta: float


def strain_rows(mesh: Mesh, thickness: FloatArray, gauges: Sequence[StrainGauge]) -> sparse.csr_array:
    """Return the map (n_gauges, n_dofs) from displacements to strain, tension positive [-].

    Parameters
    ----------
    mesh : Mesh
        The shells.
    thickness : FloatArray
        Thickness of each element (n_elements,) [m].
    gauges : sequence of StrainGauge
        The gauges.

    Raises
    ------
    InputError
        If a gauge lies outside its patches or measures along the normal.
    """
    return assembled_rows(mesh, element_rows(mesh, thickness, gauges))


def assembled_rows(mesh: Mesh, of_elements: Sequence[Mapping[int, FloatArray]]) -> sparse.csr_array:
    """Return the map (n_gauges, n_dofs) of the rows that `element_rows` gives."""
    rows = np.zeros((len(of_elements), mesh.n_dofs))
    for row, parts in zip(rows, of_elements, strict=True):
        for element, strain in parts.items():
            row[dofs_of_nodes(mesh.corners_of(element)).ravel()] += strain
    return sparse.csr_array(rows)


def element_rows(mesh: Mesh, thickness: FloatArray, gauges: Sequence[StrainGauge]) -> list[dict[int, FloatArray]]:
    """Return for each gauge the elements it averages and their rows (24,) or (18,), weights included; as `strain_rows`.

    A gauge's strain is the sum of row @ displacements of the element, or @ its deformation where it moved far.
    """
    if not isinstance(gauges, Sequence) or not all(isinstance(gauge, StrainGauge) for gauge in gauges):
        raise InputError(f"gauges are a {type(gauges).__name__}; expected a list of StrainGauge; put them in a list")
    if not gauges:
        raise InputError("no gauges were given; expected at least one; add a StrainGauge")
    names = [gauge.name for gauge in gauges]
    if len(set(names)) < len(names):
        raise InputError(f"gauges are named {names}; expected each name once; rename one")
    thickness = frozen_floats(thickness, "thickness", (mesh.n_elements,))
    if (thickness <= 0.0).any():
        bad = int(np.flatnonzero(thickness <= 0.0)[0])
        raise InputError(f"thickness of element {bad} is {thickness[bad]} m; expected more than 0; correct it")
    of_gauges = element_weights(mesh, gauges, thickness)
    operators = middle_operators(mesh, np.unique([element for weights in of_gauges for element in weights]))
    rows = []
    for gauge, weights in zip(gauges, of_gauges, strict=True):
        parts = {}
        for element, weight in weights.items():
            height = gauge.side * thickness[element] / 2.0
            parts[element] = weight * _strain_row(operators[element], gauge.direction, height, gauge.name)
        rows.append(parts)
    return rows


def locate(mesh: Mesh, gauge: StrainGauge) -> Spot:
    """Return the element and the natural coordinates of a gauge.

    Raises
    ------
    InputError
        If no element of the gauge's patches holds the point.
    """
    candidates = np.concatenate([mesh.elements_in(patch) for patch in gauge.patches])
    distance = np.linalg.norm(mesh.centroids()[candidates] - gauge.position, axis=1)
    nearest = candidates[np.argsort(distance, kind="stable")[:N_NEAREST]]
    places, over = _places(mesh, nearest, gauge.position)
    best = int(np.lexsort((nearest, over))[0])
    element, (xi, eta) = int(nearest[best]), places[best]
    if over[best] > 1e-6:
        raise InputError(
            f"gauge {gauge.name} at {[round(float(p), 4) for p in gauge.position]} m lies outside "
            f"{list(gauge.patches)} (nearest element {element}); expected a point of the patch; move the gauge"
        )
    return Spot(element, float(np.clip(xi, -1.0, 1.0)), float(np.clip(eta, -1.0, 1.0)))


def _check_distance(mesh: Mesh, gauge: StrainGauge, spot: Spot, thickness: float, around: list[IntArray]) -> None:
    """Refuse a gauge that lies off the surface."""
    corners = mesh.corners_of(spot.element)
    points = mesh.nodes[corners]
    away = float(np.linalg.norm(gauge.position - _corner_shares(mesh, spot) @ points))
    longest = float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).max())
    normals = mesh.area_vectors()[np.unique(np.concatenate([around[k] for k in corners]))]
    own = mesh.area_vectors()[spot.element]
    cosines = normals @ own / np.linalg.norm(normals, axis=1) / np.linalg.norm(own)
    smooth = np.minimum(cosines[cosines > SMOOTH], 1.0)
    most = thickness + SAGITTA * longest * float(np.sqrt(1.0 - smooth.min() ** 2))
    if away > most:
        raise InputError(
            f"gauge {gauge.name} at {[round(float(p), 4) for p in gauge.position]} m lies {away:.3g} m off element "
            f"{spot.element} of {list(gauge.patches)}; expected at most {most:.2g} m, the thickness and what the "
            "surface's curvature explains; move the gauge onto the surface"
        )


def _corner_shares(mesh: Mesh, spot: Spot) -> FloatArray:
    """Return the shape functions (4,) or (3,) at a spot."""
    if spot.element < len(mesh.quads):
        return shape(spot.xi, spot.eta)
    return np.array([1.0 - spot.xi - spot.eta, spot.xi, spot.eta])


def _places(mesh: Mesh, elements: IntArray, position: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a point's coordinates (n, 2) in elements and how far it lies outside each (n,)."""
    places, over = np.zeros((len(elements), 2)), np.zeros(len(elements))
    four = elements < len(mesh.quads)
    places[four] = _natural(mesh.nodes[mesh.quads[elements[four]]], position)
    over[four] = np.hypot(*np.maximum(0.0, np.abs(places[four]) - 1.0).T)
    points = mesh.nodes[mesh.trias[elements[~four] - len(mesh.quads)]]
    sides = points[:, 1:] - points[:, :1]  # rows: from corner 1 to corners 2 and 3
    right = np.einsum("nsi,ni->ns", sides, position - points[:, 0])
    places[~four] = np.linalg.solve(sides @ sides.transpose(0, 2, 1), right[:, :, None])[:, :, 0]
    over[~four] = np.maximum(0.0, np.maximum(-places[~four].min(axis=1, initial=0.0), places[~four].sum(axis=1) - 1.0))
    return places, over


def middle_operators(mesh: Mesh, elements: IntArray) -> dict[int, StrainOperator]:
    """Return the strain rows at the middle of each of some elements."""
    found: dict[int, StrainOperator] = {}
    for corners, first in ((mesh.quads, 0), (mesh.trias, len(mesh.quads))):
        own = elements[(first <= elements) & (elements < first + len(corners))]
        if own.size:
            many = middles(mesh.nodes[corners[own - first]])
            each = zip(many.membrane, many.curvature, many.axes, strict=True)
            found |= {int(element): StrainOperator(*parts) for element, parts in zip(own, each, strict=True)}
    return found


def _strain_row(operator: StrainOperator, direction: FloatArray, height: float, name: str) -> FloatArray:
    """Return the row (24,) or (18,) of strain at the middle of one element, without averaging, at `height` [m]."""
    along = operator.axes.T @ direction
    length = np.hypot(along[0], along[1])
    if length < STEEPEST * np.linalg.norm(direction):
        raise InputError(f"gauge {name} measures along the shell's normal; expected one in the surface; turn it")
    c, s = along[0] / length, along[1] / length
    weights = np.array([c * c, s * s, c * s])
    return np.asarray(weights @ (operator.membrane + height * operator.curvature))


def element_weights(
    mesh: Mesh, gauges: Sequence[StrainGauge], thickness: FloatArray | None = None
) -> list[dict[int, float]]:
    """Return for each gauge the elements whose centre strains it averages, and their weights, which sum to one.

    With `thickness` (n_elements,) [m] a gauge that lies off the surface is refused.
    """
    around = _elements_at_nodes(mesh)
    areas = np.linalg.norm(mesh.area_vectors(), axis=1)
    found = []
    for gauge in gauges:
        spot = locate(mesh, gauge)
        if thickness is not None:
            _check_distance(mesh, gauge, spot, float(thickness[spot.element]), around)
        found.append(_weights(mesh, spot, around, areas))
    return found


def _weights(mesh: Mesh, spot: Spot, around: list[IntArray], areas: FloatArray) -> dict[int, float]:
    patch = mesh.patch_of_element[spot.element]
    is_triangle = spot.element >= len(mesh.quads)
    weights: dict[int, float] = {}
    for corner, share in zip(mesh.corners_of(spot.element), _corner_shares(mesh, spot), strict=True):
        own = around[corner][mesh.patch_of_element[around[corner]] == patch]
        if is_triangle:
            own, parts = _fitted(mesh, int(corner), own, around, patch)
        else:
            own = own[own < len(mesh.quads)]
            inverse = np.array([1.0 / areas[e] for e in own])
            parts = inverse / inverse.sum()
        for element, part in zip(own.tolist(), (share * parts).tolist(), strict=True):
            weights[element] = weights.get(element, 0.0) + part
    return weights


def _fitted(
    mesh: Mesh, corner: int, own: IntArray, around: list[IntArray], patch: np.int64
) -> tuple[IntArray, FloatArray]:
    """Return elements of a patch at a node and the weights (n,) of their values in a linear fit's value at the node."""
    if len(own) < LEAST_FITTED:
        nodes = np.unique(np.concatenate([mesh.corners_of(e) for e in own]))
        own = np.unique(np.concatenate([around[k] for k in nodes]))
        own = own[mesh.patch_of_element[own] == patch]
    corners = [mesh.nodes[mesh.corners_of(e)].mean(axis=0) for e in own]
    offset = np.array(corners) - mesh.nodes[corner]
    normal = mesh.area_vectors()[own].sum(axis=0)
    _, _, axes = np.linalg.svd(np.eye(3) - np.outer(normal, normal) / (normal @ normal))
    flat = offset @ axes[:2].T / np.abs(offset).max()
    basis = np.column_stack([np.ones(len(own)), flat])
    return own, np.asarray(np.linalg.pinv(basis, rcond=1e-6)[0])


def _elements_at_nodes(mesh: Mesh) -> list[IntArray]:
    """Return for each node the elements that touch it, in increasing order."""
    sides, element = shell_sides(mesh.quads, mesh.trias)
    corners = sides[:, 0]
    order = np.argsort(corners, kind="stable")
    return np.split(element[order], np.cumsum(np.bincount(corners, minlength=len(mesh.nodes)))[:-1])


def _natural(points: FloatArray, position: FloatArray) -> FloatArray:
    """Return (xi, eta) (n, 2) of the projection of `position` on bilinear surfaces (n, 4, 3), by Gauss-Newton."""
    places = np.zeros((len(points), 2))
    for _ in range(6):
        xi, eta = places.T
        along_xi = 0.25 * np.stack([eta - 1, 1 - eta, 1 + eta, -1 - eta], axis=1)
        along_eta = 0.25 * np.stack([xi - 1, -1 - xi, 1 + xi, 1 - xi], axis=1)
        shapes = 0.25 * np.stack(
            [(1 - xi) * (1 - eta), (1 + xi) * (1 - eta), (1 + xi) * (1 + eta), (1 - xi) * (1 + eta)]
        )
        gap = position - np.einsum("kn,nki->ni", shapes, points)
        slopes = np.einsum("skn,nki->nsi", np.stack([along_xi.T, along_eta.T]), points)
        right = np.einsum("nsi,ni->ns", slopes, gap)
        step = np.linalg.solve(slopes @ slopes.transpose(0, 2, 1), right[:, :, None])[:, :, 0]
        places = np.clip(places + step, -3.0, 3.0)
    return places


def checked_strains(strains: FloatArray) -> FloatArray:
    """Return gauge strains (..., n_gauges) [microstrain]; InputError if one is beyond the range of linear analysis."""
    if not float(np.vdot(strains, strains)) <= MOST_STRAIN**2 and not np.abs(strains).max() <= MOST_STRAIN:
        worst = float(np.abs(strains).max())
        raise InputError(
            f"strain would be {worst:.3g} microstrain; expected at most {MOST_STRAIN:g}, beyond which linear analysis "
            "is meaningless; lower the load, and check that lengths are in m, forces in N, moduli in Pa"
        )
    return strains
