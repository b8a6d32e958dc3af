"""From elements to the system K u = f: assembly, supports, factors and consistent loads."""

from femlib.assembly.buckling import BucklingMode, buckling_modes
from femlib.assembly.deflection import Deflection, deflect
from femlib.assembly.factors import factored_by, factorise
from femlib.assembly.loads import line_load, surface_load, thermal_load
from femlib.assembly.modes import Mode, natural_modes, point_masses
from femlib.assembly.quality import MOST_ERROR, Judge, Quality, solution_quality
from femlib.assembly.shells import Shells
from femlib.assembly.stresses import Stresses, ply_stresses
from femlib.assembly.supports import Supports

__all__ = [
    "MOST_ERROR",
    "BucklingMode",
    "Deflection",
    "Judge",
    "Mode",
    "Quality",
    "Shells",
    "Stresses",
    "Supports",
    "buckling_modes",
    "deflect",
    "factored_by",
    "factorise",
    "line_load",
    "natural_modes",
    "ply_stresses",
    "point_masses",
    "solution_quality",
    "surface_load",
    "thermal_load",
]
