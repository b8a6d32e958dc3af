"""The readers of selectors and campaigns, as the fuzz of files tries them."""

import contextlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks.readers.file_reader import run
from benchmarks.readers.mangling import Generator, pick
from femlib.arrays import FloatArray
from octmip.errors import OctmipError
from octmip.gap import read_campaign
from octmip.monitor import Library, ModelSelector
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split
from octmip.twin import Effect


def make_selector(number: int, folder: Path) -> None:
    """Write a selector of four states."""
    rng = np.random.default_rng([91, number])
    states = np.array([[0.0, 0.0], [0.2, 0.0], [0.0, 0.4], [0.2, 0.4]])
    slopes = rng.normal(size=(4, 2, 3)) if number % 2 else np.zeros(0)
    gauges, strains = ("g1", "g2", "g3"), 100 * rng.normal(size=(4, 3))
    library = Library(("mu1", "mu2"), states, gauges, strains, np.ones(3), slopes=slopes)
    right = HyperplaneSplit((0, 2), (1.0, -0.5), 3.0, Leaf(2), Leaf(3))
    ModelSelector(library, Split(1, 2.5, Split(0, 0.1, Leaf(0), Leaf(1)), right)).write(folder / "selector.json")


def read_selector(rng: Generator, folder: Path) -> None:
    """Read a selector and select by it."""
    selector = ModelSelector.read(folder / "selector.json")
    with contextlib.suppress(OctmipError):
        selector.select(np.full(len(selector.library.gauges), pick(rng, (0.0, 1e6, -3.0))), 1.0)
    selector.write(folder / "again.json")


class Beam:
    """A twin in a few lines: a cantilever with four gauges."""

    gauges = ("g1", "g2", "g3", "g4")
    parameters = ("mu1", "mu2")
    is_linear_in_load = True
    effects: Mapping[str, Effect] = {}

    def predict(self, state: Mapping[str, float], load_factor: float) -> FloatArray:
        """Return the strains [microstrain]."""
        healthy = np.array([900.0, 700.0, 500.0, 300.0])
        damage = np.array([state.get("mu1", 0.0), state.get("mu1", 0.0), state.get("mu2", 0.0), state.get("mu2", 0.0)])
        return np.asarray(load_factor * healthy * (1.0 + damage))


def make_campaign(number: int, folder: Path) -> None:
    """Write a campaign of two loads, three repeats each."""
    rng, twin = np.random.default_rng([92, number]), Beam()
    lines = ["# a comment", "test,load_factor,mu1,mu2,time,temperature,g1,g2,g3,g4"]
    for k, load in enumerate((1.0, 1.0, 1.0, 2.0, 2.0, 2.0)):
        cells = twin.predict({}, load) + rng.normal(0.0, 5.0, 4)
        lines.append(f"first,{load:g},0,0,{k},20," + ",".join(f"{cell:.2f}" for cell in cells))
    (folder / "campaign.csv").write_text("\n".join(lines) + "\n")


def read_gap(rng: Generator, folder: Path) -> None:
    """Read a campaign, or have it diagnosed."""
    read_campaign(folder / "campaign.csv", Beam())
    if rng.random() < 0.02:
        run("diagnose", folder / "campaign.csv", "--twin", "benchmarks.readers.monitoring:Beam")
