"""The gap between an asset and its twin: where it lies, what explains it, how far it closes, what to test next."""

from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.reader import read_campaign
from octmip.gap.diagnosis import Diagnosis, diagnose, rounds
from octmip.gap.effects import CHAIN
from octmip.gap.twins.augmented import Addition, AugmentedTwin
from octmip.gap.twins.cached import CachedTwin

__all__ = [
    "CHAIN",
    "Addition",
    "AugmentedTwin",
    "CachedTwin",
    "Campaign",
    "Cell",
    "Diagnosis",
    "diagnose",
    "read_campaign",
    "rounds",
]
