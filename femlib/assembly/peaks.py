"""What the largest strains of a solution are worth: plies fail by the peak, and a mean error says nothing of it.

The largest strain at both faces of each part is compared with that of the same state on the finer mesh (`Judge`), over
the largest of all. Where it grows as fast with every cut the point is singular: a corner of a damage region, a clamped
corner, a point load. No mesh gives a strain there; a mean over a length has a limit.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.quality import Judge, refuse_error
from femlib.assembly.refined import Refined
from femlib.assembly.shells import Shells
from femlib.assembly.stresses import corner_elements, corner_strains
from femlib.errors import SolveError

GROWS = 0.9
"""Ratio of the growths by two cuts beyond which strains have no limit: 0.25 where they converge by the second order,
0.5 by the first, 1 and more at a singular point."""


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """A solution that is asked for its plies.

    Attributes
    ----------
    shells : Shells
        The structure.
    moved : FloatArray
        Displacements (n_dofs,).
    load : FloatArray
        Nodal forces (n_dofs,), without those of warmth.
    factor : FloatArray
        Factor on each part's stiffness (n_parts,).
    length : float
        Length that strains are means over [m].
    warmth : FloatArray, optional
        As for `ply_stresses`; errors are over the free strain where that is larger.
    """

    shells: Shells
    moved: FloatArray
    load: FloatArray
    factor: FloatArray
    length: float = 0.0
    warmth: FloatArray | None = None


def checked_peak(judge: Judge, solved: Solved, limit: float) -> float:
    """Return the estimated error of the largest strains; without a finer mesh the root of the energy's.

    Raises
    ------
    SolveError
        If it exceeds `limit`; the sentence says where, and whether the strains have a limit there.
    """
    finer = judge.finer
    if finer is None:
        error = float(np.sqrt(judge.quality(solved.load, solved.moved, None, solved.factor).mesh.sum()))
        refuse_error(error, "strains of the plies", limit)
        return error
    fine = judge.finer_solution(solved.load, solved.factor, solved.warmth)
    if fine is None:
        return 0.0
    coarse, own = _peaks(solved.shells, solved.moved, solved.length), _peaks(finer.shells, fine, solved.length)
    away = np.abs(own - coarse)
    part = int(away.argmax())
    error = finer.share * float(away[part]) / max(float(own.max()), _free(solved))
    if error <= limit:
        return error
    sizes = _sizes(finer.shells, fine, solved.length)
    sizes[finer.shells.smooth[corner_elements(finer.shells)] != part] = 0.0
    node = finer.shells.mesh.nodes[_nodes(finer.shells)[int(sizes.argmax())]]
    place = f"({', '.join(f'{x:.3g}' for x in node)}) m"
    if finer.cuts == 2:
        once, between = judge.solution_on(
            Refined.of(solved.shells, judge.supports), solved.load, solved.factor, solved.warmth
        )
        middle = _peaks(once.shells, between, solved.length)[part]
        if middle > coarse[part] and own[part] - middle > GROWS * (middle - coarse[part]):
            raise SolveError(
                f"strains of the plies do not converge at {place}: {coarse[part]:.3g}, {middle:.3g} and "
                f"{own[part]:.3g} as the mesh is halved twice; expected a growth that falls to a quarter; in a corner "
                "or under a point load, where strains have no limit, give the length over which the material fails "
                "(length=3.8e-3 m for carbon laminates, Whitney and Nuismer 1974), elsewhere refine"
            )
    refuse_error(error, "strains of the plies", limit, f" (most at {place})")
    return error


def _peaks(shells: Shells, moved: FloatArray, length: float) -> FloatArray:
    """Return the largest strain of each part (n_smooth,)."""
    found = np.zeros(shells.n_smooth)
    np.maximum.at(found, shells.smooth[corner_elements(shells)], _sizes(shells, moved, length))
    return found


def _sizes(shells: Shells, moved: FloatArray, length: float) -> FloatArray:
    """Return the larger norm of the strains at both faces (n_corners,)."""
    strains, section = corner_strains(shells, moved, length), shells.section[corner_elements(shells)]
    half = 0.5 * np.array([own.thickness for own in shells.laminates])[section, None]
    faces = np.stack([strains[:, :3] - half * strains[:, 3:], strains[:, :3] + half * strains[:, 3:]])
    return np.asarray(np.sqrt((faces**2 @ [1.0, 1.0, 0.5]).max(axis=0)))


def _free(solved: Solved) -> float:
    """Return the largest strain of free expansion."""
    if solved.warmth is None:
        return 0.0
    most = np.array([max(max(abs(p.expansion_1), abs(p.expansion_2)) for p in s.plies) for s in solved.shells.laminates])
    half = np.array([0.5 * own.thickness for own in solved.shells.laminates])[solved.shells.section]
    rise = np.abs(solved.warmth[:, 0]) + half * np.abs(solved.warmth[:, 1])
    return float((most[solved.shells.section] * rise).max())


def _nodes(shells: Shells) -> IntArray:
    return np.concatenate([shells.mesh.quads.ravel(), shells.mesh.trias.ravel()])
