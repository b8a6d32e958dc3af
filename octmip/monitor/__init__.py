"""The tree at work: which state the asset is in, how sure that is, and whether the library still knows the asset."""

from octmip.monitor.belief import Belief
from octmip.monitor.candidates import Candidate, effect_candidates
from octmip.monitor.compiled import REFUSED
from octmip.monitor.filter import Filter, learnt_rates
from octmip.monitor.finding import Finding, Proposal, explain
from octmip.monitor.forecast import Forecast, remaining_life
from octmip.monitor.growth import Growth, steady_growth
from octmip.monitor.leaf_likelihood import LeafLikelihood
from octmip.monitor.library import Library, grid_states, library_of
from octmip.monitor.planner import Action, Planner
from octmip.monitor.selector import ModelSelector, ParameterTree, Selection
from octmip.monitor.series import Series
from octmip.monitor.stream import Monitor, Refusal, Result
from octmip.monitor.surprise import leaf_p_value
from octmip.monitor.watch import Watch

__all__ = [
    "REFUSED",
    "Action",
    "Belief",
    "Candidate",
    "Filter",
    "Finding",
    "Forecast",
    "Growth",
    "LeafLikelihood",
    "Library",
    "ModelSelector",
    "Monitor",
    "ParameterTree",
    "Planner",
    "Proposal",
    "Refusal",
    "Result",
    "Selection",
    "Series",
    "Watch",
    "effect_candidates",
    "explain",
    "grid_states",
    "leaf_p_value",
    "learnt_rates",
    "library_of",
    "remaining_life",
    "steady_growth",
]
