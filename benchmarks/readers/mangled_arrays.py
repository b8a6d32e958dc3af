"""Ways to mangle Parquet tables and NumPy archives: columns and members of other types, shapes and promises."""

import decimal
import importlib
import io
import os
import pickle
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.readers.mangling import CELLS, Generator, mangled_bytes, mangled_json, pick

AnyArray = NDArray[np.generic]
"""An array of whatever kind a file holds."""
CANARY = "OCTMIP_FUZZ_CANARY"
"""Variable of the environment that unpickling a hostile object sets."""


class Canary:
    """An object whose unpickling leaves a trace."""

    def __reduce__(self) -> tuple[Callable[[str, str], None], tuple[str, str]]:
        return os.putenv, (CANARY, "sung")


def mangled_parquet(rng: Generator, content: bytes) -> bytes:
    """Return a Parquet file with one or two of its columns rewritten as another type, or its shape changed."""
    pa, parquet = importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    table = parquet.read_table(io.BytesIO(content))
    for _ in range(int(rng.integers(1, 3))):
        table = _change_table(rng, table, pa)
    out = io.BytesIO()
    try:
        parquet.write_table(table, out, compression=pick(rng, ("snappy", "none", "zstd")))
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError):  # a type that no Parquet file can have
        return mangled_bytes(rng, content)
    return out.getvalue()


def _change_table(rng: Generator, table: Any, pa: Any) -> Any:
    n, n_columns = table.num_rows, table.num_columns
    column = int(rng.integers(max(n_columns, 1)))
    action = int(rng.integers(10))
    if action < 6 and n_columns:
        name = table.column_names[column]
        return table.set_column(column, name, pick(rng, _columns(rng, n, pa))())
    if action == 6 and n_columns:
        return table.remove_column(column)
    if action == 7 and n_columns:  # the same name twice
        return table.append_column(table.column_names[column], pa.array(np.zeros(n)))
    if action == 8:
        about = pick(rng, (b"{", b"[]", b'{"index_columns": 5}', b'{"index_columns": [{"kind": "range"}]}', b"null"))
        return table.replace_schema_metadata({b"pandas": about})
    return table.slice(0, int(rng.integers(0, 3)))


def _columns(rng: Generator, n: int, pa: Any) -> tuple[Any, ...]:
    """Return makers of columns of other types, each of n rows."""
    hostile = [pick(rng, CELLS[:40]) for _ in range(n)]
    return (
        lambda: pa.array([text.encode("utf-8", "replace").decode() for text in hostile]),
        lambda: pa.array([decimal.Decimal("1.50")] * n, pa.decimal128(30, 2)),
        lambda: pa.array([decimal.Decimal(10**60)] * n, pa.decimal256(70, 2)),
        lambda: pa.array([0] * n, pa.timestamp("ns", tz="UTC")),
        lambda: pa.array([2**62] * n, pa.timestamp("s")),
        lambda: pa.array([1] * n, pa.duration("us")),
        lambda: pa.array([100_000_000] * n, pa.date32()),
        lambda: pa.array([[1.0, 2.0]] * n),
        lambda: pa.array([[[None]]] * n),
        lambda: pa.array([{"a": 1}] * n),
        lambda: pa.array([[("a", 1)]] * n, pa.map_(pa.string(), pa.int64())),
        lambda: pa.array(["a"] * n).dictionary_encode(),
        lambda: pa.array([1] * n).dictionary_encode(),
        lambda: pa.array([None] * n),
        lambda: pa.array([None, *[1] * (n - 1)][:n], pa.int64()),
        lambda: pa.array([2**63 + 5] * n, pa.uint64()),
        lambda: pa.array([-(2**63)] * n, pa.int64()),
        lambda: pa.array([float(pick(rng, ("nan", "inf", "1e308", "5e-324")))] * n),
        lambda: pa.array([b"\xff\xfe"] * n),
        lambda: pa.array([True, *[None] * (n - 1)][:n]),
        lambda: pa.array(np.zeros(n, dtype=np.float16)),
    )


def _mangled_words(rng: Generator, array: bytes) -> bytes:
    try:
        words = mangled_json(rng, str(_loaded(array)).encode())
    except ValueError:  # mangled before: no array or no JSON any more
        return mangled_bytes(rng, array)
    return _saved(np.array(words.decode("utf-8", "replace")))


def mangled_archive(rng: Generator, content: bytes) -> bytes:
    """Return a NumPy archive with one or two of its members replaced, lost, repeated or packed."""
    with zipfile.ZipFile(io.BytesIO(content)) as held:
        members = [(name, held.read(name)) for name in held.namelist()]
    packing = zipfile.ZIP_STORED
    for _ in range(int(rng.integers(1, 3))):
        at, action = int(rng.integers(len(members))), int(rng.integers(12))
        name, array = members[at]
        if name == "words.npy" and rng.random() < 0.7:
            members[at] = (name, _mangled_words(rng, array))
        elif action < 8:
            members[at] = (name, _other_array(rng, array))
        elif action == 8:
            del members[at]
        elif action == 9:
            members.append((pick(rng, ("extra.npy", "../up.npy", "no_array")), array))
        elif action == 10:
            packing = pick(rng, (zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA))
        else:
            members[at] = (name, rng.bytes(100))
        if not members:
            break
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", packing) as changed:
        for name, array in dict(members).items():
            changed.writestr(name, array)
    return out.getvalue()


def _loaded(content: bytes) -> AnyArray:
    return np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)


def _saved(array: AnyArray) -> bytes:
    out = io.BytesIO()
    np.lib.format.write_array(out, array, allow_pickle=True)
    return out.getvalue()


def _other_array(rng: Generator, content: bytes) -> bytes:
    try:
        array = _loaded(content)
    except (ValueError, EOFError, TypeError, MemoryError):  # mangled before
        return content
    number = float(pick(rng, ("nan", "inf", "1e308", "-1", "0", "1e-300")))
    forms: tuple[Callable[[], bytes], ...] = (
        lambda: _saved(np.array([Canary()], dtype=object)),
        lambda: pickle.dumps(Canary()),
        lambda: _saved(np.asarray(array, dtype=object)),
        lambda: _saved(array[..., None]),
        lambda: _saved(array[:0] if array.ndim else array),
        lambda: _saved(np.zeros((0, 0))),
        lambda: _saved(np.full(array.shape, number)),
        lambda: _saved(np.full(array.shape, 2**62)),
        lambda: _saved(np.full(array.shape, "text")),
        lambda: _saved(array.astype(pick(rng, ("complex128", "bool", "float16", "datetime64[s]", "S5", ">f8", "V3")))),
        lambda: _promise(pick(rng, ("(10000000000,)", "(-1,)", "(2, 9223372036854775807)", "(1e3,)", "()")), array),
        lambda: _saved(np.asarray(array, order="F")),
        lambda: content[: int(rng.integers(len(content)))],
    )
    try:
        return pick(rng, forms)()
    except (TypeError, ValueError):  # no such cast: the text of words is no number
        return _saved(np.array(["x", "y"]))


def _promise(shape: str, array: AnyArray) -> bytes:
    """Return an array whose header promises another shape than its bytes hold."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode() + array.tobytes()[:64]
