"""From elements to the system K u = f: assembly, supports, factors and consistent loads."""

from femlib.assembly.buckling import BucklingMode, buckling_modes, geometric_stiffness
from femlib.assembly.built_up import Beams, BuiltUp, Springs
from femlib.assembly.deflection import CorotatedShells, Deflection, deflect
from femlib.assembly.factors import Factors, factored_by, factorise
from femlib.assembly.loads import line_load, surface_load, thermal_forces, thermal_load
from femlib.assembly.modes import Mode, natural_modes, point_masses
from femlib.assembly.quality import Quality, checked_solution, solution_quality
from femlib.assembly.shells import Shells, assemble
from femlib.assembly.supports import Supports

__all__ = [
    "Beams",
    "BucklingMode",
    "BuiltUp",
    "CorotatedShells",
    "Deflection",
    "Factors",
    "Mode",
    "Quality",
    "Shells",
    "Springs",
    "Supports",
    "assemble",
    "buckling_modes",
    "checked_solution",
    "deflect",
    "factored_by",
    "factorise",
    "geometric_stiffness",
    "line_load",
    "natural_modes",
    "point_masses",
    "solution_quality",
    "surface_load",
    "thermal_forces",
    "thermal_load",
]
