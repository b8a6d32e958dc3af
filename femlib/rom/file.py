"""Reduced models as one file."""

import io
import json
import math
import warnings
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from femlib import checked
from femlib.checked import shown, taken, text, whole
from femlib.errors import InputError, frozen_floats, frozen_ints
from femlib.files import parsed_object, regular_file, whole_file
from femlib.rom.bound import LEVELS, ErrorBound

_OPTIONAL = ("motion",)
_BOUND = ("own", "joint", "pairs")
MOST_ENTRY = 1e30
"""No strain, displacement or norm of one is larger, and products of three of them do not overflow."""
MOST_PROVENANCE = 2**20  # characters of an entry: the places of all gauges may be one
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
        arrays |= {f"{kind}_{k}": rows for k, rows in enumerate(factors)}
    arrays |= {name: getattr(bound, name) for name in _BOUND}
    words = json.dumps({name: fields[name] for name in _WORDS} | {"provenance": dict(fields["provenance"])})
    with whole_file(target) as file:
        np.savez(file, words=np.array(words), **arrays)


def read_model(path: str | Path, names: Sequence[str]) -> dict[str, Any]:
    """Return the fields `names` and the bound of a model that `write_model` wrote.

    Raises
    ------
    InputError
        If the file is not such a model.
    """
    with regular_file(Path(path), "a reduced model") as file:
        try:
            with zipfile.ZipFile(file) as held:
                members = {entry.filename.removesuffix(".npy"): entry for entry in _checked_members(held, file)}
                words = _words(_array(held, taken(members, "words", f"{path}"), "words"))
                regions, optional = range(len(words["parameters"])), set(_OPTIONAL) - members.keys()
                wanted = [name for name in names if name not in (*_WORDS, *optional)]
                factors = [f"{kind}_{k}" for kind in ("primal", "dual") for k in regions]
                arrays = {n: _array(held, taken(members, n, f"{path}"), n) for n in (*wanted, *factors, *_BOUND)}
        except _FAILURES as error:
            reason = " ".join(str(error).split())[:300]
            raise InputError(
                f"{path} is not a reduced model ({reason}); expected a file that save wrote; save the model again"
            ) from error
    rows = [tuple(arrays.pop(f"{kind}_{k}") for k in regions) for kind in ("primal", "dual")]
    bound = ErrorBound(rows[0], rows[1], *(arrays.pop(name) for name in _BOUND))
    _check_shapes(arrays, bound, words, str(path))
    return arrays | words | {"bound": bound}


_FAILURES = (
    InputError,
    OSError,
    EOFError,
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    NotImplementedError,
    RuntimeError,  # an encrypted member
    SyntaxError,  # an array's header that is no Python literal
    MemoryError,
    Warning,
    zipfile.BadZipFile,
    zlib.error,
)


def _checked_members(held: zipfile.ZipFile, file: BinaryIO) -> list[zipfile.ZipInfo]:
    """Return the members; `np.savez` stores them as they are, so none may promise more bytes than the file has."""
    members = held.infolist()
    size = file.seek(0, io.SEEK_END)
    packed = [entry.filename for entry in members if entry.compress_type != zipfile.ZIP_STORED]
    if packed or sum(entry.file_size for entry in members) > size:
        what = f"member {shown(packed[0])} is compressed" if packed else "its members promise more bytes than it has"
        raise InputError(f"{what}; expected members stored as they are")
    if len({entry.filename for entry in members}) < len(members):
        raise InputError("a member stands twice; expected every array once")
    return members


