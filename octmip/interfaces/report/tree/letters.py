"""How wide a text of a drawing is [px]: an estimate that is wide enough for common fonts, and what fits into a room.

Measured over the letters of DejaVu Sans at 12.5 px, in which matplotlib writes, and of Arial at 14 px.
"""

import unicodedata

from octmip.input.names import END_ISOLATE, ISOLATE

CHARACTER, BROAD, WIDER, WIDE = 8.0, 10.5, 12.8, 16.0
"""Width of a small letter or a digit, of a capital or a sign, of an m, and of one as wide as it is high [px]."""
MOST_CHARACTERS = 60
BREAKS = " _-/.,"
"""Characters behind which a name may go on in the next line."""


def text_width(text: str) -> float:
    """Return the width of a text [px]."""
    return sum(_character_width(character) for character in text)


def _character_width(character: str) -> float:
    if unicodedata.combining(character) or character in (ISOLATE, END_ISOLATE):
        return 0.0
    if unicodedata.east_asian_width(character) in "WF" or ord(character) > 0x2E80:
        return WIDE
    if character in "mwMW@%…—":
        return WIDER
    return BROAD if character.isupper() or unicodedata.category(character) == "Sm" else CHARACTER


def wrapped(text: str, room: float, most: int = 2) -> tuple[str, ...]:
    """Return a text on as many lines as it needs in a room [px], or on the `most`; what is longer ends in dots."""
    if most == 1 or text_width(text) <= room or text.startswith(ISOLATE):
        return (fitting(text, room),)
    first = text[: MOST_CHARACTERS + 1]
    end = max(k for k in range(len(first)) if text_width(first[:k]) <= room)
    at = max((k + 1 for k in range(end // 3, end) if text[k] in BREAKS), default=end)
    return text[:at].rstrip(), *wrapped(text[at:].lstrip(), room, most - 1)


def is_whole(text: str, room: float) -> bool:
    """Return whether `wrapped` leaves nothing of a text out on two lines."""
    return len(text) <= 2 * MOST_CHARACTERS and (text.endswith("…") or not wrapped(text, room)[-1].endswith("…"))


def fitting(text: str, room: float) -> str:
    """Return a text that fits into a room [px], its end replaced by dots where it does not."""
    if text_width(text) <= room:
        return text
    room, kept = room - text_width("…"), 0
    while kept < MOST_CHARACTERS and text_width(text[: kept + 1]) <= room:
        kept += 1
    closing = END_ISOLATE if text.startswith(ISOLATE) else ""
    return f"{text[:kept]}{closing}…"
