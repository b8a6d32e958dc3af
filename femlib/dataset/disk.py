"""Paths of datasets, and the JSON side file that says what a data file is."""

import hashlib
import importlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from femlib.errors import InputError


def arrow() -> tuple[Any, Any]:
    """Return the modules pyarrow and pyarrow.parquet, an optional extra: asked for where Parquet is.

    Raises
    ------
    InputError
        If they are not installed.
    """
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        raise InputError("Parquet files need pyarrow, which is not installed; pip install 'octmip[parquet]'") from error


def checked_target(path: str | Path, endings: Sequence[str]) -> Path:
    """Return a path with one of the endings that is no folder.

    Raises
    ------
    InputError
        If the ending is another, the path is a folder, or it is Parquet and pyarrow is not installed.
    """
    target = Path(path)
    if target.suffix not in endings:
        raise InputError(f"dataset path {target} ends in {target.suffix!r}; expected {' or '.join(endings)}; rename it")
    if target.suffix == ".parquet":
        arrow()
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
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}); expected a dataset; correct the path") from error


def read_side(target: Path, version: int | str) -> dict[str, Any]:
    """Return the side file of a data file, after checking that it is the one that it describes.

    Parameters
    ----------
    target : Path
        The data file.
    version : int or str
        What its entry `version` must be.

    Raises
    ------
    InputError
        If a file is missing or broken, or the data file has changed.
    """
    path = side_path(target)
    try:
        side = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(
            f"{path} does not exist; expected the side file of {target.name}; write the dataset again"
        ) from error
    except (json.JSONDecodeError, UnicodeDecodeError, OSError) as error:
        raise InputError(
            f"{path} is not JSON ({error}); expected a dataset's side file; write the dataset again"
        ) from error
    if not isinstance(side, dict) or side.get("version") != version:
        raise InputError(f"{path} is not a side file of version {version}; write the dataset again")
    if file_sha256(target) != side["sha256"]:
        raise InputError(f"{target} is not the file its side file describes (another sha256); write the dataset again")
    return side
