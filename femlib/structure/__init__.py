"""Structures of the user's own: from a mesh with named sets to strains under damage."""

from femlib.elements.beam2 import BeamSection, rectangular_beam
from femlib.structure.heat import Heated, heated, thermal_buckling
from femlib.structure.model import Structure
from femlib.structure.named_mesh import NamedMesh
from femlib.structure.parts import Spring
from femlib.structure.reader import read
from femlib.structure.reduced import ReducedStructure, reduce
from femlib.structure.vtu import write_vtu

__all__ = [
    "BeamSection",
    "Heated",
    "NamedMesh",
    "ReducedStructure",
    "Spring",
    "Structure",
    "heated",
    "read",
    "rectangular_beam",
    "reduce",
    "thermal_buckling",
    "write_vtu",
]
