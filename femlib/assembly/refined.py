"""The same structure on a mesh with every element cut in four, once or twice: what a solution is compared with.

New nodes lie on the smooth surface through the elements that meet within `edges.SMOOTH`: on the side from a to b,
d = b - a, the middle of the cubic that is normal to n_a and n_b at its ends,

    (a + b) / 2 + (n_b (n_b . d) - n_a (n_a . d)) / 8.

Loads go over as the tractions on elements and edges whose nodes are all loaded that come nearest to them. The rest is
spread: f' = P (P' P)^-1 f, P from the displacements of the coarse nodes to those of the fine ones, does the work of f
on every motion that the coarse mesh has. At coarse nodes alone loads would be points, under which a finer mesh yields
ever more; spread alone they would not pull evenly, and a plate under one stress was called 14 % off. At nodes of beams
alone they stay: a beam is exact for forces at its ends.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly.built_up import Beams, BuiltUp
from femlib.assembly.edges import bends, corner_normals
from femlib.assembly.loads import edge_shares, surface_shares
from femlib.assembly.shells import Shells
from femlib.assembly.supports import Supports
from femlib.mesh import DOFS_PER_NODE, Mesh, QualityLimits, dofs_of_nodes, shell_sides

MOST_UNKNOWNS = 60_000
"""Degrees of freedom of the finer mesh, at most: some 5 CPU seconds."""
MOST_CUTS = 2
"""A strip of one element changes little if it is cut in two, and much if in four."""
ROUNDING = 1e-8
"""Share of the largest load that counts as none."""
ANY_SHAPE = QualityLimits(warp=1e9, aspect=1e9, distortion=0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """A structure on the finer mesh.

    Attributes
    ----------
    shells : Shells
        Its parts, each in place of one of the coarse mesh.
    supports : Supports
        A new node is held as all the nodes are that it lies between.
    parent : IntArray
        Part of the coarse mesh that each part lies in (n_fine_parts,).
    between : csr_array
        Shares (n_fine_nodes, n_nodes) of the coarse nodes in the fine ones.
    motion : csr_array
        P (n_fine_dofs, n_dofs): these shares of all displacements, and the bending of edges by their ends' rotations.
    spread : IntArray
        Nodes of the coarse shells, whose loads are spread.
    coarse : Mesh
        The mesh that was cut.
    cuts : int
        How often the elements were cut in four.
    """

    shells: Shells
    supports: Supports
    parent: IntArray
    between: sparse.csr_array
    motion: sparse.csr_array
    spread: IntArray
    coarse: Mesh
    cuts: int = 1

    @classmethod
    def of(cls, shells: Shells, supports: Supports) -> "Refined":
        """Return the refined structure."""
        mesh = shells.mesh
        quads, trias, n = mesh.quads, mesh.trias, len(mesh.nodes)
        ends = shells.beams.ends if isinstance(shells, BuiltUp) else np.zeros((0, 2), dtype=np.int64)
        every = np.sort(np.concatenate([shell_sides(quads, trias)[0], ends]), axis=1)
        edges, number = np.unique(every, axis=0, return_inverse=True)
        number = number.ravel() + n
        q, t = 4 * len(quads), 3 * len(trias)
        of_quads, of_trias, of_beams = number[:q].reshape(-1, 4), number[q : q + t].reshape(-1, 3), number[q + t :]
        middle = n + len(edges) + np.arange(len(quads))
        between = _between(n, edges, quads)
        motion = _motion(mesh, edges, of_quads - n, between)
        nodes = _places(mesh, edges, of_quads, of_trias)
        fine = Mesh(
            nodes,
            _quarters(quads, of_quads, middle),
            _quarters_of_trias(trias, of_trias),
            mesh.patches,
            np.repeat(mesh.patch_of_element, 4),
            ANY_SHAPE,
        )
        parts = _on(shells, fine, of_beams)
        repeats = np.full(shells.n_elements, 4)
        repeats[mesh.n_elements :] = 1
        repeats[mesh.n_elements : mesh.n_elements + len(ends)] = 2
        free = np.zeros(mesh.n_dofs)
        free[supports.free] = 1.0
        moves = (between @ free.reshape(n, DOFS_PER_NODE)).ravel() > 0.0
        parent = np.repeat(np.arange(shells.n_elements), repeats)
        spread = np.unique(np.concatenate([quads.ravel(), trias.ravel()]))
        return cls(parts, Supports(fine.n_dofs, np.flatnonzero(moves)), parent, between, motion, spread, mesh)

    @classmethod
    def finest(cls, shells: Shells, supports: Supports) -> "Refined | None":
        """Return the structure cut as often as `MOST_CUTS` and `MOST_UNKNOWNS` let it be; None if not once."""
        found = None
        for _ in range(MOST_CUTS):
            # a closed surface has four times as many nodes then; an open one a little less
            if 4 * len(supports.free) > MOST_UNKNOWNS:
                break
            once = cls.of(shells, supports)
            if found is not None:
                both, motion = once.between @ found.between, once.motion @ found.motion
                parent = found.parent[once.parent]
                maps = (sparse.csr_array(both), sparse.csr_array(motion))
                once = cls(once.shells, once.supports, parent, *maps, found.spread, found.coarse, found.cuts + 1)
            found = once
            shells, supports = found.shells, found.supports
        return found

    @property
    def share(self) -> float:
        """What is left of an error of second order, added to a difference: the difference times this is the error."""
        return 1.0 / (1.0 - 0.25**self.cuts)

    def factor(self, factor: FloatArray | None) -> FloatArray | None:
        """Return a factor on each part (n_parts,) as that of the fine mesh (n_fine_parts,)."""
        return None if factor is None else factor[self.parent]

    def load(self, load: FloatArray) -> FloatArray:
        """Return nodal forces (n_dofs,) as those of the fine mesh (n_fine_dofs,)."""
        even = self._even(load)
        rest, fine = load - self.motion.T @ even, even
        held = dofs_of_nodes(self.spread).ravel()
        # of a load that is even on its elements and edges rounding alone is left
        if np.abs(rest[held]).max(initial=0.0) > ROUNDING * np.abs(load).max():
            on = self.motion[:, held]
            is_shell = self.between[:, self.spread].sum(axis=1) > 1.0 - 1e-9  # not the middle of a beam
            on = sparse.csr_array(sparse.diags_array(np.repeat(is_shell, DOFS_PER_NODE).astype(np.float64)) @ on)
            fine = fine + on @ splu(sparse.csc_array(on.T @ on)).solve(rest[held])
        rest[held] = 0.0
        fine[: len(rest)] += rest
        return np.asarray(fine)

    def _even(self, load: FloatArray) -> FloatArray:
        """Return the forces (n_fine_dofs,) of even tractions that are near to loads (n_dofs,).

        On edges between loaded nodes if these meet the loads, else on elements whose nodes are all loaded and on the
        edges between others.
        """
        coarse, fine = self.coarse, np.zeros(self.shells.mesh.n_dofs)
        is_loaded = np.asarray(load.reshape(-1, DOFS_PER_NODE)[:, :3].any(axis=1))
        inside: BoolArray = np.concatenate([is_loaded[coarse.quads].all(axis=1), is_loaded[coarse.trias].all(axis=1)])
        nothing: BoolArray = np.zeros(len(inside), dtype=np.bool_)
        for held in (nothing, inside):
            ends = _loaded_edges(coarse, is_loaded, held)
            on = sparse.hstack([_in_space(surface_shares(coarse)[:, held]), edge_shares(coarse, ends)], "csc")
            if not on.shape[1]:
                continue
            square = on.T @ on
            ridge = 1e-12 * square.diagonal().mean() * sparse.eye_array(on.shape[1])
            even = splu(sparse.csc_array(square + ridge)).solve(on.T @ load)
            fine = self._on_fine(held, ends, even)
            if np.abs(on @ even - load).max() <= ROUNDING * np.abs(load).max():
                break
        return fine

    def _on_fine(self, held: BoolArray, ends: IntArray, even: FloatArray) -> FloatArray:
        """Return the forces (n_fine_dofs,) of tractions on elements that are `held` and forces on edges (n, 2)."""
        mesh = self.shells.mesh
        lies_in = (np.arange(mesh.n_elements), self.parent[: mesh.n_elements])
        area = surface_shares(mesh) @ sparse.csr_array((np.ones(mesh.n_elements), lies_in))[:, held]
        halves, of_edge = _pieces(self.between, ends)
        lines = edge_shares(mesh, halves) @ sparse.kron(of_edge, sparse.eye_array(3), "csr")
        return np.asarray(sparse.hstack([_in_space(area), lines], "csr") @ even)


def _in_space(shares: sparse.csr_array) -> sparse.csr_array:
    """Return shares (n, m) as a map (6 n, 3 m) from tractions along x, y, z to nodal forces."""
    return sparse.csr_array(sparse.kron(shares, np.eye(DOFS_PER_NODE, 3), "csr"))


def _loaded_edges(mesh: Mesh, is_loaded: BoolArray, inside: BoolArray) -> IntArray:
    """Return the edges (n, 2) between loaded nodes that belong to no element `inside` the loads."""
    sides, shell = shell_sides(mesh.quads, mesh.trias)
    edges, number = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    is_inside = np.bincount(number.ravel(), weights=inside[shell], minlength=len(edges)) > 0.0
    return np.asarray(edges[is_loaded[edges].all(axis=1) & ~is_inside])


def _pieces(between: sparse.csr_array, ends: IntArray) -> tuple[IntArray, sparse.csr_array]:
    """Return the fine edges (m, 2) that edges with ends (n, 2) are cut into, and ones (m, n) where they lie in them."""
    columns, pieces, owner = sparse.csc_array(between), [], []
    for number, (first, last) in enumerate(ends.tolist()):
        near = [columns.indices[columns.indptr[k] : columns.indptr[k + 1]] for k in (first, last)]
        share = [columns.data[columns.indptr[k] : columns.indptr[k + 1]] for k in (first, last)]
        both, one, other = np.intersect1d(near[0], near[1], return_indices=True)
        along = share[0][one] + share[1][other] > 1.0 - 1e-9
        inner = both[along][np.argsort(-share[0][one][along])]
        path = np.concatenate([[first], inner, [last]])
        pieces.append(np.stack([path[:-1], path[1:]], axis=1))
        owner += [number] * (len(path) - 1)
    found = np.concatenate(pieces) if pieces else np.zeros((0, 2), dtype=np.int64)
    return found, sparse.csr_array((np.ones(len(owner)), (np.arange(len(owner)), owner)), shape=(len(owner), len(ends)))


def _on(shells: Shells, fine: Mesh, middle: IntArray) -> Shells:
    """Return the parts of shells on the finer mesh; `middle` (n_beams,) are the nodes that the beams gain."""
    section, scale = np.repeat(shells.section, 4), np.repeat(shells.scale, 4)
    if not isinstance(shells, BuiltUp):
        return Shells(fine, shells.laminates, section, scale, shells.axis)
    ends = shells.beams.ends
    halves = np.stack([ends[:, 0], middle, middle, ends[:, 1]], axis=1).reshape(-1, 2)
    return BuiltUp(
        mesh=fine,
        laminates=shells.laminates,
        section=section,
        scale=scale,
        axis=shells.axis,
        beams=Beams(halves, shells.beams.sections, np.repeat(shells.beams.section, 2)),
        springs=shells.springs,
        point_masses=np.concatenate([shells.point_masses, np.zeros(len(fine.nodes) - len(shells.mesh.nodes))]),
    )


def _between(n: int, edges: IntArray, quads: IntArray) -> sparse.csr_array:
    rows = [np.arange(n), n + np.repeat(np.arange(len(edges)), 2)]
    rows.append(n + len(edges) + np.repeat(np.arange(len(quads)), 4))
    columns = np.concatenate([np.arange(n), edges.ravel(), quads.ravel()])
    shares = np.concatenate([np.ones(n), np.full(edges.size, 0.5), np.full(quads.size, 0.25)])
    return sparse.csr_array(
        sparse.coo_array((shares, (np.concatenate(rows), columns)), shape=(n + len(edges) + len(quads), n))
    )


def _motion(mesh: Mesh, edges: IntArray, of_quads: IntArray, between: sparse.csr_array) -> sparse.csr_array:
    """Return P (n_fine_dofs, n_dofs); `of_quads` (n_quads, 4) are the edges of the quadrilaterals.

    Beside the mean of its ends the middle of an edge moves as their rotations bend it (`bends`), the middle of a
    quadrilateral by half of its edges' sum.
    """
    n, bent = len(mesh.nodes), bends(mesh, edges)
    at = (np.repeat(np.arange(len(of_quads)), 4), of_quads.ravel())
    middles = sparse.csr_array((np.full(of_quads.size, 0.5), at), shape=(len(of_quads), len(edges)))
    shares = [sparse.csr_array((n, len(edges))), sparse.eye_array(len(edges)), middles]
    of_edges = sparse.coo_array(sparse.vstack(shares))
    turned = of_edges.data[:, None, None, None] * bent[of_edges.col]
    row = DOFS_PER_NODE * of_edges.row[:, None, None, None] + np.arange(3)[:, None]
    column = DOFS_PER_NODE * edges[of_edges.col][:, :, None, None] + 3 + np.arange(3)
    places = tuple(np.broadcast_to(part, turned.shape).ravel() for part in (row, column))
    shape = (DOFS_PER_NODE * between.shape[0], DOFS_PER_NODE * n)
    straight = sparse.kron(between, sparse.eye_array(DOFS_PER_NODE), "csr")
    return sparse.csr_array(straight + sparse.coo_array((turned.ravel(), places), shape=shape))


def _quarters(corners: IntArray, sides: IntArray, middle: IntArray) -> IntArray:
    a, b, c, d = corners.T
    ab, bc, cd, da = sides.T
    m = middle
    own = [[a, ab, m, da], [ab, b, bc, m], [m, bc, c, cd], [da, m, cd, d]]
    return np.moveaxis(np.array(own), 2, 0).reshape(-1, 4)


def _quarters_of_trias(corners: IntArray, sides: IntArray) -> IntArray:
    a, b, c = corners.T
    ab, bc, ca = sides.T
    return np.moveaxis(np.array([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]), 2, 0).reshape(-1, 3)


def _places(mesh: Mesh, edges: IntArray, of_quads: IntArray, of_trias: IntArray) -> FloatArray:
    """Return the places of all nodes (n_fine_nodes, 3)."""
    nodes, n = mesh.nodes, len(mesh.nodes)
    normals = corner_normals(mesh)
    matrix, right = np.zeros((len(edges), 3, 3)), np.zeros((len(edges), 3))
    for corners, sides, own in zip((mesh.quads, mesh.trias), (of_quads, of_trias), normals, strict=True):
        along = np.roll(nodes[corners], -1, axis=1) - nodes[corners]
        first, last = own, np.roll(own, -1, axis=1)
        rise = [normal * np.sum(normal * along, axis=2, keepdims=True) / 8.0 for normal in (first, last)]
        offset = rise[1] - rise[0]
        mean = first + last
        mean /= np.maximum(np.linalg.norm(mean, axis=2, keepdims=True), 1e-300)
        np.add.at(matrix, sides - n, mean[..., :, None] * mean[..., None, :])
        np.add.at(right, sides - n, mean * np.sum(mean * offset, axis=2, keepdims=True))
    moved = (np.linalg.pinv(matrix, rcond=0.1, hermitian=True) @ right[:, :, None])[:, :, 0]
    middles = nodes[edges].mean(axis=1) + moved
    centres = 0.5 * middles[of_quads - n].sum(axis=1) - 0.25 * nodes[mesh.quads].sum(axis=1)
    return np.concatenate([nodes, middles, centres])
