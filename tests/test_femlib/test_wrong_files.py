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
import pandas as pd
import pytest

from femlib.dataset import MeanStrains, build_dataset, open_dataset, published_strains, read_dataset, write_dataset
from femlib.dataset.history import history_pieces
from femlib.errors import InputError, frozen_ints, is_number
from femlib.rom import ReducedModel
from femlib.rom.bound import LEVELS, ErrorBound
from femlib.wing.export.calculix import _centre_strains


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    states = np.array([[0, 0], [20, 40]])
    means = MeanStrains(states, np.ones((2, 2)), 3.0, ("g1", "g2"), np.array([True, True]), "a test", "abc")
    write_dataset(build_dataset(means), tmp_path / "data.csv")
    return tmp_path / "data.csv"


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
        ({"gauges": ["g1", "none"]}, r"lacks the columns \['none'\]"),
        ({"states_percent": [[0, 0]]}, "1 states_percent and 2 mean_features"),
        ({"states_percent": [[0, 0], [20, 60]]}, r"has the state \[20.0, 40.0\]; expected one of the 2"),
        ({"states_percent": [[0, 0], [20, 1e300]]}, r"holds 1e\+300; expected whole numbers"),
        ({"states_percent": [[0, 0], [20]]}, r"states_percent\[1\] is a list of 1; expected a row of 2 numbers"),
        ({"mean_features": [[1, 10**400], [1, 1]]}, r"mean_features\[0\]\[1\] is a whole number of more than 60"),
        ({"load_factor": 0}, "load_factor is 0; expected a finite number from 1e-09"),
        ({"seed": 1.5}, "seed is 1.5; expected a whole number"),
        ({"recipe": {}}, "recipe lacks the entry 'samples_per_state'"),
        ({"recipe": []}, r"recipe is \[\]; expected an object"),
        ({"source": None}, "source is None; expected a text"),
    ],
)
def test_a_side_file_of_wrong_values_is_refused(dataset: Path, entries: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        read_dataset(changed(dataset, **entries))


@pytest.mark.parametrize("cell", ["9" * 400, "1_000", "١٢", "0x10", "nan", "", "1e999"])
def test_a_cell_that_is_no_number_is_refused(dataset: Path, cell: str) -> None:
    rows = dataset.read_text().splitlines()
    rows[3] = ",".join([*rows[3].split(",")[:3], cell, "1.0"])
    dataset.write_text("\n".join(rows) + "\n")
    with pytest.raises(InputError, match=r"row 2 has g1 = .*; expected finite numbers"):
        read_dataset(changed(dataset))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"[" * 100_000, "nested deeper than 100 levels"),
        (b"\xff\xfe{\0}\0", "is not JSON"),
        (b'{"version": 1, "version": 1}', "names 'version' twice"),
        (b'{"version": NaN}', "NaN is no JSON number"),
        (b'{"version": "\\ud800"}', "surrogates not allowed"),
        (b"[]", "holds a JSON list"),
        (b'{"version": 1}', "lacks the entry 'sha256'"),
    ],
)
def test_a_side_file_that_is_no_object_is_refused(dataset: Path, content: bytes, sentence: str) -> None:
    dataset.with_name("data.csv.json").write_bytes(content)
    with pytest.raises(InputError, match=sentence):
        read_dataset(dataset)


def test_nothing_but_a_regular_file_is_read(tmp_path: Path) -> None:
    for name in ("data.csv", "data.csv.json", "model.npz", "data.parquet"):
        os.mkfifo(tmp_path / name)
    readers: list[Callable[[], object]] = [
        lambda: read_dataset(tmp_path / "data.csv"),
        lambda: open_dataset(tmp_path / "data.parquet"),
        lambda: published_strains(tmp_path / "data.csv"),
        lambda: list(history_pieces(tmp_path / "data.csv", "h", (), ("g1",))),
        lambda: list(history_pieces(tmp_path / "data.parquet", "h", (), ("g1",))),
        lambda: ReducedModel.load_file(tmp_path / "model.npz"),
        lambda: ReducedModel.load_file(tmp_path),
        lambda: _centre_strains(tmp_path / "model.npz"),
    ]
    for read in readers:
        with pytest.raises(InputError, match=r"it is no regular file|does not exist"):
            read()


def test_history_with_numbers_of_any_length_is_refused(tmp_path: Path) -> None:
    (tmp_path / "h.csv").write_text("load_factor,g1\n1,5\n1," + "9" * 400 + "\n")
    with pytest.raises(InputError, match=r"row 1 has g1 = .*\.\.\.; expected"):
        list(history_pieces(tmp_path / "h.csv", "h", (), ("g1",)))
    pd.DataFrame({"load_factor": [1.0], "g1": [[1.0]]}).to_parquet(tmp_path / "h.parquet")
    with pytest.raises(InputError, match="row 0 has g1 = "):
        list(history_pieces(tmp_path / "h.parquet", "h", (), ("g1",)))


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
        (" 1 1 0. 1e999 0. 0. 0. 0. S", "line 2: strain is '1e999'; expected a number"),
        (" 1 1 0. x 0. 0. 0. 0. S", "line 2: strain is 'x'"),
        (" 1 1 0. 0. 0. 0. 0. 0. S", "has 1 points of element 1; expected 8"),
    ],
)
def test_a_hostile_result_is_refused(tmp_path: Path, line: str, sentence: str) -> None:
    (tmp_path / "wing.dat").write_text(f" strains\n{line}\n {'9' * 5000} 1 0. 0. 0. 0. 0. 0. S\n")
    with pytest.raises(InputError, match=sentence):
        _centre_strains(tmp_path / "wing.dat")


def test_numbers_beyond_float64_are_no_numbers() -> None:
    assert not is_number(10**400)
    assert is_number(10**300)
    with pytest.raises(InputError, match=r"holds 1e\+300; expected whole numbers"):
        frozen_ints([1e300], "x", (1,))
    with pytest.raises(InputError, match="x is no array of numbers"):
        frozen_ints([10**400], "x", (1,))
