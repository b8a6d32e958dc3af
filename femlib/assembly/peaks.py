"""What the largest strains of a solution are worth: plies fail by the peak, and a mean error says nothing of it.

The largest strain at both faces of each part is compared with that of the same state on the finer mesh (`Judge`), over
the largest of all. Where it grows as fast with every cut the point is singular: a corner of a damage region, a clamped
corner, a point load. No mesh gives a strain there; a mean over a length has a limit.
"""

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly.quality import Judge, held_back, refuse_error
from femlib.assembly.shells import Shells
from femlib.assembly.stresses import corner_elements, corner_strains
from femlib.errors import SolveError

MOST_PEAK_ERROR = 0.02
"""Estimated error of the largest strains beyond which they are refused."""
GROWS = 0.9
"""Ratio of the growths by two cuts beyond which strains have no limit: 0.25 where they converge by the second order,
0.5 by the first, 1 and more at a singular point."""


def checked_peak(
    judge: Judge,
    moved: FloatArray,
    load: FloatArray,
    factor: FloatArray,
    limit: float,
    length: float = 0.0,
    warmth: FloatArray | None = None,
) -> float:
    """Return the estimated error of the largest strains; without a finer mesh the root of the energy's.

    Arguments are those of `Judge.quality` and `ply_stresses`; errors are over the free expansion where that is larger.

    Raises
    ------
    SolveError
        If it exceeds `limit`; the sentence says where, and whether the strains converge there.
    """
    shells, finer = judge.shells, judge.finer
    fine = judge.finer_solution(load, factor, warmth)
    if finer is None or fine is None:
        error = float(np.sqrt(judge.quality(load, moved, None, factor, warmth).mesh.sum()))
        refuse_error(error, "strains of the plies", limit)
        return error
    coarse, own = _peaks(shells, moved, length), _peaks(finer.shells, fine, length)
    away = np.abs(own - coarse)
    part = int(away.argmax())
    free = 0.0 if warmth is None else held_back(shells, warmth, factor)[1]
    error = finer.share * float(away[part]) / max(float(own.max()), free)
    if error <= limit:
        return error
    mesh = finer.shells.mesh
    sizes = _sizes(finer.shells, fine, length)
    sizes[finer.shells.smooth[corner_elements(finer.shells)] != part] = 0.0
    node = mesh.nodes[np.concatenate([mesh.quads.ravel(), mesh.trias.ravel()])[int(sizes.argmax())]]
    place = f"({', '.join(f'{x:.3g}' for x in node)}) m"
    if finer.cuts == 2:
        once = judge.cut_once()
        middle = _peaks(once.shells, judge.solution_on(once, load, factor, warmth), length)[part]
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
