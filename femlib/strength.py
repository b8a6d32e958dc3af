"""Strength of a ply, and the factor on a load at which it fails: strain is linear in the load, so there is a formula.

With strain e and stress s = Q e in fibre axes (1, 2, 12), tension positive, and strengths X, X' (along the fibres,
tension and compression), Y, Y' (across), S (shear):

    "max strain"   factor = least of X / (E_1 e_1), X' / (-E_1 e_1), Y / (E_2 e_2), Y' / (-E_2 e_2), S / (G_12 |e_12|)
    "tsai-wu"      a f^2 + b f = 1, a = F_11 s_1^2 + F_22 s_2^2 + F_66 s_12^2 + 2 F_12 s_1 s_2, b = F_1 s_1 + F_2 s_2
    "von mises"    factor = X / sqrt(s_1^2 - s_1 s_2 + s_2^2 + 3 s_12^2), of isotropic plies

with F_1 = 1 / X - 1 / X', F_11 = 1 / (X X'), likewise 2, F_66 = 1 / S^2 and F_12 = -sqrt(F_11 F_22) / 2.

Source: R. M. Jones, Mechanics of Composite Materials (1999), section 2.9 (all but von Mises).
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError, is_number

CRITERIA = ("max strain", "tsai-wu", "von mises")


@dataclass(frozen=True, slots=True)
class Strength:
    """Stresses [Pa] that a ply bears, one at a time; all above 0.

    Attributes
    ----------
    tension_1, compression_1 : float
        Along the fibres; the yield stress of an isotropic ply.
    tension_2, compression_2 : float
        Across them.
    shear_12 : float
        In-plane shear.

    Examples
    --------
    >>> carbon = Strength(tension_1=1500e6, compression_1=1200e6, tension_2=50e6, compression_2=200e6, shear_12=70e6)
    >>> tsai_wu_factors(carbon, np.array([[500e6, 10e6, 0.0]])).round(2).tolist()
    [2.71]
    """

    tension_1: float
    compression_1: float
    tension_2: float
    compression_2: float
    shear_12: float

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if not is_number(value) or value <= 0.0:
                raise InputError(
                    f"strength {name} is {value!r}; expected a positive number of Pa; give compression without its sign"
                )


def yielding_at(stress: float) -> Strength:
    """Return the strength of an isotropic metal that yields at a stress [Pa], in shear by von Mises.

    >>> round(float(yielding_at(250e6).shear_12) / 1e6, 1)
    144.3
    """
    if not is_number(stress):
        raise InputError(f"yield stress is {stress!r}; expected a positive number of Pa; correct it")
    return Strength(stress, stress, stress, stress, stress / np.sqrt(3.0))


def checked_criterion(criterion: str) -> str:
    """Return the name of a criterion; InputError if there is none of that name."""
    if criterion not in CRITERIA:
        raise InputError(f"criterion is {criterion!r}; expected one of {list(CRITERIA)}; correct it")
    return criterion


def strain_factors(strength: Strength, moduli: tuple[float, float, float], strain: FloatArray) -> FloatArray:
    """Return the factors (n,) of "max strain" on strains (n, 3) of a ply with moduli (E_1, E_2, G_12) [Pa]."""
    tension = np.array([strength.tension_1, strength.tension_2, strength.shear_12]) / moduli
    compression = np.array([strength.compression_1, strength.compression_2, strength.shear_12]) / moduli
    index = np.maximum(strain / tension, -strain / compression).max(axis=1)
    return np.asarray(1.0 / np.maximum(index, 1e-300))


def tsai_wu_factors(strength: Strength, stress: FloatArray) -> FloatArray:
    """Return the factors (n,) of "tsai-wu" on stresses (n, 3) [Pa]: the positive root."""
    along, across, shear = stress.T
    linear_1 = 1.0 / strength.tension_1 - 1.0 / strength.compression_1
    linear_2 = 1.0 / strength.tension_2 - 1.0 / strength.compression_2
    square_1 = 1.0 / (strength.tension_1 * strength.compression_1)
    square_2 = 1.0 / (strength.tension_2 * strength.compression_2)
    both = -np.sqrt(square_1 * square_2)  # 2 F_12
    a = square_1 * along**2 + square_2 * across**2 + (shear / strength.shear_12) ** 2 + both * along * across
    b = linear_1 * along + linear_2 * across
    return np.asarray(2.0 / np.maximum(b + np.sqrt(b * b + 4.0 * a), 1e-300))


def von_mises(stress: FloatArray) -> FloatArray:
    """Return von Mises' stress (...,) [Pa] of plane stresses (..., 3).

    >>> von_mises(np.array([100.0, 0.0, 50.0])).round(1).item()
    132.3
    """
    along, across, shear = np.moveaxis(stress, -1, 0)
    return np.asarray(np.sqrt(along**2 - along * across + across**2 + 3.0 * shear**2))
