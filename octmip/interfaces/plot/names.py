"""Names in a drawing: text and nothing else, in characters that the font has, of a length that fits."""

from collections.abc import Iterable
from functools import lru_cache

import matplotlib
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.legend import Legend
from matplotlib.text import Text

from octmip.input.names import END_ISOLATE, ISOLATE, shortened, shown, visible_lines

LONGEST = 60
"""Characters of a name in a drawing: a longer one keeps its beginning and its end."""


def drawn(name: object, among: Iterable[object] = ()) -> str:
    """Return a name on one line; a long one is cut so that it is none of the others `among` it.

    Characters that no font of the drawing has become escapes. The fonts are those of ``rcParams["font.family"]``: with
    one of them that has the script, names stay as they are.
    """
    text = str(name)
    if len(text) > LONGEST:
        text = shortened([*map(str, among), text], lambda part: len(part) <= LONGEST)[text]
    return in_font(shown(text).strip(ISOLATE + END_ISOLATE))


def in_font(text: str) -> str:
    """Return a text without isolates; characters that no font of the drawing has, or that act, become escapes."""
    text = visible_lines(text)
    if text.isascii():
        return text
    families = tuple(matplotlib.rcParams["font.family"])
    return "".join(
        _drawn_character(character, families) for character in text if character not in ISOLATE + END_ISOLATE
    )


def plain(text: Text) -> Text:
    r"""Return a text of the drawing in which ``$`` and ``\\`` are characters: no formula, no TeX."""
    text.set_parse_math(False)
    text.set_usetex(False)
    return text


def name_entries(legend: Legend, names: Iterable[object]) -> None:
    """Write names into a legend made with other labels: one that begins with ``_`` would have been left out of it."""
    names = list(names)
    for text, name in zip(legend.get_texts(), names, strict=True):
        plain(text).set_text(drawn(name, names))


@lru_cache(maxsize=4096)
def _drawn_character(character: str, families: tuple[str, ...]) -> str:
    code = ord(character)
    if any(get_font(path).get_char_index(code) for path in _fonts(families)):
        return character
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


@lru_cache(maxsize=16)
def _fonts(families: tuple[str, ...]) -> tuple[str, ...]:
    found = [findfont(FontProperties(family=[family])) for family in families]
    return tuple(dict.fromkeys(str(path) for path in found))
