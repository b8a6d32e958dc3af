"""Doors to other people's models: a function or a table becomes a twin.

Every door gives a `FunctionTwin`: a function of parameters and loads with a `Card` that names its readings, their
units, and the range of every parameter. Each parameter that has a range is an effect that the asset may show.
"""

from octmip.gap.doors.card import Card, Range, read_card
from octmip.gap.doors.function import FunctionTwin, function_twin
from octmip.gap.doors.opening import DOORS, open_twin, table_twin

__all__ = [
    "DOORS",
    "Card",
    "FunctionTwin",
    "Range",
    "function_twin",
    "open_twin",
    "read_card",
    "table_twin",
]
