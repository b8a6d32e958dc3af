"""What a solution is worth: an estimate of its error after it is solved, and a refusal.

Two estimates, the larger counts. The first is the distance from the same structure on a finer mesh (`refined`), made
where that has at most `MOST_UNKNOWNS`: with c cuts an error of second order is the difference times 1 / (1 - 4^-c).
The second costs no solution. In a Galerkin solution the error's energy over the whole is the error of load' u. It is
estimated by the energy of the distance from the strains to smoother ones: at each node a linear fit to the strains of
the adjoining elements of the same patch, between the nodes the elements' own shape functions.

Source: O. C. Zienkiewicz, J. Z. Zhu, Int. J. Numer. Meth. Engng 33 (1992) 1331-1364. Price: what the estimate is worth
is a table in docs/wing.md; alone, it does not see the twist of a strip one element wide.
"""

import hashlib
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, IntArray, judged
from femlib.assembly.factors import Factors, factorise
from femlib.assembly.integration import PointStrains, point_strains
from femlib.assembly.refined import Refined
from femlib.assembly.shells import Shells
from femlib.assembly.supports import Supports
from femlib.errors import InputError, SolveError, frozen_floats, is_number
from femlib.kept import Kept
from femlib.mesh import DOFS_PER_NODE

MOST_ERROR = 0.03
"""Estimated error beyond which a solution is refused."""
TRIANGLE = 2.0
"""Weight of a triangle's share: flat facets of a curved surface hide some of their error from its neighbours. Of random
curved panels of triangles (seed 1) the true error was up to 2.8 times the share without it."""


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """What is the mesh's of a solution and not the structure's.

    Attributes
    ----------
    mesh : FloatArray
        Shares of the whole strain energy by shell (n_shells,), a triangle's weighted by `TRIANGLE`.
    finer : float
        Relative distance from the undamaged structure's displacements on a finer mesh; 0 where none was made.
    """

    mesh: FloatArray
    finer: float = 0.0

    @property
    def displacement_error(self) -> float:
        """Estimated relative error of the displacements under the load."""
        return max(float(self.mesh.sum()), self.finer)

    def refuse(self, limit: float = MOST_ERROR) -> None:
        """Raise SolveError if the estimated error exceeds `limit`."""
        where = f" (most in element {int(self.mesh.argmax())})"
        refuse_error(self.displacement_error, "displacements", limit, where)


class Judge:
    """Solutions of one structure beside those on a finer mesh, each load solved there once.

    Attributes
    ----------
    finer : Refined, optional
        The structure on the finer mesh; None where that would be too large.
    """

    def __init__(self, shells: Shells, supports: Supports) -> None:
        self._shells, self._supports = shells, supports
        self._made: Kept[str, Refined | None] = Kept()
        self._factors: Kept[str, Factors] = Kept()
        self._errors: Kept[str, float] = Kept()
        self._last: tuple[str, FloatArray] = ("", np.zeros(0))

    @property
    def finer(self) -> Refined | None:
        """The structure on the finer mesh, made when it is first asked for."""
        return self._made.get("", lambda: Refined.finest(self._shells, self._supports))

    def quality(self, load: FloatArray, moved: FloatArray, pristine: FloatArray, factor: FloatArray | None) -> Quality:
        """Return what displacements (n_dofs,) under a load (n_dofs,) are worth.

        `pristine` (n_dofs,) are those of the undamaged structure; `factor` (n_parts,) is on each part's stiffness.
        """
        if not np.any(load):
            return Quality(np.zeros(self._shells.mesh.n_elements))
        estimated = solution_quality(self._shells, moved, factor)
        return Quality(estimated.mesh, self._errors.get(_name(load), lambda: self._distance(load, pristine)))

    def finer_solution(self, load: FloatArray) -> FloatArray | None:
        """Return the undamaged structure's displacements (n_fine_dofs,) on the finer mesh; None without one or load."""
        finer = self.finer
        if finer is None or not np.any(load):
            return None
        size, name = _largest(load), _name(load)
        if self._last[0] != name:
            held = finer.supports
            factors = self._factors.get("", lambda: factorise(held.reduce(finer.shells.stiffness()), held.groups))
            self._last = name, held.expand(factors.solve(finer.load(load / size)[held.free]))
        return np.asarray(size * self._last[1])

    def _distance(self, load: FloatArray, pristine: FloatArray) -> float:
        found, finer = self.finer_solution(load), self.finer
        if found is None or finer is None:
            return 0.0
        fine = found[: len(pristine)].reshape(-1, DOFS_PER_NODE)[:, :3]
        coarse = pristine.reshape(-1, DOFS_PER_NODE)[:, :3]
        return relative_distance(coarse, fine, finer.share)


def relative_distance(coarse: FloatArray, fine: FloatArray, share: float) -> float:
    """Return the error of numbers estimated from those of a finer mesh, over their size, both as roots of squares."""
    size = float(np.linalg.norm(fine))
    return share * float(np.linalg.norm(coarse - fine)) / size if size > 0.0 else 0.0


