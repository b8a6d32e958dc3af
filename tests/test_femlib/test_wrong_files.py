"""What once ended in a traceback, a warning, a hang or an execution: each file with the sentence it now ends in."""

import io
import json
import os
import pickle
import zipfile
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from femlib.dataset import grid_states, open_dataset, published_strains, stream_dataset
from femlib.errors import InputError, frozen_ints, is_number
from femlib.export.calculix_results import element_points
from femlib.rom import ReducedModel
from femlib.rom.bound import LEVELS, ErrorBound
from tests.test_femlib.test_stream import QUIET, Slope


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    stream_dataset(tmp_path / "data.parquet", Slope(), grid_states({"mu1": [0.0, 0.2]}), QUIET)
    return tmp_path / "data.parquet"


def changed(path: Path, **entries: object) -> Path:
    """Change entries of a side file, the digest made to fit as a stranger would."""
    side = path.with_name(path.name + ".json")
    content = json.loads(side.read_text()) | {"sha256": sha256(path.read_bytes()).hexdigest()}
    side.write_text(json.dumps(content | entries))
    return path


@pytest.mark.parametrize(
    ("entries", "sentence"),
    [
        ({"gauges": "g1"}, r"gauges is 'g1'; expected a list of at least 1 names"),
        ({"gauges": ["g1", "g1"]}, "gauges names something twice"),
        ({"gauges": ["g1", "none"]}, r"lacks the columns \['g1', 'none'\]"),
        ({"rows": 1.5}, "rows is 1.5; expected a whole number"),
    ],
)
def test_a_side_file_of_wrong_values_is_refused(dataset: Path, entries: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        open_dataset(changed(dataset, **entries))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"[" * 100_000, "nested deeper than 100 levels"),
        (b"\xff\xfe{\0}\0", "is not JSON"),
        (b'{"version": 1, "version": 1}', "names 'version' twice"),
        (b'{"version": NaN}', "NaN is no JSON number"),
        (b'{"version": "\\ud800"}', "surrogates not allowed"),
        (b"[]", "holds a JSON list"),
        (b'{"version": "stream 1"}', "lacks the entry 'sha256'"),
    ],
)
def test_a_side_file_that_is_no_object_is_refused(dataset: Path, content: bytes, sentence: str) -> None:
    dataset.with_name("data.parquet.json").write_bytes(content)
    with pytest.raises(InputError, match=sentence):
        open_dataset(dataset)


def test_nothing_but_a_regular_file_is_read(tmp_path: Path) -> None:
    for name in ("data.csv", "model.npz", "data.parquet"):
        os.mkfifo(tmp_path / name)
    readers: list[Callable[[], object]] = [
        lambda: open_dataset(tmp_path / "data.parquet"),
        lambda: published_strains(tmp_path / "data.csv"),
        lambda: ReducedModel.load_file(tmp_path / "model.npz"),
        lambda: ReducedModel.load_file(tmp_path),
        lambda: element_points(tmp_path / "model.npz"),
    ]
    for read in readers:
        with pytest.raises(InputError, match=r"it is no regular file|does not exist"):
            read()


class Song:
    """An object whose unpickling leaves a trace."""

    def __reduce__(self) -> tuple[Any, ...]:
        return os.putenv, ("OCTMIP_TEST_SONG", "sung")


def saved(array: np.ndarray) -> bytes:
    out = io.BytesIO()
    np.lib.format.write_array(out, array, allow_pickle=True)
    return out.getvalue()


def promise(shape: str) -> bytes:
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode() + bytes(64)


@pytest.fixture
def members(tmp_path: Path) -> dict[str, bytes]:
    rows = (np.ones((1, 5)), np.ones((1, 3)))
    couplings = np.zeros(len(LEVELS)), np.zeros((len(LEVELS), 2, 2))
    bound = ErrorBound(rows, rows, np.full(2, 0.5), *couplings)
    arrays = (np.ones(1), np.array([0, 0]), np.ones(2), np.eye(2) / 4, np.ones((1, 2)), np.ones((1, 2)))
    ReducedModel(("mu1", "mu2"), ("g1",), *arrays, bound, {"model": "abc"}, 2).save(tmp_path / "model.npz")
    with zipfile.ZipFile(tmp_path / "model.npz") as held:
        return {name: held.read(name) for name in held.namelist()}


