"""Streamed datasets: the same rows however they are made, memory that does not grow, whole or nothing."""

import json
import tracemalloc
from pathlib import Path

import joblib
import numpy as np
import pyarrow as pa
import pytest

from femlib.arrays import BoolArray, FloatArray
from femlib.dataset import (
    Load,
    Recipe,
    Sampling,
    StateLibrary,
    grid_states,
    listed_states,
    open_dataset,
    parquet,
    random_states,
    stream,
    stream_dataset,
)
from femlib.errors import InputError
from femlib.wing import Wing

QUIET = Sampling(recipe=Recipe(1, 0.0))


class FourGauges:
    """Names, and the last inside a region."""

    names = ("g01", "g02", "g03", "g04")
    is_usable: BoolArray = np.array([True, True, True, False])


class Slope:
    """Strains that grow with damage and load: no solver, so that a million rows take seconds."""

    parameters = ("mu1", "mu2", "mu3")
    gauges = FourGauges()
    model_hash = "slope"

    def strains_microstrain(self, states: FloatArray, load_factor: float) -> FloatArray:
        return load_factor * (1000.0 + states @ np.array([[300.0, 1, 2, 3], [0, 200, 0, 0], [0, 0, 100, 0]]))


class Broken(Slope):
    """A model that is interrupted after so many tasks."""

    def __init__(self, n_tasks: int) -> None:
        self.left = n_tasks

    def strains_microstrain(self, states: FloatArray, load_factor: float) -> FloatArray:
        self.left -= 1
        if self.left < 0:
            raise KeyboardInterrupt
        return super().strains_microstrain(states, load_factor)


def library() -> StateLibrary:
    return grid_states({"mu1": [0.0, 0.4, 0.8], "mu2": [0.0, 0.6]}) + random_states(["mu1", "mu2"], 40, seed=3)


def noisy(**change: object) -> Sampling:
    settings = {"loads": [Load("2 g", 2.0), Load("3 g", 3.0)], "recipe": Recipe(5), "seed": 7}
    return Sampling(**(settings | change))


def test_rows_are_the_models_strains_divided_by_the_load(tmp_path: Path) -> None:
    states = grid_states({"mu1": [0.0, 0.8], "mu3": [0.0, 0.4]})
    sampling = Sampling(loads=[Load("down", -1.0), Load("3 g", 3.0)], recipe=Recipe(2, 0.0))
    data = stream_dataset(tmp_path / "a.parquet", Slope(), states, sampling)
    rows = data.read()
    assert data.n_rows == len(rows) == 4 * 2 * 2
    assert data.gauges == ("g01", "g02", "g03")
    assert list(rows.columns[:6]) == ["state", "mu1", "mu3", "load", "load_factor", "is_train"]
    full = np.stack([rows["mu1"], np.zeros(16), rows["mu3"]], axis=1)
    assert rows[["g01", "g02", "g03"]].to_numpy() == pytest.approx(Slope().strains_microstrain(full, 1.0)[:, :3])
    assert sorted(zip(rows["load"], rows["load_factor"], strict=True))[::8] == [("3 g", 3.0), ("down", -1.0)]
    assert rows["state"].value_counts().tolist() == [4, 4, 4, 4]


@pytest.mark.long
def test_threads_and_processes_write_the_same_rows_as_one_job(tiny: Wing, tmp_path: Path) -> None:
    alone = stream_dataset(tmp_path / "alone.parquet", tiny, library(), noisy())
    for backend in ("threading", "loky"):
        with joblib.parallel_config(backend=backend):
            other = stream_dataset(tmp_path / f"{backend}.parquet", tiny, library(), noisy(), n_jobs=2)
        assert other.about["sha256"] == alone.about["sha256"]


def test_the_wing_under_forces_of_ones_own_is_the_full_solution(tiny: Wing, tmp_path: Path) -> None:
    force = np.roll(tiny.lift, 6)
    states = listed_states(["mu2"], [[0.5]])
    data = stream_dataset(tmp_path / "a.parquet", tiny, states, Sampling([Load("own", 2.0, force)], Recipe(1, 0.0)))
    full = -1e6 * (tiny.strain_rows @ tiny.structure.solve(np.array([[0.0, 0.5]]), force)[0])
    assert data.read()[list(data.gauges)].to_numpy()[0] == pytest.approx(-full[tiny.gauges.is_usable], rel=1e-8)


