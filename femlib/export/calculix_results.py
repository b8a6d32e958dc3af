"""What CalculiX found: displacements from its .frd file; strains, frequencies, buckling factors from its .dat file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from femlib.checked import fortran_number, shown
from femlib.errors import InputError
from femlib.export.calculix import BELOW, SCALED
from femlib.files import read_bytes
from femlib.mesh import Mesh
from femlib.sensors import StrainGauge, element_weights

START, WIDTH = 13, 12
"""Columns of a row of displacements: 3 of a mark, 10 of the node, then numbers 12 wide."""
APART = 0.25
"""Share by which the lowest buckling factor may differ from femlib's own: a coarse mesh may, another mode does more."""
LAYERS = {8: (4, np.sqrt(1.0 / 3.0)), 9: (3, np.sqrt(0.6))}
"""By the number of integration points, 8 of S8R and 9 of S6: points a layer, the lowest first, and the height of the
outer layers over half the thickness."""
LARGEST = 1e3
"""Strain that is believed, at most."""
MOST_DIGITS = 9
"""Digits of an element's number."""


def read_displacements(path: str | Path, n_nodes: int) -> FloatArray:
    """Return the translations (n_nodes, 3) [m] of the first nodes in the last increment of a result (.frd).

    Raises
    ------
    InputError
        If the file is missing or lacks a node.
    """
    text = read_bytes(Path(path), "CalculiX's .frd file; run the deck").decode("ascii", errors="replace")
    found = np.full((n_nodes, 3), np.nan)
    is_in = False
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith(" -4"):
            is_in = line.split()[1:2] == ["DISP"]
            if is_in:
                found[:] = np.nan
        elif is_in and line.startswith(" -1"):
            _read_row(line, found, f"{path}, line {number}")
        elif line.startswith(" -3"):
            is_in = False
    missing = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if missing.size:
        raise InputError(
            f"{path} has no displacement of node {missing[0] + 1}; expected {n_nodes} nodes; run the deck again"
        )
    return found


def _read_row(line: str, found: FloatArray, where: str) -> None:
    try:
        node = int(line[3:START]) - 1
        values = [fortran_number(line[START + WIDTH * k : START + WIDTH * (k + 1)]) for k in range(3)]
    except ValueError as error:
        raise InputError(f"{where}: {line.strip()[:60]!r} is no row of displacements; run the deck again") from error
    if 0 <= node < len(found):
        found[node] = values


def element_points(path: str | Path) -> dict[int, list[list[float]]]:
    """Return the strains (xx, yy, zz, xy, xz, yz) at the points of each printed element, in the last increment (.dat).

    Raises
    ------
    InputError
        If the file is missing, or a strain is none.
    """
    text = read_bytes(Path(path), "CalculiX's .dat file; run the deck").decode("ascii", errors="replace")
    found: dict[int, list[list[float]]] = {}  # of another file nothing is found
    for number, line in enumerate(text.splitlines(), start=1):
        if line.lstrip().startswith("strains"):
            found.clear()  # a new increment: the last one counts
        words = line.split()
        if len(words) >= 8 and words[0].isdigit() and words[1].isdigit() and len(words[0]) <= MOST_DIGITS:
            try:
                found.setdefault(int(words[0]) - 1, []).append([_strain(word) for word in words[2:8]])
            except ValueError as error:
                raise InputError(f"{path}, line {number}: {error}; expected six strains; run the deck again") from error
    return found


def gauge_strains(path: str | Path, mesh: Mesh, gauges: Sequence[StrainGauge]) -> FloatArray:
    """Return the strains (n_gauges,) of gauges on isotropic shells, tension positive, in the last increment (.dat).

    Raises
    ------
    InputError
        If the file is missing or lacks an element that a gauge reads.
    """
    points, strains = element_points(path), []
    for gauge, weights in zip(gauges, element_weights(mesh, gauges), strict=True):
        total = 0.0
        for element, weight in weights.items():
            n_points = 8 if element < len(mesh.quads) else 9
            if len(points.get(element, ())) != n_points:
                raise InputError(
                    f"{path} has {len(points.get(element, ()))} strains of element {element + 1}, which gauge "
                    f"{gauge.name} reads; expected {n_points}; run the deck of these gauges"
                )
            normal = mesh.area_vectors()[element]
            along = gauge.direction - normal * (gauge.direction @ normal) / (normal @ normal)
            along = along / np.linalg.norm(along)
            values = np.einsum("i,pij,j->p", along, _tensors(np.array(points[element])), along)
            n_layer, height = LAYERS[n_points]
            low, high = values[:n_layer].mean(), values[-n_layer:].mean()
            total += weight * float((low + high) / 2.0 + gauge.side / height * (high - low) / 2.0)
        strains.append(total)
    return np.array(strains)


def _tensors(rows: FloatArray) -> FloatArray:
    """Return strains (n, 3, 3) of rows (xx, yy, zz, xy, xz, yz)."""
    xx, yy, zz, xy, xz, yz = rows.T
    return np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), 2, 0)


def _strain(word: str) -> float:
    strain = fortran_number(word)
    if not abs(strain) <= LARGEST:
        raise ValueError(f"{shown(word)} is no strain")
    return strain


def read_frequencies(path: str | Path) -> FloatArray:
    """Return the natural frequencies [Hz] of a result (.dat), lowest first.

    Raises
    ------
    InputError
        If the file is missing or has none.
    """
    # columns: mode, eigenvalue, omega [rad/s], frequency [Hz], imaginary part
    return _column(path, "E I G E N V A L U E   O U T P U T", 5, 3)


def read_buckling_factors(path: str | Path, limit: float = APART) -> FloatArray:
    """Return the factors on the load at which the structure buckles, in the order of a result (.dat).

    They are those of the load that was given to the deck, which lies beside the result and says by what it was scaled.

    Raises
    ------
    InputError
        If the file is missing or has none, the deck (.inp) is not beside it, or the lowest factor differs from
        femlib's own by more than the share `limit`: then one of the two has missed the lowest mode.
    """
    found = _column(path, "B U C K L I N G   F A C T O R   O U T P U T", 2, 1)
    deck = read_bytes(Path(path).with_suffix(".inp"), f"the deck of {path}, which says how its load was scaled")
    scale = deck.decode("ascii", errors="replace").partition(SCALED)[2].split()[:1]
    if not scale:  # a deck of another program, with the load as it is
        return found
    factors, own = found * fortran_number(scale[0]), fortran_number(scale[0]) / BELOW
    if not abs(factors.min() - own) <= limit * own:
        raise InputError(
            f"{path} has {factors.min():.4g} as the lowest buckling factor, femlib {own:.4g}; expected them within "
            f"{100 * limit:g} %; refine the mesh, or look at the modes' shapes and give a wider limit"
        )
    return factors


def _column(path: str | Path, title: str, width: int, column: int) -> FloatArray:
    """Return one column of the table under a title."""
    text = read_bytes(Path(path), "CalculiX's .dat file; run the deck").decode("ascii", errors="replace")
    table = text.partition(title)[2].partition("P A R T I C I P A T I O N")[0]
    rows = [line.split() for line in table.splitlines()]
    try:
        values = [fortran_number(row[column]) for row in rows if len(row) == width and row[0].isdigit()]
    except ValueError as error:
        raise InputError(
            f"{path} has a number that is none ({error}); expected CalculiX's; run the deck again"
        ) from error
    if not values or not np.isfinite(values).all():
        raise InputError(f"{path} has no table {title!r} of finite numbers; expected one; run the deck")
    return np.array(values)
