"""Linear buckling of a supported structure: (K + factor K_sigma) phi = 0, the load times `factor` being critical.

K_sigma = sum over the integration points of area N_ab u,a . u,b holds what the membrane forces N of the given load do
along all three displacements; the work of the moments on curvatures is left out. In warm shells N is that of the
strains less the free thermal ones, and the factor is one on load and warmth together. Displacements before buckling
count as small. Each factor is compared with that on a finer mesh (`refined`); where that would be too large its error
is the share of the mode's energy that is the mesh's (`quality`).

Sources: K.-J. Bathe, Finite Element Procedures (1996), section 6.8.2 (linearised buckling); eigenvalues by ARPACK
(Lehoucq, Sorensen, Yang 1998) with K as the inner product.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from femlib.arrays import FloatArray
from femlib.assembly.factors import factorise
from femlib.assembly.integration import PointStrains, point_strains
from femlib.assembly.loads import hindered_forces, thermal_load
from femlib.assembly.quality import MOST_ERROR, refuse_error, solution_quality
from femlib.assembly.refined import Refined
from femlib.assembly.shells import Shells, assemble
from femlib.assembly.supports import Supports
from femlib.elements import quad4, tria3
from femlib.elements.surface import GAUSS
from femlib.errors import InputError, SolveError, frozen_floats, is_whole
from femlib.mesh import DOFS_PER_NODE

TOLERANCE = 1e-9
"""Accuracy of 1 / factor over its largest magnitude."""
LEAST = 1e-6
"""Least 1 / factor over its largest magnitude, tension's included, that counts as buckling."""


@dataclass(frozen=True, slots=True, eq=False)
class BucklingMode:
    """A way to buckle.

    Attributes
    ----------
    factor : float
        Factor on the given load at which the structure buckles so, above 0.
    shape : FloatArray
        Displacements (n_dofs,), the largest translation 1.
    error : float
        Estimated relative error of the factor by the mesh; NaN if it was found of matrices alone.
    """

    factor: float
    shape: FloatArray
    error: float = float("nan")


def geometric_stiffness(
    shells: Shells, displacements: FloatArray, factor: FloatArray | None = None, warmth: FloatArray | None = None
) -> sparse.csc_array:
    """Return K_sigma (n_dofs, n_dofs) [N/m] of shells that a load displaces by (n_dofs,) [m, rad].

    `factor` (n_elements,) scales each element's stiffness, for damage; `warmth` as for `buckling_modes`.

    Raises
    ------
    InputError
        If a number of entries is wrong or one is not finite, or there are beams or springs: what their forces do is not
        known here.
    """
    mesh = shells.mesh
    if shells.n_elements != mesh.n_elements:
        raise InputError(
            f"the structure has {shells.n_elements - mesh.n_elements} beams and springs; expected shells alone, whose "
            "forces buckle them; make the beams of shells"
        )
    return _of_shells(shells, displacements, factor, warmth)


def is_buckled(
    shells: Shells,
    supports: Supports,
    displacements: FloatArray,
    factor: FloatArray | None = None,
    warmth: FloatArray | None = None,
) -> bool:
    """Return whether the load that displaces shells by (n_dofs,) is beyond their buckling load.

    K + K_sigma is then not positive definite: its factors have a negative pivot. What the forces of beams do is left
    out. `factor` (n_parts,) scales each part's stiffness; `warmth` as for `buckling_modes`.
    """
    own = None if factor is None else factor[: shells.mesh.n_elements]
    stiffness = supports.reduce(shells.stiffness(factor=factor) + _of_shells(shells, displacements, own, warmth))
    try:
        factors = factorise(sparse.csc_array(stiffness), supports.groups, definite=False)
    except SolveError:  # singular: at the buckling load
        return True
    return factors.has_negative_pivot()


def _of_shells(
    shells: Shells, displacements: FloatArray, factor: FloatArray | None, warmth: FloatArray | None
) -> sparse.csc_array:
    """Return K_sigma (n_dofs, n_dofs) of the shells."""
    mesh, n_quads = shells.mesh, len(shells.mesh.quads)
    moved = frozen_floats(displacements, "displacements", (mesh.n_dofs,)).reshape(-1, DOFS_PER_NODE)
    scale = np.ones(mesh.n_elements) if factor is None else frozen_floats(factor, "factor", (mesh.n_elements,))
    warm = np.zeros((mesh.n_elements, 2)) if warmth is None else warmth
    hindered, matrices = hindered_forces(shells, warm, scale)[:, None], []
    for kind, part in zip(point_strains(shells, moved, scale), (slice(n_quads), slice(n_quads, None)), strict=True):
        pulled = np.einsum("emab,embij->emaij", kind.point_forces(hindered[part]), rows := slope_rows(shells, kind))
        matrices.append(np.einsum("emaik,email->ekl", rows, pulled, optimize=True))
    return assemble(mesh, *matrices)


def slope_rows(shells: Shells, kind: PointStrains) -> FloatArray:
    """Return the rows (e, m, 2, 3, 6 n) of the displacements' slopes along the axes at the points."""
    if kind.corners.shape[1] == quad4.N_NODES:
        return quad4.slope_rows(kind.points, [(r, s) for r, s in GAUSS.tolist()], shells.axis)
    return tria3.slope_rows(kind.points, kind.axes[:, 0])