def peak(path: Path, n_states: int) -> tuple[int, int]:
    """Return the most memory held while streaming: Python's and numpy's [bytes], and arrow's so far."""
    tracemalloc.start()
    states = random_states(["mu1", "mu2", "mu3"], n_states, seed=0)
    assert stream_dataset(path, Slope(), states, Sampling(recipe=Recipe(1))).n_rows == n_states
    held = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return held, int(pa.default_memory_pool().max_memory())


@pytest.mark.long
def test_memory_does_not_grow_with_the_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parquet, "GROUP_ROWS", 2048)
    monkeypatch.setattr(stream, "WAVE", 2)
    small, large = (peak(tmp_path / f"{n}.parquet", n) for n in (10_000, 80_000))
    rows_bytes = 70_000 * 10 * 8
    assert large[0] - small[0] < rows_bytes / 40
    assert large[1] - small[1] < rows_bytes / 40


def test_rows_do_not_depend_on_the_size_of_the_groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = stream_dataset(tmp_path / "a.parquet", Slope(), library(), noisy()).read()
    monkeypatch.setattr(parquet, "GROUP_ROWS", 37)
    data = stream_dataset(tmp_path / "b.parquet", Slope(), library(), noisy())
    assert data.read().astype({"load": str}).equals(whole.astype({"load": str}))
    assert max(len(piece) for piece in data.pieces(20)) == 20
    assert next(data.pieces(20, ["g02"])).shape == (20, 1)


def test_the_side_file_says_seed_noise_model_units_states_and_loads(tmp_path: Path) -> None:
    data = stream_dataset(tmp_path / "a.parquet", Slope(), library(), noisy())
    side = json.loads((tmp_path / "a.parquet.json").read_text())
    assert side == open_dataset(tmp_path / "a.parquet").about == data.about
    assert side["seed"] == 7
    assert side["model_hash"] == "slope"
    assert side["rows"] == 46 * 2 * 5
    assert side["recipe"] == {"samples_per_state": 5, "noise_variance": 1000.0, "train_fraction": 0.7}
    assert "microstrain" in side["units"]["gauges"]
    assert side["states"][1] == {"kind": "random", "n_states": 40, "seed": 3, "n_damaged": 2, "largest": 0.8}


def test_nothing_is_left_of_an_interrupted_stream_and_the_old_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    old = stream_dataset(path, Slope(), library(), QUIET).about["sha256"]
    with pytest.raises(KeyboardInterrupt):
        stream_dataset(path, Broken(3), library(), noisy())
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.parquet", "a.parquet.json"]
    assert open_dataset(path).about["sha256"] == old


def test_a_changed_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    stream_dataset(path, Slope(), library(), QUIET)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputError, match="is not the file its side file describes"):
        open_dataset(path)


def test_a_gauge_reads_the_same_in_any_set_and_order_of_gauges(tmp_path: Path) -> None:
    whole = stream_dataset(tmp_path / "a.parquet", Slope(), library(), noisy()).read()
    some = ["g03", "g01"]
    part = stream_dataset(tmp_path / "b.parquet", Slope(), library(), noisy(gauges=some)).read()
    assert part[some].equals(whole[some])
    assert part["is_train"].equals(whole["is_train"])


def test_a_random_library_is_the_same_in_any_pieces() -> None:
    states = random_states(["a", "b", "c"], 5000, seed=2, n_damaged=2, largest=0.5)
    whole = states.between(0, 5000)
    assert np.array_equal(whole, np.concatenate([states.between(k, min(k + 700, 5000)) for k in range(0, 5000, 700)]))
    counts = np.bincount((whole > 0).sum(axis=1))
    assert counts[0] == 0
    assert counts[1:] == pytest.approx([2500, 2500], rel=0.05)
    assert whole.max() < 0.5
    assert np.array_equal(
        random_states(["a", "b", "c"], 10, seed=2, n_damaged=2, largest=0.5).between(0, 10), whole[:10]
    )