def refuse_error(error: float, what: str, limit: float, where: str = "") -> None:
    """Raise SolveError if an estimated error exceeds `limit`.

    Raises
    ------
    InputError
        If the limit is no share above 0.
    """
    if not is_number(limit) or limit <= 0.0:
        raise InputError(f"limit is {limit!r}; expected a share above 0; 0.03 is usual")
    if not error <= limit:
        raise SolveError(
            f"{what} are estimated to be {100.0 * error:.3g} % off by a coarse mesh{where}; expected "
            f"at most {100.0 * limit:.3g} %; refine where the strains change"
        )


def solution_quality(shells: Shells, displacements: FloatArray, factor: FloatArray | None = None) -> Quality:
    """Return the shares of a solution's strain energy that are the mesh's, without a finer mesh.

    Parameters
    ----------
    shells : Shells
        The structure.
    displacements : FloatArray
        Of all degrees of freedom (n_dofs,) under one load [m, rad].
    factor : FloatArray, optional
        Factor on each part's stiffness (n_parts,), for damage.

    Raises
    ------
    InputError
        If a number of entries is wrong or one is not finite.
    SolveError
        If the displacements have no strain energy.
    """
    mesh, n_parts = shells.mesh, shells.n_elements
    moved = frozen_floats(displacements, "displacements", (mesh.n_dofs,))
    scale = np.ones(n_parts) if factor is None else frozen_floats(factor, "factor", (n_parts,))
    of_shells = scale[: mesh.n_elements]
    kinds = [k for k in point_strains(shells, moved.reshape(-1, DOFS_PER_NODE), of_shells) if len(k.corners)]
    energy = sum(float(kind.energy(kind.whole).sum()) for kind in kinds) + shells.other_energy(moved, scale)
    if not energy > 0.0:
        raise SolveError("displacements have no strain energy; expected those of a loaded structure; load it")
    names, recovered = nodal_tensors(shells, kinds)
    shares = np.concatenate([k.distance(recovered[np.searchsorted(names, k.group)]) for k in kinds]) / energy
    shares[len(mesh.quads) :] *= TRIANGLE
    return Quality(shares)


def checked_solution(shells: Shells, supports: Supports, load: FloatArray, limit: float = MOST_ERROR) -> FloatArray:
    """Return the displacements (n_dofs,) under nodal forces (n_dofs,) [N, N m], judged by both estimates.

    Raises
    ------
    InputError
        If the load has another number of entries or one is not finite.
    SolveError
        If the structure is not held, or the displacements are estimated to be farther off than `limit`.
    """
    force = frozen_floats(load, "load", (supports.n_dofs,))
    factors = factorise(supports.reduce(shells.stiffness()), supports.groups)
    moved = supports.expand(factors.solve(force[supports.free]))
    quality = Judge(shells, supports).quality(force, moved, moved, None)
    quality.refuse(limit)
    return judged(moved, quality.displacement_error)


def _largest(load: FloatArray) -> float:
    return float(load[int(np.abs(load).argmax())])


def _name(load: FloatArray) -> str:
    """Return a name of a load that all its multiples share: its error is theirs."""
    return hashlib.sha256((np.round(load / _largest(load), 12) + 0.0).tobytes()).hexdigest()


def nodal_tensors(shells: Shells, kinds: list[PointStrains]) -> tuple[IntArray, FloatArray]:
    """Return names of nodes and parts (g,), as `PointStrains.group`, and the tensors (g, 18) there.

    Each is a linear fit to the points of its node's elements in its part.
    """
    mesh = shells.mesh
    names, group = np.unique(np.concatenate([kind.group.ravel() for kind in kinds]), return_inverse=True)
    node = mesh.nodes[names // shells.n_smooth]
    first = np.cumsum([0, *(kind.group.size for kind in kinds)])
    groups = [group.ravel()[a : a + k.group.size].reshape(k.group.shape) for a, k in zip(first, kinds, strict=False)]
    normal = np.zeros((len(names), 3))
    for kind, own in zip(kinds, groups, strict=True):
        np.add.at(normal, own, np.einsum("emi,em->ei", kind.axes[..., 2], kind.area)[:, None])
    tangents = _tangents(normal)
    matrix, right = np.zeros((len(names), 3, 3)), np.zeros((len(names), 3, 18))
    for kind, own in zip(kinds, groups, strict=True):
        values, places = kind.tensors(), kind.shapes @ kind.points
        size = np.sqrt(kind.area.sum(axis=1))
        for corner in own.T:
            offset = (places - node[corner][:, None]) / size[:, None, None]
            basis = np.concatenate([np.ones((*offset.shape[:2], 1)), offset @ tangents[corner]], axis=2)
            np.add.at(matrix, corner, basis.swapaxes(1, 2) @ basis)
            np.add.at(right, corner, basis.swapaxes(1, 2) @ values)
    return names, (np.linalg.pinv(matrix, rcond=1e-9, hermitian=True)[:, :1] @ right)[:, 0]


def _tangents(normals: FloatArray) -> FloatArray:
    """Return two directions across normals (n, 3) as columns (n, 3, 2); of any length but not parallel to it."""
    away = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, away)
    second = np.cross(normals, first)
    both = np.stack([first, second], axis=2)
    return np.asarray(both / np.maximum(np.linalg.norm(both, axis=1, keepdims=True), 1e-300))
