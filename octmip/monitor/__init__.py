"""The tree at work: which state the asset is in, how sure that is, and whether the library still knows the asset."""

from octmip.monitor.compiled import REFUSED, CompiledTree
from octmip.monitor.leaf_likelihood import LeafLikelihood
from octmip.monitor.library import Library, grid_states, library_of
from octmip.monitor.selector import ModelSelector, ParameterTree, Selection, without_dead_ends

__all__ = [
    "REFUSED",
    "CompiledTree",
    "LeafLikelihood",
    "Library",
    "ModelSelector",
    "ParameterTree",
    "Selection",
    "grid_states",
    "library_of",
    "without_dead_ends",
]
