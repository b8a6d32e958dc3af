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
from functools import partial

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly.factors import Factors, factorise
from femlib.assembly.integration import point_strains
from femlib.assembly.loads import thermal_load
from femlib.assembly.recovery import nodal_tensors
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
    shells : Shells
        The structure.
    finer : Refined, optional
        The structure on the finer mesh; None where that would be too large.
    """

    def __init__(self, shells: Shells, supports: Supports) -> None:
        self.shells, self._supports = shells, supports
        self._made: Kept[str, Refined | None] = Kept()
        self._factors: Kept[str, Factors] = Kept()
        self._errors: Kept[str, float] = Kept()
        self._last: tuple[str, FloatArray] = ("", np.zeros(0))

    @property
    def finer(self) -> Refined | None:
        """The structure on the finer mesh, made when it is first asked for."""
        return self._made.get("", lambda: Refined.finest(self.shells, self._supports))

    def quality(
        self,
        load: FloatArray,
        moved: FloatArray,
        pristine: FloatArray | None,
        factor: FloatArray | None,
        warmth: FloatArray | None = None,
    ) -> Quality:
        """Return what displacements (n_dofs,) under a load (n_dofs,) are worth.

        `pristine` (n_dofs,) are those of the undamaged structure, if it shall be compared with that on the finer mesh;
        `factor` (n_parts,) is on each part's stiffness. With `warmth` (n_shells, 2), as for `thermal_load`, errors are
        over the free expansion where that is larger, and it is this state that is compared.
        """
        if warmth is not None:
            return self._of_warm(load, moved, factor, warmth)
        if not np.any(load):
            return Quality(np.zeros(self.shells.mesh.n_elements))
        estimated = solution_quality(self.shells, moved, factor)
        if pristine is None:
            return estimated
        return Quality(estimated.mesh, self._errors.get(_name(load), lambda: self._distance(load, pristine)))

    def _of_warm(self, load: FloatArray, moved: FloatArray, factor: FloatArray | None, warmth: FloatArray) -> Quality:
        shells = self.shells
        held, growth = held_back(shells, warmth, np.ones(shells.n_elements) if factor is None else factor)
        if not held and not np.any(load):
            return Quality(np.zeros(shells.mesh.n_elements))
        estimated = solution_quality(shells, moved, factor, held)
        fine, finer = self.finer_solution(load, factor, warmth), self.finer
        if fine is None or finer is None:
            return estimated
        places = [whole[: len(moved)].reshape(-1, DOFS_PER_NODE)[:, :3] for whole in (moved, fine)]
        least = growth * shells.mesh.size * np.sqrt(len(places[0]))
        return Quality(estimated.mesh, relative_distance(places[0], places[1], finer.share, least))

    def finer_solution(
        self, load: FloatArray, factor: FloatArray | None = None, warmth: FloatArray | None = None
    ) -> FloatArray | None:
        """Return the displacements (n_fine_dofs,) on the finer mesh; None without one, or without load and warmth."""
        finer = self.finer
        if finer is None or not (np.any(load) or np.any(warmth)):
            return None
        size = _largest(load) if np.any(load) and warmth is None else 1.0
        parts = [np.round(load / size, 12) + 0.0, factor, warmth]
        name = hashlib.sha256(b"-".join(b"" if part is None else part.tobytes() for part in parts)).hexdigest()
        if self._last[0] != name:
            self._last = name, self.solution_on(finer, load / size, factor, warmth)
        return np.asarray(size * self._last[1])

    def cut_once(self) -> Refined:
        """Return the structure with every element cut once."""
        return Refined.of(self.shells, self._supports)

    def solution_on(
        self, finer: Refined, load: FloatArray, factor: FloatArray | None, warmth: FloatArray | None
    ) -> FloatArray:
        """Return the displacements (n_fine_dofs,) on a finer mesh."""
        held, shells, left = finer.supports, finer.shells, finer.factor(factor)
        force = finer.load(load) if np.any(load) else np.zeros(shells.mesh.n_dofs)
        if warmth is not None:
            n = shells.mesh.n_elements
            kept = warmth[finer.parent[:n]] * (1.0 if left is None else left[:n, None])
            force = force + thermal_load(shells, kept[:, 0], kept[:, 1])
        is_kept = finer is self.finer and (factor is None or bool(np.all(factor == 1.0)))
        made = partial(_factors, shells, held, left)
        return held.expand((self._factors.get("", made) if is_kept else made()).solve(force[held.free]))

    def _distance(self, load: FloatArray, pristine: FloatArray) -> float:
        found, finer = self.finer_solution(load), self.finer
        if found is None or finer is None:
            return 0.0
        fine = found[: len(pristine)].reshape(-1, DOFS_PER_NODE)[:, :3]
        coarse = pristine.reshape(-1, DOFS_PER_NODE)[:, :3]
        return relative_distance(coarse, fine, finer.share)


def _factors(shells: Shells, supports: Supports, factor: FloatArray | None) -> Factors:
    return factorise(supports.reduce(shells.stiffness(factor=factor)), supports.groups)


def held_back(shells: Shells, warmth: FloatArray, factor: FloatArray) -> tuple[float, float]:
    """Return twice the energy [N m] that would hold all thermal strains back, and the largest strain of free expansion.

    `warmth` (n_shells, 2) as for `thermal_load`; `factor` (n_parts,) is on each part's stiffness.
    """
    area = np.linalg.norm(shells.mesh.area_vectors(), axis=1)
    left = shells.scale * factor[: shells.mesh.n_elements] * area
    energy, strain = np.zeros(len(area)), np.zeros(len(area))
    for number, own in enumerate(shells.laminates):
        on, stiff = shells.section == number, np.block([[own.membrane, own.coupling], [own.coupling, own.bending]])
        warm = np.array([[*own.thermal_force, *own.thermal_moment], [*own.gradient_force, *own.gradient_moment]])
        force = warmth[on] @ warm
        free = np.linalg.solve(stiff, force.T).T
        energy[on] = np.einsum("ec,ec->e", force, free)
        strain[on] = np.abs(np.concatenate([free[:, :3], 0.5 * own.thickness * free[:, 3:]], axis=1)).max(axis=1)
    return float(left @ energy), float(strain.max())


def relative_distance(coarse: FloatArray, fine: FloatArray, share: float, least: float = 0.0) -> float:
    """Return the error of numbers estimated from those of a finer mesh, over their size, both as roots of squares.

    The size is at least `least`.
    """
    size = max(float(np.linalg.norm(fine)), least)
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


def solution_quality(
    shells: Shells, displacements: FloatArray, factor: FloatArray | None = None, held: float = 0.0
) -> Quality:
    """Return the shares of a solution's strain energy that are the mesh's, without a finer mesh.

    Parameters
    ----------
    shells : Shells
        The structure.
    displacements : FloatArray
        Of all degrees of freedom (n_dofs,) under one load [m, rad].
    factor : FloatArray, optional
        Factor on each part's stiffness (n_parts,), for damage.
    held : float
        Energy besides that shares are of [N m]: of `held_back`.

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
    energy = sum(float(kind.energy(kind.whole).sum()) for kind in kinds) + shells.other_energy(moved, scale) + held
    if not energy > 0.0:
        raise SolveError("displacements have no strain energy; expected those of a loaded structure; load it")
    names, recovered = nodal_tensors(shells, kinds)
    shares = np.concatenate([k.distance(recovered[np.searchsorted(names, k.group)]) for k in kinds]) / energy
    shares[len(mesh.quads) :] *= TRIANGLE
    return Quality(shares)


def _largest(load: FloatArray) -> float:
    return float(load[int(np.abs(load).argmax())])


def _name(load: FloatArray) -> str:
    """Return a name of a load that all its multiples share: its error is theirs."""
    return hashlib.sha256((np.round(load / _largest(load), 12) + 0.0).tobytes()).hexdigest()
