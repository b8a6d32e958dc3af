"""Datasets in files: Parquet beside a JSON side file, both written whole or not at all.

The side file has what the rows lack (seed, noise, model hash, units, mean strains) and the SHA-256 of the data file,
so that a data file that was changed or cut off is refused.
"""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from femlib.checked import taken
from femlib.dataset.parquet import pyarrow_modules
from femlib.errors import InputError
from femlib.files import parsed_object, read_bytes, regular_file, whole_file

VERSION = "stream 1"
PIECE_BYTES = 2**16
"""Bytes of a file that are hashed at once."""


def checked_target(path: str | Path) -> Path:
    """Return a path of a Parquet file that is no folder.

    Raises
    ------
    InputError
        If the ending is another, the path is a folder, or pyarrow is not installed.
    """
    target = Path(path)
    if target.suffix != ".parquet":
        raise InputError(f"dataset path {target} ends in {target.suffix!r}; expected .parquet; rename it")
    pyarrow_modules()
    if target.is_dir():
        raise InputError(f"dataset path {target} is a folder; expected a file; add a name to it")
    return target


def side_path(target: Path) -> Path:
    """Return the path of a data file's side file."""
    return target.with_name(target.name + ".json")


def file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file, read piece by piece.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    with regular_file(path, "a dataset") as file:
        digest = hashlib.sha256()
        while piece := file.read(PIECE_BYTES):
            digest.update(piece)
        return digest.hexdigest()


def read_side(target: Path) -> dict[str, Any]:
    """Return the side file of a data file, after checking that it is the one that it describes.

    Raises
    ------
    InputError
        If a file is missing or broken, or the data file has changed.
    """
    path = side_path(target)
    if not path.exists():
        raise InputError(f"{path} does not exist; expected the side file of {target.name}; write the dataset again")
    side = parsed_object(read_bytes(path, "a side file"), str(path), "a dataset's side file; write the dataset again")
    if side.get("version") != VERSION:
        raise InputError(f"{path} is no side file of version {VERSION}; write the dataset again")
    if file_sha256(target) != taken(side, "sha256", str(path)):
        raise InputError(f"{target} is not the file its side file describes (another sha256); write the dataset again")
    return side


def write_with_side(target: Path, write: Callable[[Path], dict[str, Any]]) -> None:
    """Write a data file and its side file: `write` fills the file that it is given and returns the side's content."""
    with whole_file(target) as rows_file, whole_file(side_path(target)) as side_file:
        side = write(rows_file)
        side_file.write_text(json.dumps(side, indent=1) + "\n", encoding="utf-8")