def _array(held: zipfile.ZipFile, entry: zipfile.ZipInfo, name: str) -> np.ndarray:
    """Return an array whose header promises what its bytes hold; one of Python objects is never unpickled."""
    content = io.BytesIO(held.read(entry))
    version = np.lib.format.read_magic(content)
    reader = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}.get(version)
    if reader is None:
        raise InputError(f"{name} is of array version {version}; expected (1, 0)")
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of headers that another Python wrote
        shape, _, kind = reader(content)
    if kind.hasobject or kind.kind not in ("U" if name == "words" else "fiu"):
        raise InputError(f"{name} holds values of type {str(kind)[:60]}; expected numbers")
    if math.prod(shape) * kind.itemsize != entry.file_size - content.tell():
        raise InputError(f"{name} promises shape {shown(shape)} but has {entry.file_size} bytes; expected as many")
    content.seek(0)
    array = np.asarray(np.lib.format.read_array(content, allow_pickle=False))
    if name != "words" and not (np.abs(array.astype(np.float64)) <= MOST_ENTRY).all():
        raise InputError(f"{name} holds a number that is not finite or beyond {MOST_ENTRY:g}; expected strains")
    return array


def _words(array: np.ndarray) -> dict[str, Any]:
    """Return the text entries: names, provenance, number of leading modes."""
    if array.shape != () or array.dtype.kind != "U":
        raise InputError(f"words has shape {array.shape} and type {str(array.dtype)[:60]}; expected one text")
    found = parsed_object(str(array), "words", "names of parameters and outputs")
    provenance = taken(found, "provenance", "words")
    if not isinstance(provenance, dict):
        raise InputError(f"words: provenance is {shown(provenance)}; expected an object of texts")
    return {
        "parameters": checked.names(taken(found, "parameters", "words"), "words: parameters"),
        "outputs": checked.names(taken(found, "outputs", "words"), "words: outputs"),
        "provenance": {
            name: text(value, f"words: provenance.{shown(name)}", MOST_PROVENANCE) for name, value in provenance.items()
        },
        "n_leading": whole(taken(found, "n_leading", "words"), "words: n_leading"),
    }


def _check_shapes(arrays: dict[str, Any], bound: ErrorBound, words: dict[str, Any], path: str) -> None:
    """Refuse arrays that do not fit one another, and owners that are no regions."""
    n_outputs, n_regions, n_modes = len(words["outputs"]), len(words["parameters"]), np.size(arrays["owner"])
    owner = arrays["owner"] = frozen_ints(arrays["owner"], f"{path}: owner", (n_modes,))
    if owner.size and not (owner.min() >= 0 and owner.max() < n_regions):
        raise InputError(f"{path}: owner names the region {owner.max()}; expected 0 to {n_regions - 1}; save it again")
    if words["n_leading"] > n_modes or (words["n_leading"] == 0 and (np.diff(owner) < 0).any()):
        raise InputError(
            f"{path}: n_leading is {words['n_leading']} of {n_modes} modes; expected at most all, and modes in the "
            "order of their regions where it is 0; save the model again"
        )
    widths = {"primal": 1, "dual": n_outputs}
    for kind, factors in (("primal", bound.primal), ("dual", bound.dual)):
        for k, factor in enumerate(factors):
            width = widths[kind] + n_modes + int((owner == k).sum())
            frozen_floats(factor, f"{path}: {kind}_{k}", (-1, width))
    counts = [len(factor) for factor in bound.dual]
    if [len(factor) for factor in bound.primal] != counts:
        raise InputError(f"{path}: primal and dual of a region differ in rows; expected as many; save the model again")
    frozen_floats(bound.own, f"{path}: own", (sum(counts),))
    frozen_floats(bound.joint, f"{path}: joint", (len(LEVELS),))
    frozen_floats(bound.pairs, f"{path}: pairs", (len(LEVELS), n_regions, n_regions))
    if bound.own.max(initial=0.0) > 1.0 or min(bound.joint.min(initial=0.0), bound.pairs.min(initial=0.0)) < 0.0:
        raise InputError(f"{path}: own is above 1, or joint or pairs below 0; expected couplings; save the model again")
    if arrays.get("motion") is not None:
        frozen_floats(arrays["motion"], f"{path}: motion", (-1, n_modes + n_regions + 1))
