"""Lines that are kept in a file: a run that is repeated, or goes on, does only what is missing.

A line is kept under a key of everything that it depends on: what is asked, the mean strains, and the native core that
searched. After the core is built again nothing old is shown as its work.
"""

import hashlib
import json
from pathlib import Path
from typing import Any

from benchmarks.tables import Line, whole_lines
from femlib.dataset import MeanStrains
from octmip.trees import _native


def key_of(means: MeanStrains, *asked: Any) -> str:
    """Return the key of a line; what is asked is written as JSON."""
    sha = hashlib.sha256(Path(_native.__file__).read_bytes())
    sha.update(means.strain_microstrain.tobytes())
    sha.update(json.dumps(asked, sort_keys=True).encode())
    return sha.hexdigest()


def kept_lines(path: Path | None) -> dict[str, Line]:
    """Return the lines of a file by key, none without one."""
    return {} if path is None else {line.pop("key"): line for line in map(json.loads, whole_lines(path))}


def keep(path: Path | None, key: str, line: Line) -> None:
    """Add a line to a file, if there is one."""
    if path is not None:
        with path.open("a") as file:
            file.write(json.dumps({"key": key, **line}) + "\n")
