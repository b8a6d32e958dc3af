"""Pictures that a command writes, by the ending of their name."""

import importlib
import io
from pathlib import Path
from typing import TYPE_CHECKING

from octmip.errors import DataError
from octmip.input.files import PathLike, write_bytes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = (".svg", ".png", ".pdf")
DOTS_PER_INCH = 150


def check_picture(path: str | None) -> None:
    """Check, before the work, that a picture of this name can be drawn; None: no picture is asked for.

    Raises
    ------
    DataError
        its ending is no picture's.
    MissingExtraError
        matplotlib, which is an extra, is not installed.
    """
    if path is None:
        return
    if Path(path).suffix not in PICTURES:
        raise DataError(f"--out {path} is no picture; expected one of {', '.join(PICTURES)}")
    importlib.import_module("octmip.interfaces.plot")


def picture_bytes(figure: "Figure", ending: str) -> bytes:
    """Return a figure as a file of the format that an ending of `PICTURES` names."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format=ending[1:], dpi=DOTS_PER_INCH)
    return buffer.getvalue()


def write_picture(path: PathLike, figure: "Figure") -> None:
    """Write a figure in the format that its name ends in, whole or not at all."""
    write_bytes(path, picture_bytes(figure, Path(path).suffix))
