"""A dataset of any number of rows, written to Parquet as it is made: memory does not grow with the rows.

Rows come in the order of the library, for each state in that of the loads, then the readings.
The states are solved through joblib, so in whatever `joblib.parallel_config` says (threads, processes, a Dask
cluster). Work is cut by the library's length alone, every piece of noise has generators of its own, one a gauge
(`femlib.dataset.gauge_draws`), and the linear algebra of a piece runs on one thread: the rows are the same for any
n_jobs and backend, and a gauge reads the same beside any others.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from femlib.arrays import FloatArray
from femlib.checked import names, taken, whole
from femlib.dataset.gauge_draws import GaugeDraws
from femlib.dataset.parquet import GROUP_ROWS, parquet_file, pyarrow_modules, write_groups
from femlib.dataset.plan import MapsStrains, Plan, SampledModel, StrainMap, described, fitted
from femlib.dataset.sampling import Load, Sampling
from femlib.dataset.states import StateLibrary
from femlib.dataset.storage import VERSION, checked_target, file_sha256, read_side, side_path, write_with_side
from femlib.errors import InputError, is_whole
from femlib.kept import ReadOnly

MOST_TASK_STATES = 1024
"""States of one task, at most."""
LEAST_TASKS = 16
"""Tasks that a library is cut into where it has so many states: work for that many processes."""
WAVE = 32
"""Tasks whose strains are held at once."""
DRAWN_ROWS = 8192
"""Rows whose noise is drawn at once."""
READINGS = 1
"""First word of the seeds of what is drawn with the rows."""


@dataclass(frozen=True, slots=True, eq=False)
class StoredDataset:
    """A streamed dataset that was checked against its side file.

    Attributes
    ----------
    path : Path
        The Parquet file.
    n_rows : int
        Its rows.
    parameters, gauges : tuple of str
        Names of the columns of damage [fraction of stiffness lost] and of readings [microstrain].
    about : mapping
        The side file: seed, noise, model hash, units, states, loads.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> def strains(states, load_factor):
    ...     return load_factor * (np.array([900.0, 600.0]) - 200.0 * states)
    >>> names = {"parameters": ("mu1", "mu2"), "gauges": ("g1", "g2"), "model_hash": ""}
    >>> model = SimpleNamespace(**names, strains_microstrain=strains)
    >>> library = grid_states({"mu1": [0.0, 0.4, 0.8], "mu2": [0.0]})
    >>> sampling = Sampling(recipe=Recipe(samples_per_state=10), gauges=("g1",))
    >>> stored = stream_dataset("strains.parquet", model, library, sampling, n_jobs=1)
    >>> stored.parameters, [len(piece) for piece in stored.pieces(n_rows=20)]
    (('mu1', 'mu2'), [20, 10])
    """

    path: Path
    n_rows: int
    parameters: tuple[str, ...]
    gauges: tuple[str, ...]
    about: Mapping[str, Any]

    def pieces(self, n_rows: int = GROUP_ROWS, columns: Sequence[str] | None = None) -> Iterator[pd.DataFrame]:
        """Yield the rows, at most `n_rows` at a time, all columns or those named.

        Raises
        ------
        InputError
            If a column is not in the file or `n_rows` is no whole number above 0.
        """
        if not is_whole(n_rows) or n_rows < 1:
            raise InputError(f"n_rows is {n_rows!r}; expected 1 or more rows at a time; correct it")
        with parquet_file(self.path) as file:
            unknown = [name for name in columns or () if name not in file.schema_arrow.names]
            if unknown:
                known = file.schema_arrow.names
                raise InputError(f"{self.path} has no columns {unknown}; expected some of {known}; correct the names")
            for batch in file.iter_batches(n_rows, columns=None if columns is None else list(columns)):
                yield batch.to_pandas(ignore_metadata=True)

    def read(self, columns: Sequence[str] | None = None) -> pd.DataFrame:
        """Return all rows at once: for datasets that fit into memory.

        Raises
        ------
        InputError
            As `pieces`.
        """
        pieces = list(self.pieces(columns=columns))
        if not pieces:
            raise InputError(f"{self.path} has no rows; expected at least one; write the dataset again")
        return pd.concat(pieces, ignore_index=True)


def open_dataset(path: str | Path) -> StoredDataset:
    """Return a dataset that `stream_dataset` wrote.

    Raises
    ------
    InputError
        If a file is missing or broken, or the data file is not the one that its side file describes.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> def strains(states, load_factor):
    ...     return load_factor * (np.array([900.0, 600.0]) - 200.0 * states)
    >>> names = {"parameters": ("mu1", "mu2"), "gauges": ("g1", "g2"), "model_hash": ""}
    >>> model = SimpleNamespace(**names, strains_microstrain=strains)
    >>> library = grid_states({"mu1": [0.0, 0.4, 0.8], "mu2": [0.0]})
    >>> sampling = Sampling(recipe=Recipe(samples_per_state=10), gauges=("g1",))
    >>> _ = stream_dataset("strains.parquet", model, library, sampling, n_jobs=1)
    >>> open_dataset("strains.parquet").read(["mu1", "g1"]).shape
    (30, 2)
    """
    target = checked_target(path)
    side, where = read_side(target), str(side_path(target))
    n_rows = whole(taken(side, "rows", where), f"{where}: rows")
    parameters, gauges = (names(taken(side, name, where), f"{where}: {name}") for name in ("parameters", "gauges"))
    with parquet_file(target) as file:
        held, columns = file.metadata.num_rows, set(file.schema_arrow.names)
    missing = [name for name in (*parameters, *gauges) if name not in columns]
    if held != n_rows or missing:
        raise InputError(
            f"{target} has {held} rows and lacks the columns {missing[:12]}; expected {n_rows} rows of all columns "
            "that its side file names; write the dataset again"
        )
    return StoredDataset(target, n_rows, parameters, gauges, ReadOnly(side))


def stream_dataset(
    path: str | Path,
    model: SampledModel,
    library: StateLibrary,
    sampling: Sampling | None = None,
    *,
    n_jobs: int | None = None,
) -> StoredDataset:
    """Write noisy readings of every state under every load to a Parquet file, and return it, opened.

    Columns: `state` (its number in the library), the damage parameters [fraction of stiffness lost], `load` (name),
    `load_factor`, `is_train`, then one for each gauge [microstrain, compressive positive, divided by the load
    factor]. The side file, named `path` with .json added, has seed, recipe, model hash, units and what the states come
    from. Both files appear whole or not at all, also when interrupted.

    Parameters
    ----------
    path : str or Path
        File to write (.parquet).
    model : SampledModel
        A wing, or a reduced wing, whose gauges the sampling must name.
    library : StateLibrary
        States; their parameters must be the model's, or some of them.
    sampling : Sampling, optional
        Loads, readings of each state, gauges, seed; the study's if not given.
    n_jobs : int, optional
        States solved at a time, as joblib counts; None: what `joblib.parallel_config` says, else one.

    Raises
    ------
    InputError
        If the path cannot be written to, or model, library and sampling do not fit.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> def strains(states, load_factor):
    ...     return load_factor * (np.array([900.0, 600.0]) - 200.0 * states)
    >>> names = {"parameters": ("mu1", "mu2"), "gauges": ("g1", "g2"), "model_hash": ""}
    >>> model = SimpleNamespace(**names, strains_microstrain=strains)
    >>> library = grid_states({"mu1": [0.0, 0.4, 0.8], "mu2": [0.0]})
    >>> loads = Load("1 g", 1.0), Load("3 g", 3.0)
    >>> sampling = Sampling(loads, Recipe(samples_per_state=10), gauges=("g1", "g2"))
    >>> stored = stream_dataset("strains.parquet", model, library, sampling, n_jobs=1)
    >>> stored.n_rows, stored.gauges
    (60, ('g1', 'g2'))
    """
    if n_jobs is not None and (not is_whole(n_jobs) or n_jobs == 0):
        raise InputError(f"n_jobs is {n_jobs!r}; expected a whole number other than 0; -1 is all processors")
    plan = fitted(model, library, Sampling() if sampling is None else sampling)
    with threadpool_limits(1):
        return _store(path, _simulated(plan, n_jobs), described(plan))


def _simulated(plan: Plan, n_jobs: int | None) -> Iterator[pd.DataFrame]:
    """Yield the simulated rows; the states' strains are solved a wave of tasks at a time."""
    loads = plan.sampling.loads
    maps = [_strain_map(plan.model, load) for load in loads]
    n_states = len(plan.library)
    step = min(MOST_TASK_STATES, -(-n_states // LEAST_TASKS))
    with Parallel(n_jobs=n_jobs) as parallel:
        for begin in range(0, n_states, WAVE * step):
            firsts = range(begin, min(begin + WAVE * step, n_states), step)
            tasks = [plan.states(first, min(first + step, n_states)) for first in firsts]
            solved = parallel(delayed(_strains)(maps, states) for states in tasks)
            for first, strains in zip(firsts, solved, strict=True):
                yield from _rows(plan, first, strains[:, :, plan.kept])


def _strain_map(model: SampledModel, load: Load) -> StrainMap:
    if isinstance(model, MapsStrains):
        return model.strain_map(load.factor, load.force)
    return partial(model.strains_microstrain, load_factor=load.factor)


def _strains(maps: Sequence[StrainMap], states: FloatArray) -> FloatArray:
    """Return the strains (n_loads, n_states, n_gauges): the work of one task."""
    with threadpool_limits(1):
        return np.stack([strain_map(states) for strain_map in maps])


def _rows(plan: Plan, first: int, strains: FloatArray) -> Iterator[pd.DataFrame]:
    """Yield the rows of clean strains (n_loads, n_states, n_gauges) whose first state has the number `first`."""
    n_readings = plan.sampling.recipe.samples_per_state
    n_together = max(1, DRAWN_ROWS // n_readings)
    for start in range(0, strains.shape[1], n_together):
        for number in range(len(plan.sampling.loads)):
            clean = strains[number, start : start + n_together]
            for done in range(0, n_readings, DRAWN_ROWS):
                yield _drawn(plan, number, first + start, clean, done, min(DRAWN_ROWS, n_readings - done))


def _drawn(plan: Plan, number: int, first: int, clean: FloatArray, done: int, n_readings: int) -> pd.DataFrame:
    """Return the rows of `n_readings` readings of each clean strain (n_states, n_gauges) under load `number`."""
    sampling = plan.sampling
    load = sampling.loads[number]
    draws = GaugeDraws([READINGS, sampling.seed, first, number, done], plan.gauges)
    is_train = draws.shared.random(len(clean) * n_readings) < sampling.recipe.train_fraction
    deviation = float(np.sqrt(sampling.recipe.noise_variance))
    readings = (clean[:, None, :] + draws.own(deviation, (len(clean), n_readings))) / load.factor
    states = np.repeat(np.arange(first, first + len(clean)), n_readings)
    damage = np.repeat(plan.library.between(first, first + len(clean)), n_readings, axis=0)
    columns: dict[str, object] = {"state": states}
    columns |= dict(zip(plan.library.parameters, damage.T, strict=True))
    columns |= {"load": load.name, "load_factor": load.factor, "is_train": is_train}
    columns |= dict(zip(plan.gauges, readings.reshape(len(states), -1).T, strict=True))
    return pd.DataFrame(columns)


def _store(path: str | Path, tables: Iterator[pd.DataFrame], side: dict[str, Any]) -> StoredDataset:
    """Write tables one after the other, asked for only once the path has proved writable, and the side's content."""
    target = checked_target(path)

    def write(rows_file: Path) -> dict[str, Any]:
        n_rows = write_groups(rows_file, tables, _schema(side["parameters"], side["gauges"]))
        head = {"version": VERSION, "data": target.name, "sha256": file_sha256(rows_file), "rows": n_rows}
        return head | side

    write_with_side(target, write)
    return open_dataset(target)


def _schema(parameters: Sequence[str], gauges: Sequence[str]) -> Any:
    pa, _ = pyarrow_modules()
    words = pa.dictionary(pa.int32(), pa.string())
    fields = [("state", pa.int64()), *((name, pa.float64()) for name in parameters), ("load", words)]
    fields += [("load_factor", pa.float64()), ("is_train", pa.bool_())]
    return pa.schema([*fields, *((name, pa.float64()) for name in gauges)])
