"""Reduced models as one file."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from femlib.errors import InputError
from femlib.files import whole_file
from femlib.rom.bound import ErrorBound

_OPTIONAL = ("motion",)
_WORDS = ("parameters", "outputs", "provenance", "n_leading")


def write_model(path: str | Path, fields: Mapping[str, Any], bound: ErrorBound) -> None:
    """Write a model's fields and bound to one .npz file, whole or not at all.

    Raises
    ------
    InputError
        If the path does not end in .npz or cannot be written.
    """
    target = Path(path)
    if target.suffix != ".npz":
        raise InputError(f"reduced model path {target} ends in {target.suffix!r}; expected .npz; rename it")
    arrays = {name: value for name, value in fields.items() if name not in _WORDS and value is not None}
    for kind, factors in (("primal", bound.primal), ("dual", bound.dual)):
        arrays |= {f"{kind}_{k}": factor for k, factor in enumerate(factors)}
    words = json.dumps({name: fields[name] for name in _WORDS})
    with whole_file(target) as file:
        np.savez(file, words=np.array(words), **arrays)


def read_model(path: str | Path, names: Sequence[str]) -> dict[str, Any]:
    """Return the fields `names` and the bound of a model that `write_model` wrote.

    Raises
    ------
    InputError
        If the file is not such a model.
    """
    try:
        with np.load(Path(path), allow_pickle=False) as held:
            words = json.loads(str(held["words"]))
            fields = {name: held[name] for name in names if name in held or name not in (*_WORDS, *_OPTIONAL)}
            regions = range(len(words["parameters"]))
            bound = ErrorBound(*(tuple(held[f"{kind}_{k}"] for k in regions) for kind in ("primal", "dual")))
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise InputError(
            f"{path} is not a reduced model ({error}); expected a file that save wrote; save the model again"
        ) from error
    named = {"parameters": tuple(words["parameters"]), "outputs": tuple(words["outputs"])}
    return fields | named | {"provenance": words["provenance"], "n_leading": words["n_leading"], "bound": bound}
