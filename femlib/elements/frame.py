"""Parts of both elements: the laminates' moduli, and strain rows in global axes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.material import Laminate

AT_ONCE = 4096
"""Elements whose rows are held in memory together: 40 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class StrainOperator:
    """Linear map from an element's global displacements to its strains at one point.

    Attributes
    ----------
    membrane, curvature : FloatArray
        Rows (3, n_dofs) of (xx, yy, xy) in the element's axes [-] and [1/m]; at height z strain = membrane + z
        curvature.
    axes : FloatArray
        Columns are the element's x, y and normal in global axes (3, 3).
    """

    membrane: FloatArray
    curvature: FloatArray
    axes: FloatArray


def batches(n: int) -> Iterator[slice]:
    """Return slices that go over n elements, `AT_ONCE` at a time."""
    return (slice(first, min(first + AT_ONCE, n)) for first in range(0, n, AT_ONCE))


def moduli(laminates: Sequence[Laminate]) -> tuple[FloatArray, FloatArray]:
    """Return [[A, B], [B, D]] (m, 6, 6) and the shear stiffness (m, 2, 2) of (xz, yz)."""
    held = [np.block([[own.membrane, own.coupling], [own.coupling, own.bending]]) for own in laminates]
    return np.array(held).reshape(-1, 6, 6), np.array([own.shear[::-1, ::-1] for own in laminates]).reshape(-1, 2, 2)
