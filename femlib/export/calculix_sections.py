"""Materials, orientations and shell sections of a CalculiX deck."""

from collections.abc import Iterator

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Shells
from femlib.errors import InputError
from femlib.material import SAME, Laminate, Ply, laminate

TURNED = 6
"""Decimals of a direction by which orientations differ."""


def sections(shells: Shells, factor: FloatArray, warm: FloatArray) -> list[str]:
    """Return materials, orientations and sections, one for each laminate, factor and direction that occurs.

    Parameters
    ----------
    shells : Shells
        The shells; their own factor on the stiffness is not used.
    factor, warm : FloatArray
        Factors on the moduli and on the thermal expansion (n_elements,).

    Raises
    ------
    InputError
        If a laminate has no plies, or others than its stiffness.
    """
    for number in np.unique(shells.section).tolist():
        _check(shells.laminates[number], number)
    directed = ~np.array([_is_isotropic(own.plies) for own in shells.laminates])[shells.section]
    along = np.where(directed[:, None, None], np.round(_directions(shells), TURNED), 0.0).reshape(-1, 6)
    columns = np.column_stack([shells.section, np.round(factor, 9), warm, along + 0.0])
    kinds, member = np.unique(columns, axis=0, return_inverse=True)
    lines: list[str] = []
    for number, row in enumerate(kinds):
        elements = np.flatnonzero(member.ravel() == number)
        plies = shells.laminates[int(row[0])].plies
        lines += _section(number, elements, plies, row[1], row[2], row[3:].reshape(2, 3))
    return lines


def _section(
    number: int, elements: IntArray, plies: tuple[Ply, ...], factor: float, warm: float, along: FloatArray
) -> Iterator[str]:
    yield f"*ELSET, ELSET=E{number}"
    yield from (f"{element + 1}," for element in elements)
    for k, ply in enumerate(plies):
        yield from _material(f"M{number}" + (f"P{k}" if k else ""), ply, factor, warm)
        if along.any():
            yield from _orientation(f"O{number}P{k}", along, ply.angle)
    if len(plies) == 1:
        turned = f", ORIENTATION=O{number}P0" if along.any() else ""
        yield f"*SHELL SECTION, ELSET=E{number}, MATERIAL=M{number}{turned}"
        yield f"{plies[0].thickness}"
        return
    yield f"*SHELL SECTION, ELSET=E{number}, COMPOSITE"
    for k, ply in enumerate(plies):
        name = f"M{number}" + (f"P{k}" if k else "")
        yield f"{ply.thickness}, , {name}" + (f", O{number}P{k}" if along.any() else "")


def _material(name: str, ply: Ply, factor: float, warm: float) -> Iterator[str]:
    yield f"*MATERIAL, NAME={name}"
    if _is_isotropic((ply,)):
        yield "*ELASTIC"
        yield f"{ply.young_1 * factor:.9e}, {ply.poisson_12}"
    else:
        yield "*ELASTIC, TYPE=ENGINEERING CONSTANTS"
        first, second, nu = ply.young_1 * factor, ply.young_2 * factor, ply.poisson_12
        g_12, g_13, g_23 = (factor * g for g in (ply.shear_12, ply.shear_13, ply.shear_23))
        yield f"{first:.9e}, {second:.9e}, {second:.9e}, {nu}, {nu}, {nu}, {g_12:.9e}, {g_13:.9e},"
        yield f"{g_23:.9e}, 0."
    yield "*DENSITY"
    yield f"{ply.density}"
    if _is_isotropic((ply,)):
        yield "*EXPANSION, ZERO=0"
        yield f"{ply.expansion_1 * warm:.9e}"
    else:
        yield "*EXPANSION, TYPE=ORTHO, ZERO=0"
        yield f"{ply.expansion_1 * warm:.9e}, {ply.expansion_2 * warm:.9e}, {ply.expansion_2 * warm:.9e}"


def _orientation(name: str, along: FloatArray, angle: float) -> Iterator[str]:
    first = np.cos(angle) * along[0] + np.sin(angle) * along[1]
    second = -np.sin(angle) * along[0] + np.cos(angle) * along[1]
    yield f"*ORIENTATION, NAME={name}, SYSTEM=RECTANGULAR"
    yield ", ".join(f"{value:.9f}" for value in (*first, *second))


def _directions(shells: Shells) -> FloatArray:
    """Return the laminates' first and second axis in each element (n_elements, 2, 3), zero where there is none."""
    normal = shells.mesh.area_vectors()
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = shells.axis - normal * (normal @ shells.axis)[:, None]
    length = np.linalg.norm(first, axis=1, keepdims=True)
    first = np.where(length > 0.0, first / np.where(length > 0.0, length, 1.0), 0.0)
    return np.stack([first, np.cross(normal, first)], axis=1)


def _is_isotropic(plies: tuple[Ply, ...]) -> bool:
    return all(
        abs(ply.young_1 - ply.young_2) <= SAME * ply.young_1
        and abs(ply.expansion_1 - ply.expansion_2) <= SAME * abs(ply.expansion_1)
        and all(
            abs(2.0 * (1.0 + ply.poisson_12) * shear - ply.young_1) <= SAME * ply.young_1
            for shear in (ply.shear_12, ply.shear_13, ply.shear_23)
        )
        for ply in plies
    )


def _check(own: Laminate, number: int) -> None:
    if not own.plies:
        raise InputError(
            f"laminate {number} has no plies; expected them, as CalculiX asks for materials; make it with "
            "femlib.material.laminate"
        )
    again = laminate(own.plies)
    for name in ("membrane", "coupling", "bending", "shear"):
        size = float(np.abs(getattr(again, name)).max()) or float(np.abs(again.membrane).max()) * own.thickness
        if not np.allclose(getattr(own, name), getattr(again, name), rtol=0.0, atol=1e-6 * size):
            raise InputError(
                f"laminate {number} has another {name} stiffness than its plies; expected the same; make it with "
                "femlib.material.laminate, or give a factor on the elements"
            )
    for k, ply in enumerate(own.plies):
        if not _is_isotropic((ply,)) and not np.linalg.eigvalsh(_compliance(ply))[0] > 0.0:
            raise InputError(
                f"ply {k} of laminate {number} has no stable solid with nu_13 = nu_23 = nu_12 = {ply.poisson_12}; "
                "expected a smaller ratio; correct the ply"
            )


def _compliance(ply: Ply) -> FloatArray:
    """Return the compliance (3, 3) of normal stresses, times E_2."""
    cross, nu = -ply.poisson_12 * ply.young_2 / ply.young_1, ply.poisson_12
    return np.array([[ply.young_2 / ply.young_1, cross, cross], [cross, 1.0, -nu], [cross, -nu, 1.0]])