def load(tmp_path: Path, members: dict[str, bytes], packing: int = zipfile.ZIP_STORED) -> ReducedModel:
    with zipfile.ZipFile(tmp_path / "model.npz", "w", packing) as held:
        for name, content in members.items():
            held.writestr(name, content)
    return ReducedModel.load_file(tmp_path / "model.npz")


def test_the_members_make_a_model(tmp_path: Path, members: dict[str, bytes]) -> None:
    assert load(tmp_path, members).n_modes == 2


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("load", saved(np.array([Song()], dtype=object)), "load holds values of type object; expected numbers"),
        ("words", saved(np.array(Song(), dtype=object)), "words holds values of type object"),
        ("load", pickle.dumps(Song()), "not a reduced model"),
        ("load", promise("(10000000000,)"), "load promises shape a list of 1 but has"),
        ("load", promise("(-1,)"), "not a reduced model"),
        ("load", saved(np.array(["1", "2"])), "load holds values of type <U1"),
        ("load", saved(np.array([np.nan, 1.0])), "load holds a number that is not finite"),
        ("load", saved(np.array([1e300, 1.0])), r"load holds a number that is not finite or beyond 1e\+30"),
        ("load", saved(np.ones(3)), r"reduced model load has shape \(3,\)"),
        ("owner", saved(np.array([0, 7])), "owner names the region 7; expected 0 to 1"),
        ("owner", saved(np.array([0, -1])), "expected 0 to 1"),
        ("primal_0", saved(np.ones((1, 3))), r"primal_0 has shape \(1, 3\)"),
        ("primal_1", saved(np.ones((2, 3))), "primal and dual of a region differ in rows"),
        ("own", saved(np.array([0.5, 1.5])), "own is above 1, or joint or pairs below 0"),
        ("joint", saved(np.zeros(2)), r"joint has shape \(2,\)"),
        ("words", saved(np.array('{"parameters": 5}')), "lacks the entry 'provenance'"),
        ("words", saved(np.array("[")), "words is not JSON"),
        ("words", saved(np.ones(3)), "words holds values of type float64"),
    ],
)
def test_a_hostile_member_is_refused(
    tmp_path: Path, members: dict[str, bytes], name: str, content: bytes, sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        load(tmp_path, members | {f"{name}.npy": content})
    assert "OCTMIP_TEST_SONG" not in os.environ


def test_a_packed_or_incomplete_model_is_refused(tmp_path: Path, members: dict[str, bytes]) -> None:
    with pytest.raises(InputError, match=r"member 'words.npy' is compressed"):
        load(tmp_path, members, zipfile.ZIP_DEFLATED)
    with pytest.raises(InputError, match="lacks the entry 'owner'"):
        load(tmp_path, {name: content for name, content in members.items() if name != "owner.npy"})


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        (" 1 1 0. 1e999 0. 0. 0. 0. S", "line 2: '1e999' is no finite number; expected six"),
        (" 1 1 0. x 0. 0. 0. 0. S", "line 2: 'x' is no finite number"),
        (" 1 1 0. nan 0. 0. 0. 0. S", "line 2: 'nan' is no finite number"),
        (" 1 1 0. 1e300 0. 0. 0. 0. S", "line 2: '1e300' is no strain"),
    ],
)
def test_a_hostile_result_is_refused(tmp_path: Path, line: str, sentence: str) -> None:
    (tmp_path / "wing.dat").write_text(f" strains\n{line}\n {'9' * 5000} 1 0. 0. 0. 0. 0. 0. S\n")
    with pytest.raises(InputError, match=sentence):
        element_points(tmp_path / "wing.dat")


def test_numbers_beyond_float64_are_no_numbers() -> None:
    assert not is_number(10**400)
    assert is_number(10**300)
    with pytest.raises(InputError, match=r"holds 1e\+300; expected whole numbers"):
        frozen_ints([1e300], "x", (1,))
    with pytest.raises(InputError, match="x is no array of numbers"):
        frozen_ints([10**400], "x", (1,))
