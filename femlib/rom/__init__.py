"""Reduced models of damaged structures: microseconds per state, with a guaranteed error bound."""

from femlib.rom.model import ReducedModel
from femlib.rom.modes import ReductionSettings, reduce_ports, reduce_structure
from femlib.rom.strains import ReducedStrains
from femlib.rom.vibration import ReducedModes, reduce_modes

__all__ = [
    "ReducedModel",
    "ReducedModes",
    "ReducedStrains",
    "ReductionSettings",
    "reduce_modes",
    "reduce_ports",
    "reduce_structure",
]
