"""Recordings of measuring systems, and the campaign that their windows of steady load make."""

from octmip.recordings.averages import Averages, averages_of, campaign_of
from octmip.recordings.levels import levels_of
from octmip.recordings.modes import modes_of
from octmip.recordings.opening import recording
from octmip.recordings.recording import Channel, Recording
from octmip.recordings.windows import Window

__all__ = [
    "Averages",
    "Channel",
    "Recording",
    "Window",
    "averages_of",
    "campaign_of",
    "levels_of",
    "modes_of",
    "recording",
]
