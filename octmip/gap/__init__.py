"""The gap between an asset and its twin: where it lies, what explains it, how far it closes, what to test next."""

from octmip.gap.campaign.blocks import Recorded, gathered
from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.reader import read_campaign
from octmip.gap.diagnosis import Diagnosis, diagnose
from octmip.gap.doors.budget import Budget
from octmip.gap.doors.function import FunctionTwin, function_twin
from octmip.gap.effects import CHAIN
from octmip.gap.effects.simple import SimpleEffect
from octmip.gap.odds import Differences, Odds
from octmip.gap.twins import Addition, AugmentedTwin, CachedTwin

__all__ = [
    "CHAIN",
    "Addition",
    "AugmentedTwin",
    "Budget",
    "CachedTwin",
    "Campaign",
    "Cell",
    "Diagnosis",
    "Differences",
    "FunctionTwin",
    "Odds",
    "Recorded",
    "SimpleEffect",
    "diagnose",
    "function_twin",
    "gathered",
    "read_campaign",
]
