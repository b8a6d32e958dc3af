"""From elements to the system K u = f: assembly, supports, factors and consistent loads."""

from femlib.assembly.buckling import BucklingMode, buckling_modes, geometric_stiffness, is_buckled, matrix_buckling
from femlib.assembly.built_up import Beams, BuiltUp, Springs
from femlib.assembly.deflection import CorotatedShells, Deflection, deflect
from femlib.assembly.factors import Factors, factored_by, factorise
from femlib.assembly.loads import edge_forces, line_load, surface_load, thermal_forces, thermal_load
from femlib.assembly.modes import Mode, matrix_modes, natural_modes, point_masses
from femlib.assembly.peaks import MOST_PEAK_ERROR, checked_peak
from femlib.assembly.quality import (
    MOST_ERROR,
    Judge,
    Quality,
    checked_solution,
    refuse_error,
    relative_distance,
    solution_quality,
)
from femlib.assembly.shells import Shells, assemble
from femlib.assembly.stresses import Stresses, ply_stresses
from femlib.assembly.supports import Supports

__all__ = [
    "MOST_ERROR",
    "MOST_PEAK_ERROR",
    "Beams",
    "BucklingMode",
    "BuiltUp",
    "CorotatedShells",
    "Deflection",
    "Factors",
    "Judge",
    "Mode",
    "Quality",
    "Shells",
    "Springs",
    "Stresses",
    "Supports",
    "assemble",
    "buckling_modes",
    "checked_peak",
    "checked_solution",
    "deflect",
    "edge_forces",
    "factored_by",
    "factorise",
    "geometric_stiffness",
    "is_buckled",
    "line_load",
    "matrix_buckling",
    "matrix_modes",
    "natural_modes",
    "ply_stresses",
    "point_masses",
    "refuse_error",
    "relative_distance",
    "solution_quality",
    "surface_load",
    "thermal_forces",
    "thermal_load",
]
