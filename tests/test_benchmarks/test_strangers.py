"""Machines of strangers: an asset unlike its twin, a sealed set, its table."""

import json

import numpy as np
import pytest

from benchmarks.strangers.__main__ import STRANGERS, run
from benchmarks.strangers.frame import FRAME
from octmip.twin import load_of


@pytest.mark.parametrize("name", STRANGERS)
def test_the_asset_differs_from_the_twin_by_per_cents(name):
    stranger = STRANGERS[name]
    twin, own = stranger.twin(), stranger.own(np.random.default_rng(1))
    loads = [load_of(twin.loads, tuple(cell.values())) for cell in stranger.cells]
    shown, said = stranger.means(own), np.array([twin.predict({}, load) for load in loads])
    off = np.abs(shown / said - 1.0)
    assert 0.02 < np.median(off) < 0.2
    assert off.max() < 0.4


def test_columns_carry_the_pull_at_the_roof_whatever_the_joints_do():
    """Moments at foot and head of a storey's two columns are force times height: equilibrium, without the weight."""
    own = {**FRAME.own(np.random.default_rng(2)), "weight": 0.0}
    strain = FRAME.means(own)[-1][8:18] / np.where(np.arange(10) == 6, 1.125, 1.0)
    ratio = np.array([own[f"storey_{k}"] for k in range(1, 6)])
    moment = strain.reshape(5, 2).sum(axis=1) * ratio
    assert np.allclose(moment, 500.0, rtol=1e-9)  # two times 250 microstrain at 100 kN


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strangers") / "set"
    (folder.parent / "table.md").write_text(run(folder, 1, 8, list(STRANGERS), ["plain"]))
    return folder


def test_the_table_has_a_column_for_each_machine_and_selector(folder):
    header = (folder.parent / "table.md").read_text().splitlines()[2]
    assert header.split(" | ")[2:] == ["motor: plain", "frame: plain |"]


def test_a_sound_machine_is_not_accused_by_the_plain_selector(folder):
    keys = json.loads((folder.parent / "set.keys.json").read_text())
    said = [json.loads(line) for line in (folder / "answers.jsonl").read_text().splitlines()]
    sound = [one for one in said if keys[one["case"]]["stratum"] == "sound"]
    assert len(sound) == 4
    assert not any(one["names"] for one in sound)
