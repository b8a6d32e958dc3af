"""Strains at nodes from those of elements: linear fits that reach the edges of a part, or means over a length.

At a node of a part the tensor is a linear fit to the means of the part's elements there, in proportion to their areas.
At the edge of a part the next row of elements counts too, by `FAR`: the first row's mean is half an element's slope too
low, and its points say nothing of that slope where an element is bent. Directions in which there is no second element
are left to the points of integration. Strains that grow in proportion to the distance are met up to the edge.

With a length d a node has the mean strain of what of its part lies within d, since a material does not feel the peak of
a singular point. Where all elements there are smaller than `SMALL` d that is the mean of the strains inside elements,
each cut in `CUTS` squared; else the fit is read at the middle of the sectors of radius d.

Sources: O. C. Zienkiewicz, J. Z. Zhu, Int. J. Numer. Meth. Engng 33 (1992) 1331-1364 (fits to patches, at boundaries
those of the nodes inside); J. M. Whitney, R. J. Nuismer, J. Composite Materials 8 (1974) 253-265 (mean stress over a
length). Price: two rows of elements do not show how a slope changes.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.spatial import cKDTree

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly.integration import PointStrains
from femlib.assembly.shells import Shells
from femlib.elements.surface import CORNERS, shape
from femlib.errors import InputError, is_number

FAR = 0.01
"""Weight of the second row: the first is met, the second gives the slope."""
INSIDE = 1e-3
"""Weight of points beside the means of their elements, for directions that these leave open."""
SMALL, CUTS = 1.3, 4
"""Sides over the length up to which elements are cut, and in how many parts such a side is."""
MOST_LONG = 16.0
"""Times that length that a side's cells still keep their size."""
EDGE = 0.05
"""Distance of the middle of what lies within the length over the length, beyond which a node is at an edge."""
MOST_PAIRS = 20_000_000
"""Nodes times points within the length, at most: some 2 GB."""


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Pieces of elements: middles (n, 3) [m], areas (n,) [m^2], parts (n,), and strains of points' (n, n_points)."""

    place: FloatArray
    area: FloatArray
    part: IntArray
    values: sparse.csr_array


def nodal_tensors(shells: Shells, kinds: list[PointStrains], length: float = 0.0) -> tuple[IntArray, FloatArray]:
    """Return names of nodes and parts (g,), as `PointStrains.group`, and the tensors (g, 18) there.

    Parameters
    ----------
    shells : Shells
        The structure.
    kinds : list of PointStrains
        Its elements with their strains.
    length : float
        Length [m] that strains are means over; 0 for those of the points themselves.

    Raises
    ------
    InputError
        If the length is no number of 0 or more, or spans too many elements.
    """
    if not is_number(length) or length < 0.0:
        raise InputError(f"length is {length!r}; expected 0 or more m; give that over which the material fails")
    names, rows = shells.nodal_rows.get(float(length), lambda: _nodal_rows(shells, kinds, float(length)))
    return names, np.asarray(rows @ np.concatenate([kind.tensors().reshape(-1, 18) for kind in kinds]))