def buckling_modes(
    shells: Shells,
    supports: Supports,
    load: FloatArray,
    n_modes: int = 1,
    factor: FloatArray | None = None,
    limit: float = MOST_ERROR,
    is_refined: bool = True,
    warmth: FloatArray | None = None,
) -> list[BucklingMode]:
    """Return the modes of least positive factor on a load (n_dofs,), least first, each with an estimate of its error.

    There may be fewer than `n_modes`: a structure that the load only pulls does not buckle. `factor` (n_elements,)
    scales each element's stiffness, for damage. With `is_refined` they are compared with a finer mesh where it is small
    enough. `warmth` (n_elements, 2) is the temperature of each shell's middle and its rise toward the top [K, K/m].

    Raises
    ------
    InputError
        If the number of modes is none that the structure has, the load is not finite, or there are beams or springs.
    SolveError
        If the structure can move freely, the iteration does not converge, or an error is estimated beyond `limit`.
    """
    force = frozen_floats(load, "load", (supports.n_dofs,))
    modes = _loaded_modes(shells, supports, force, n_modes, factor, warmth)
    finer = Refined.finest(shells, supports) if is_refined else None
    if finer is None:
        errors = [solution_quality(shells, mode.shape, factor).displacement_error for mode in modes]
    else:
        parts = (finer.factor(factor), finer.factor(warmth))
        fine = _loaded_modes(finer.shells, finer.supports, finer.load(force), n_modes, *parts)
        missing = [np.inf] * (len(modes) - len(fine))
        pairs = zip(modes, fine, strict=False)
        errors = [finer.share * abs(own.factor / other.factor - 1.0) for own, other in pairs] + missing
    refuse_error(max(errors, default=0.0), "buckling loads", limit)
    return [replace(mode, error=error) for mode, error in zip(modes, errors, strict=True)]


def _loaded_modes(
    shells: Shells,
    supports: Supports,
    load: FloatArray,
    n_modes: int,
    factor: FloatArray | None,
    warmth: FloatArray | None,
) -> list[BucklingMode]:
    stiffness = shells.stiffness(factor=factor)
    if warmth is not None:
        kept = warmth if factor is None else warmth * factor[:, None]
        load = load + thermal_load(shells, kept[:, 0], kept[:, 1])
    moved = supports.expand(factorise(supports.reduce(stiffness), supports.groups).solve(load[supports.free]))
    return matrix_buckling(stiffness, geometric_stiffness(shells, moved, factor, warmth), supports, n_modes)


def matrix_buckling(
    stiffness: sparse.csc_array, geometric: sparse.csc_array, supports: Supports, n_modes: int = 1
) -> list[BucklingMode]:
    """Return the modes of least positive factor, least first, of matrices (n_dofs, n_dofs), not judged.

    There may be fewer than `n_modes`: a structure that the load only pulls does not buckle.

    Raises
    ------
    InputError
        If the number of modes is none that the structure has.
    SolveError
        If the structure can move freely or the iteration does not converge.
    """
    if not is_whole(n_modes) or not 1 <= n_modes < len(supports.free) - 1:
        raise InputError(f"n_modes is {n_modes!r}; expected 1 to {len(supports.free) - 2}; correct it")
    held, pressed = supports.reduce(stiffness), supports.reduce(geometric)
    if not np.abs(pressed.data).max(initial=0.0) > 0.0:
        return []
    factors = factorise(held, supports.groups)
    inverse = LinearOperator(held.shape, matvec=factors.solve, dtype=np.float64)
    # a fixed start vector makes the result the same in every run
    start = np.cos(np.arange(held.shape[0], dtype=np.float64))
    try:
        most = float(eigsh(pressed, 1, M=held, Minv=inverse, v0=start, tol=0.1, return_eigenvectors=False)[0])
        if most > 0.0 and _only_pulls(held, sparse.csc_array(pressed / (LEAST * most)), supports):
            return []  # the iteration below would seek modes among the many motions of 1 / factor 0
        most = abs(most)
        # moved away from 0, where the many motions that the load does no work on would never converge
        moved = sparse.csc_array(most * held - pressed)
        found, shapes = eigsh(moved, n_modes, M=held, Minv=inverse, which="LA", v0=start, tol=TOLERANCE)
    except ArpackError as error:
        raise SolveError(f"{n_modes} buckling modes did not converge ({error}); ask for fewer") from error
    inverses = found - most
    order = [k for k in np.argsort(-inverses) if inverses[k] > LEAST * most]
    return [BucklingMode(float(1.0 / inverses[k]), _scaled(supports.expand(shapes[:, k]))) for k in order]


def _only_pulls(held: sparse.csc_array, pressed: sparse.csc_array, supports: Supports) -> bool:
    """Return whether K + K_sigma is positive definite: nothing buckles up to that load."""
    try:
        factors = factorise(sparse.csc_array(held + pressed), supports.groups, definite=False)
    except SolveError:
        return False
    return not factors.has_negative_pivot()


def _scaled(shape: FloatArray) -> FloatArray:
    """Return a shape (n_dofs,) whose largest translation is 1."""
    moved = shape.reshape(-1, DOFS_PER_NODE)[:, :3]
    return np.asarray(shape / moved.ravel()[np.abs(moved).argmax()])
