"""Strains of solved states, kept while a dataset is streamed: what is expensive of it, before noise is drawn."""

import hashlib
import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError
from femlib.files import whole_file


@dataclass(frozen=True)
class KeptStrains:
    """A folder of strains, one file a task, each there whole or not at all.

    Attributes
    ----------
    folder : Path
        Made where it is missing.
    question : dict
        What the dataset is of, as its side file says: the folder of another one is refused.

    Raises
    ------
    InputError
        If the folder cannot be made, or holds strains of another dataset.
    """

    folder: Path
    question: Mapping[str, Any]

    def __post_init__(self) -> None:
        digest = hashlib.sha256(json.dumps(self.question, sort_keys=True, default=str).encode()).hexdigest()
        name = self.folder / "dataset.sha256"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if not name.exists():
                with whole_file(name) as temporary:
                    temporary.write_text(digest)
        except OSError as error:
            raise InputError(f"folder {self.folder} cannot be made ({error.strerror}); choose another place") from error
        if name.read_text() != digest:
            raise InputError(
                f"folder {self.folder} holds strains of another dataset (model, states, loads, noise or seed differ); "
                "give another folder, or remove this one"
            )

    def find(self, first: int) -> FloatArray | None:
        """Return the strains (n_loads, n_states, n_gauges) of the task that begins with a state, None where missing."""
        path = self._path(first)
        if not path.exists():
            return None
        content = path.read_bytes()
        if hashlib.sha256(content[64:]).hexdigest().encode() != content[:64]:
            raise InputError(f"{path} is damaged; remove it, and its states are solved again")
        strains: FloatArray = np.load(io.BytesIO(content[64:]), allow_pickle=False)
        return strains

    def keep(self, first: int, strains: FloatArray) -> None:
        """Write the strains of a task, whole or not at all."""
        held = io.BytesIO()
        np.save(held, strains, allow_pickle=False)
        with whole_file(self._path(first)) as temporary:
            temporary.write_bytes(hashlib.sha256(held.getvalue()).hexdigest().encode() + held.getvalue())

    def _path(self, first: int) -> Path:
        return self.folder / f"strains-{first}"
