"""Reduced models of damaged structures: microseconds per state, with a guaranteed error bound."""

from femlib.rom.model import ReducedModel
from femlib.rom.modes import ReductionSettings, reduce_ports, reduce_structure

__all__ = ["ReducedModel", "ReductionSettings", "reduce_ports", "reduce_structure"]
