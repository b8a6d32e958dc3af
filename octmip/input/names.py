r"""Names of features, classes, sensors and files as a person may safely see them.

A name is text from outside. Shown as it is, it can move the cursor of a terminal, turn the direction of reading, hide,
begin a line that the report never wrote, or be text that UTF-8 cannot hold. Here characters that act instead of being
seen become escapes (``\\x1b``, ``\\u202e``); all others, of any script, stay. What a target reads as its own language
(SQL, HTML, Markdown) is escaped where that target is written.
"""

import re
import unicodedata
from bisect import bisect_left
from collections.abc import Callable, Iterable
from html import escape

UNSEEN = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]")
"""Characters that count as printable but leave no mark: fillers, joiners and selectors of the Unicode standard."""
LIKE_AN_ESCAPE = re.compile(r"\\[xuU]")
RIGHT_TO_LEFT = {"R", "AL", "AN"}
ISOLATE, END_ISOLATE = "\u2068", "\u2069"
ISOLATED = re.compile(f"{ISOLATE}([^{ISOLATE}{END_ISOLATE}]*){END_ISOLATE}")


def visible(text: object) -> str:
    """Return a text on one line with every character that acts, or cannot be seen or encoded, as its escape.

    A name isolated by `shown` stays isolated: its isolate is closed, so it acts on nothing outside.
    """
    parts = ISOLATED.split(str(text))  # outside, inside, outside, ...
    parts = [part if _is_plain(part) else "".join(_seen(character) for character in part) for part in parts]
    return "".join(f"{ISOLATE}{part}{END_ISOLATE}" if k % 2 else part for k, part in enumerate(parts))


def visible_lines(text: str) -> str:
    """Return a text whose lines are `visible`; only the ends of lines stay what they are."""
    return "\n".join(visible(line) for line in text.split("\n"))


def shown(name: object) -> str:
    """Return a name as it stands in a sentence: `visible`, different for different names, and kept apart.

    Backslashes are doubled where the name holds an escape or looks as if it did. A name that is empty, or begins or
    ends with a blank, stands in quotes. One that is read from right to left is isolated, so that the words, signs and
    numbers around it stay in order.
    """
    text = str(name)
    if not _is_plain(text) or LIKE_AN_ESCAPE.search(text):
        text = "".join("\\\\" if character == "\\" else _seen(character) for character in text)
    if text != text.strip() or not text:
        text = f'"{text}"'
    if not text.isascii() and any(unicodedata.bidirectional(character) in RIGHT_TO_LEFT for character in text):
        return f"{ISOLATE}{text}{END_ISOLATE}"
    return text


def shortened(names: Iterable[str], fits: Callable[[str], bool]) -> dict[str, str]:
    """Return names by their whole text, each that does not fit cut in the middle, so that different ones stay so.

    The cut lies in the middle, else near the beginning, else near the end; where no place keeps all of them apart,
    those that are cut end in their number.
    """
    whole = list(dict.fromkeys(names))
    found: dict[str, str] = {}
    for share in (0.5, 0.2, 0.8):
        found = {name: name if fits(name) else _cut(name, share, fits) for name in whole}
        if len(set(found.values())) == len(whole):
            return found
    numbered = {name: f" ({k})" for k, name in enumerate(whole, 1) if not fits(name)}
    return found | {name: _cut(name, 0.5, fits, end) for name, end in numbered.items()}


def _cut(name: str, share: float, fits: Callable[[str], bool], end: str = "") -> str:
    """Return as much of a name as fits around dots, a share of it before them, and an end behind it."""

    def around(kept: int) -> str:
        before = round(share * kept)
        return f"{name[:before]}…{name[len(name) - kept + before :]}{end}"

    kept = bisect_left(range(1, len(name)), True, key=lambda kept: not fits(around(kept)))
    return around(kept)


def html_text(text: object) -> str:
    """Return a text for the inside of an HTML element or quoted attribute: `visible` and escaped."""
    return escape(visible(text))


def _is_plain(text: str) -> bool:
    return text.isprintable() and (text.isascii() or not UNSEEN.search(text))


def _seen(character: str) -> str:
    if _is_plain(character):
        return character
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
