"""SVG pictures of the documentation, small: no comments and metadata, no breaks between tags, places of two digits."""

import re
from pathlib import Path

PLACES = re.compile(r'(?<=\s)(?:d|x|y|x1|x2|y1|y2|points)="[^"]*"|translate\([^)]*\)')
"""Where lengths of the picture stand; factors of `scale` keep their digits."""
LONG = re.compile(r"-?\d+\.\d{3,}")


def small(svg: str) -> str:
    """Return a picture that looks the same."""
    svg = re.sub(r"<!--.*?-->|<!DOCTYPE.*?>|<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = PLACES.sub(lambda found: LONG.sub(_rounded, " ".join(found[0].split())), svg)
    return re.sub(r">\s+<", "><", svg).strip() + "\n"


def _rounded(number: re.Match[str]) -> str:
    return f"{round(float(number[0]), 2) + 0.0:g}"


def shrink(path: Path) -> None:
    """Make a file small where it is an SVG."""
    if path.suffix == ".svg":
        path.write_text(small(path.read_text(encoding="utf-8")), encoding="utf-8")