def _nodal_rows(shells: Shells, kinds: list[PointStrains], length: float) -> tuple[IntArray, sparse.csr_array]:
    """Return the names (g,) and the weights (g, n_points) of all points of integration."""
    names, group = np.unique(np.concatenate([kind.group.ravel() for kind in kinds]), return_inverse=True)
    node, element = shells.mesh.nodes[names // shells.n_smooth], _elements([kind.group for kind in kinds])
    of_point = _elements([kind.area for kind in kinds])
    at = sparse.csr_array((np.ones(len(group)), (group, element)))
    points = sparse.csr_array((np.ones(len(of_point)), (of_point, np.arange(len(of_point)))))
    places = np.concatenate([(kind.shapes @ kind.points).reshape(-1, 3) for kind in kinds])
    area = np.concatenate([kind.area.ravel() for kind in kinds])
    whole = points @ area
    means = sparse.csr_array(sparse.diags_array(1.0 / whole) @ points @ sparse.diags_array(area))
    far = sparse.diags_array(FAR * _is_edge(kinds, names)) @ _ones(at @ (at.T @ at))
    weight = sparse.hstack([at.maximum(far) @ sparse.diags_array(whole), INSIDE * (at @ points) * area], "csr")
    read = _middles(kinds, group, node, length)
    tangents = _tangents(_normals(kinds, group, len(names)))
    fits = _fits(weight, np.concatenate([means @ places, places]), node, read, tangents)
    rows = fits @ sparse.vstack([means, sparse.eye_array(len(places))], "csr")
    if length > 0.0:
        is_small = _extents(kinds, group, read, length) <= SMALL * length
        if is_small.any():
            cells = _cells(kinds, node[is_small], shells.n_smooth, length)
            means = _means(cells, np.flatnonzero(is_small), node, names % shells.n_smooth, length)
            rows = sparse.diags_array(1.0 * ~is_small) @ rows + means
    return names, sparse.csr_array(rows)


def _fits(
    weight: sparse.csr_array, places: FloatArray, node: FloatArray, read: FloatArray, tangents: FloatArray
) -> sparse.csr_array:
    """Return the rows (g, n) of linear fits to values at places (n, 3) with weights (g, n), read beside the nodes."""
    pairs = sparse.coo_array(weight)
    row, column, w = pairs.row, pairs.col, pairs.data
    scaled = tangents / np.sqrt(weight.sum(axis=1))[:, None, None]
    basis = _basis(places[column] - node[row], scaled[row])
    matrix = np.zeros((len(node), 3, 3))
    np.add.at(matrix, row, (w / weight.sum(axis=1)[row])[:, None, None] * basis[:, :, None] * basis[:, None])
    wanted = (_basis(read, scaled)[:, None] @ np.linalg.pinv(matrix, rcond=1e-9, hermitian=True))[:, 0]
    values = w / weight.sum(axis=1)[row] * np.einsum("pi,pi->p", wanted[row], basis)
    return sparse.csr_array((values, (row, column)), shape=weight.shape)


def _elements(of_kinds: list[FloatArray] | list[IntArray]) -> IntArray:
    """Return the number of the element that each entry of arrays (n_elements, m), one a kind, belongs to."""
    sizes = np.concatenate([np.full(*own.shape) for own in of_kinds])
    return np.repeat(np.arange(len(sizes)), sizes)


def _ones(matrix: sparse.csr_array) -> sparse.csr_array:
    """Return the matrix with 1 for each entry."""
    found = sparse.csr_array(matrix)
    return sparse.csr_array((np.ones(len(found.data)), found.indices, found.indptr), shape=found.shape)


def _is_edge(kinds: list[PointStrains], names: IntArray) -> BoolArray:
    """Return which of the nodes and parts (g,) lie at the edge of their part."""
    sides = np.concatenate([np.stack([k.group, np.roll(k.group, -1, 1)], axis=2).reshape(-1, 2) for k in kinds])
    once, count = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    return np.isin(names, once[count == 1])


def _extents(kinds: list[PointStrains], group: IntArray, read: FloatArray, length: float) -> FloatArray:
    """Return how far elements at nodes and parts (g,) reach [m]: across an edge, elsewhere where they are short.

    Elements are long where strains change slowly.
    """
    found, first = np.zeros(len(read)), 0
    size = np.linalg.norm(read, axis=1)
    inward = read / np.maximum(size, 1e-300)[:, None]
    for kind in kinds:
        own = group[first : first + kind.group.size].reshape(kind.group.shape)
        first += kind.group.size
        sides = np.stack([np.roll(kind.points, step, axis=1) - kind.points for step in (-1, 1)])
        across = np.abs(np.einsum("seni,eni->sen", sides, inward[own])).max(axis=0)
        least = np.linalg.norm(sides[0], axis=2).min(axis=1, keepdims=True)
        np.maximum.at(found, own, np.where(size[own] > EDGE * length, across, least))
    return found


def _means(cells: Cells, asked: IntArray, node: FloatArray, part: IntArray, length: float) -> sparse.csr_array:
    """Return the rows (g, n_points) of means over what lies within the length of the nodes `asked`, others empty.

    `part` (g,) are those of the nodes. A cell's share falls from 1 to 0 while the length's end crosses its square.
    """
    tree, reach = cKDTree(cells.place), 1.5 * length
    counts = tree.query_ball_point(node[asked], reach, return_length=True)
    if counts.sum() > MOST_PAIRS:
        raise InputError(
            f"length is {length:g} m, within which nodes have {counts.mean():.0f} cells of elements; expected at most "
            f"{MOST_PAIRS // len(asked)}; make the mesh coarser or the length shorter"
        )
    found = np.concatenate([np.asarray(own, dtype=np.int64) for own in tree.query_ball_point(node[asked], reach)])
    row = np.repeat(asked, counts)
    away = np.linalg.norm(cells.place[found] - node[row], axis=1)
    share = np.clip((length - away) / np.sqrt(cells.area[found]) + 0.5, 0.0, 1.0) * cells.area[found]
    share *= part[row] == cells.part[found]
    shares = sparse.csr_array((share, (row, found)), shape=(len(node), len(cells.place)))
    shares.eliminate_zeros()
    return sparse.csr_array(sparse.diags_array(1.0 / np.maximum(shares.sum(axis=1), 1e-300)) @ shares @ cells.values)


def _cells(kinds: list[PointStrains], asked: FloatArray, n_parts: int, length: float) -> Cells:
    """Return the cells of the elements near places `asked` (n, 3)."""
    near, first, found = cKDTree(asked), 0, []
    for kind in kinds:
        sides = np.linalg.norm(np.roll(kind.points, -1, 1) - kind.points, axis=2)
        is_near = near.query(kind.points.mean(axis=1))[0] <= 1.5 * length + sides.sum(axis=1) / 3.0
        along = np.stack([sides[:, 0::2].max(axis=1), sides[:, 1::2].max(axis=1)], axis=1)
        asks = np.clip(along if sides.shape[1] == 4 else sides.max(axis=1, keepdims=True).repeat(2, 1), 0.0, None)
        cuts = CUTS * 2 ** np.ceil(np.log2(np.clip(asks / (SMALL * length), 1.0, MOST_LONG))).astype(np.int64)
        n_points = kind.area.shape[1]
        for pair in np.unique(cuts[is_near], axis=0).tolist():
            own = np.flatnonzero(is_near & (cuts == pair).all(axis=1))
            inside = _inside(kind.shapes, *pair)
            place = (inside @ kind.points[own]).reshape(-1, 3)
            area = np.repeat(kind.area[own].sum(axis=1) / len(inside), len(inside))
            part = np.repeat(kind.group[own, 0] % n_parts, len(inside))
            point = first + own[:, None, None] * n_points + np.arange(n_points)
            point = np.broadcast_to(point, (len(own), len(inside), n_points)).ravel()
            weight = np.broadcast_to(inside @ np.linalg.inv(kind.shapes), (len(own), len(inside), n_points)).ravel()
            found.append((place, area, part, point, weight))
        first += kind.area.size
    places, areas, parts = (np.concatenate([own[k] for own in found]) for k in range(3))
    points, weights = (np.concatenate([own[k] for own in found]) for k in (3, 4))
    ends = np.concatenate([[0], *(np.full(len(p), len(w) // len(p)) for p, *_, w in found)]).cumsum()
    return Cells(places, areas, parts, sparse.csr_array((weights, points, ends), shape=(len(places), first)))


def _inside(shapes: FloatArray, n_r: int, n_s: int) -> FloatArray:
    """Return the shape functions (n_cells, n) at the middles of an element's cells, n_r by n_s of a quadrilateral."""
    if shapes.shape[1] == len(CORNERS):
        along, across = ((2.0 * np.arange(n) + 1.0) / n - 1.0 for n in (n_r, n_s))
        return np.array([shape(r, s) for r in along.tolist() for s in across.tolist()])
    n = n_r
    third = np.array([(3 * i + 1 + k, 3 * j + 1 + k) for i in range(n) for j in range(n - i) for k in (0, 1)])
    third = third[third.sum(axis=1) < 3 * n] / (3.0 * n)
    return np.column_stack([1.0 - third.sum(axis=1), third])


def _middles(kinds: list[PointStrains], group: IntArray, node: FloatArray, length: float) -> FloatArray:
    """Return the middles (g, 3) [m], seen from the nodes, of the sectors that the elements there have within a length.

    A sector of angle t has its middle at 4 d sin(t / 2) / (3 t).
    """
    offset, angles, first = np.zeros_like(node), np.zeros(len(node)), 0
    for kind in kinds:
        sides = [np.roll(kind.points, step, axis=1) - kind.points for step in (-1, 1)]
        ahead, back = (side / np.linalg.norm(side, axis=2, keepdims=True) for side in sides)
        angle = np.arccos(np.clip(np.sum(ahead * back, axis=2), -1.0, 1.0))
        inward = (ahead + back) / np.maximum(np.linalg.norm(ahead + back, axis=2, keepdims=True), 1e-300)
        own = group[first : first + kind.group.size]
        first += kind.group.size
        np.add.at(angles, own, angle.ravel())
        np.add.at(offset, own, (4.0 / 3.0 * length * np.sin(0.5 * angle)[..., None] * inward).reshape(-1, 3))
    return np.asarray(offset / angles[:, None])


def _normals(kinds: list[PointStrains], group: IntArray, n: int) -> FloatArray:
    """Return the normals (n, 3) at nodes and parts, of any length."""
    normal, first = np.zeros((n, 3)), 0
    for kind in kinds:
        own = group[first : first + kind.group.size].reshape(kind.group.shape)
        first += kind.group.size
        np.add.at(normal, own, np.einsum("emi,em->ei", kind.axes[..., 2], kind.area)[:, None])
    return normal


def _basis(offset: FloatArray, tangents: FloatArray) -> FloatArray:
    """Return 1 and the offsets (n, 3) along tangents (n, 3, 2)."""
    return np.column_stack([np.ones(len(offset)), np.einsum("ni,nij->nj", offset, tangents)])


def _tangents(normals: FloatArray) -> FloatArray:
    """Return two directions across normals (n, 3) as columns (n, 3, 2); of any length but not parallel to it."""
    away = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, away)
    second = np.cross(normals, first)
    both = np.stack([first, second], axis=2)
    return np.asarray(both / np.maximum(np.linalg.norm(both, axis=1, keepdims=True), 1e-300))
