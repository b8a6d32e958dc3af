"""The aircraft: a wing's twin, the gauges that its trees read, the libraries, the trees, and what the wing bears."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission.capable import Capable, capable_wing
from benchmarks.uav.mission.table_twin import TableTwin
from femlib.dataset import Dataset, MeanStrains, Recipe, build_dataset, published_strains
from femlib.wing import Wing, uav_twin
from octmip import ClassCosts, Limits, OctmipError, Problem, certify, solve
from octmip.formats.tree_file import TreeFile, read_tree_file, record_tree, write_tree_file
from octmip.monitor import (
    Filter,
    LeafLikelihood,
    Library,
    ModelSelector,
    ParameterTree,
    Watch,
    effect_candidates,
    grid_states,
    library_of,
    steady_growth,
)

Floats = NDArray[np.float64]

NOISE_SD = float(np.sqrt(1000.0))
"""Of a reading at any load [microstrain]: the paper's."""
LEVELS = (0.0, 0.2, 0.4, 0.6, 0.8)
"""States of the library that the trees distinguish."""
CRITICAL = 0.4
"""Damage beyond which the paper's rule flies at 2 g."""
RATES = (0.0005, 0.004, 0.0075)
"""Growth rates that the filter allows for, per step: hardly any, half and nearly all of 0 to 80 % in 100 steps."""
SUDDEN, CHANGE = 0.0005, 0.01
WEAR = (2.0 / 3.0) ** 4
"""Growth of damage in a step at 2 g over that at 3 g: the load to the power of four. Assumed."""


@dataclass(frozen=True, slots=True, eq=False)
class Aircraft:
    """Everything that flies.

    Attributes
    ----------
    source
        where the strains come from.
    wing
        femlib's, for places and candidates.
    twin
        its strains.
    gauges
        that are read.
    capable, believed
        what the wing bears, and what its policies take it to bear.
    selector
        the trees for mu1 and mu2 of least absolute error, as one tree.
    """

    source: str
    wing: Wing
    twin: TableTwin
    gauges: tuple[str, ...]
    capable: Capable
    believed: Capable
    selector: ModelSelector

    def strains(self, states: Floats) -> Floats:
        """Return the strains (n, n_gauges) per unit of load of damage fractions (n, 2)."""
        columns = [self.twin.gauges.index(gauge) for gauge in self.gauges]
        return np.asarray(self.twin.predict_states(states, 1.0)[:, columns])

    def cells(self, n_cells: int) -> Library:
        """Return a library of n_cells x n_cells cells that cover 0 to 80 %."""
        width = 0.8 / n_cells
        centres = ((np.arange(n_cells) + 0.5) * width).tolist()
        grid = grid_states([centres, centres])
        return library_of(self.twin, grid, NOISE_SD, gauges=self.gauges, widths=(width, width))

    def filter(self, n_cells: int = 16, *, wear: float = 1.0) -> Filter:
        """Return the filter on the trees' leaves; damage grows `wear` times as fast as at 3 g."""
        cells = self.cells(n_cells)
        likelihood = LeafLikelihood(self.selector.tree, cells)
        return Filter(likelihood, steady_growth(cells, [wear * rate for rate in RATES], SUDDEN, CHANGE))

    def watch(self) -> Watch:
        """Return the watch, with the twin's damage outside the library as candidates."""
        levels = np.linspace(0.0, 0.8, 9).tolist()
        library = library_of(self.twin, grid_states([levels, levels]), NOISE_SD, gauges=self.gauges)
        effect = self.twin.effects["damage_outside_library"]
        assert self.twin.gauge_positions is not None
        places = self.twin.gauge_positions[[self.twin.gauges.index(gauge) for gauge in self.gauges]]
        return Watch(library, effect_candidates(self.twin, effect, library, (20.0, 40.0, 80.0)), places=places)


class _EffectOfWing:
    """The wing's damage outside the library, for a twin of another table: places and signatures are the wing's."""

    def __init__(self) -> None:
        self.twin = uav_twin()
        self.effect = self.twin.effects["damage_outside_library"]

    def __getattr__(self, name: str) -> object:
        return getattr(self.effect, name)

    def signature(self, twin: object, state: object, load_factor: float, place: str = "", time: float = 0.0) -> Floats:
        """Return the signature (n_gauges,) of the wing's own gauges, which the table's are named after."""
        return np.asarray(self.effect.signature(self.twin, {}, load_factor, place))


def build_aircraft(
    folder: Path, strains: str | None = None, seed: int = 0, depth: int = 3, *, is_coarse: bool = False
) -> Aircraft:
    """Return the aircraft; its trees are read from `folder` when they are there for the same data, else solved.

    `is_coarse`: its policies believe the capability of a mesh without close lines at the regions.
    """
    outside = _EffectOfWing()
    effects = {"damage_outside_library": outside}
    wing = outside.twin.wing
    if strains is None:
        levels = np.linspace(0, 80, 9).astype(int)
        states = grid_states([levels.tolist(), levels.tolist()])
        fine = outside.twin.predict_states(states / 100.0, 3.0)
        names, usable = outside.twin.gauges, wing.gauges.is_usable
        source = "femlib wing, reduced"
        table = MeanStrains(states.astype(int), fine, 3.0, names, usable, source, wing.model_hash)
        coarse = (states % 20 == 0).all(axis=1)  # the study's 25 states among them
        study = replace(table, states_percent=table.states_percent[coarse], strain_microstrain=fine[coarse])
        data = build_dataset(study, Recipe(), seed=seed)
    else:
        table = published_strains(strains)
        data = build_dataset(table, Recipe(), seed=seed)
    twin = TableTwin.of(table, effects)  # type: ignore[arg-type]
    places = wing.gauges.position[[wing.gauges.names.index(gauge) for gauge in twin.gauges], :2]
    twin = replace(twin, gauge_positions=places)
    library = library_of(twin, grid_states([LEVELS, LEVELS]), NOISE_SD, gauges=data.gauges)
    trees = tuple(_tree(folder, data, label, depth) for label in ("mu1", "mu2"))
    capable = capable_wing(folder)
    believed = capable_wing(folder, is_coarse=True) if is_coarse else capable
    return Aircraft(data.source, wing, twin, data.gauges, capable, believed, _selector(library, trees))


def _selector(library: Library, files: Sequence[TreeFile]) -> ModelSelector:
    names = ("mu1", "mu2")
    trees = [ParameterTree.of(file, name) for file, name in zip(files, names, strict=True)]
    return ModelSelector.of_trees(library, trees)


def problem_of(data: Dataset, label: str, depth: int) -> Problem:
    """Return the problem of a tree of least absolute error."""
    percent = np.array(LEVELS) * 100.0
    costs = np.abs(percent[:, None] - percent[None, :])
    labels = getattr(data, label)[data.is_train]
    return Problem(data.features[data.is_train], labels, depth=depth, loss=ClassCosts(costs), feature_names=data.gauges)


def _tree(folder: Path, data: Dataset, label: str, depth: int) -> TreeFile:
    problem = problem_of(data, label, depth)
    path = folder / f"tree_{label}.json"
    if path.exists():
        try:
            file = read_tree_file(path)
            if file.sha256 == problem.digest() and file.settings["loss"] == problem.loss.to_json():
                return file
        except OctmipError:
            pass  # another version's file: solved again below
    solution = solve(problem, "exact", Limits(seconds=300.0))
    certify(problem, solution)
    file = record_tree(problem, solution, label)
    folder.mkdir(parents=True, exist_ok=True)
    write_tree_file(path, file)
    return file
