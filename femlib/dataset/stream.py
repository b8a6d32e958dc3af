"""A dataset of any number of rows, written to Parquet as it is made: memory does not grow with the rows.

Rows come in the order of the library, for each state in that of the loads, then the readings; historical rows follow.
The states are solved through joblib, so in whatever `joblib.parallel_config` says (threads, processes, a Dask
cluster). Work is cut by the library's length alone, every piece of noise has a generator of its own, and the linear
algebra of a piece runs on one thread: the rows are the same for any n_jobs and backend.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from femlib.arrays import FloatArray, IntArray
from femlib.dataset.history import history_pieces
from femlib.dataset.samples import StrainModel
from femlib.dataset.sampling import Load, Sampling
from femlib.dataset.states import StateLibrary
from femlib.dataset.stored import StoredDataset, store
from femlib.errors import InputError, is_whole

MOST_TASK_STATES = 1024
"""States of one task, at most."""
LEAST_TASKS = 16
"""Tasks that a library is cut into where it has so many states: work for that many processes."""
WAVE = 32
"""Tasks whose strains are held at once."""
DRAWN_ROWS = 8192
"""Rows whose noise is drawn at once; coloured noise is correlated along at most so many readings."""
OFFSETS, READINGS = 0, 1
"""First words of the generators' seeds: what is drawn once, and what is drawn with the rows."""

StrainMap = Callable[[FloatArray], FloatArray]
"""From states (n_states, n_parameters) to strains (n_states, n_gauges) [microstrain] under one load."""


@runtime_checkable
class MapsStrains(Protocol):
    """A model that can prepare a load: what it returns is called for many states, in other processes too."""

    def strain_map(self, load_factor: float, lift: FloatArray | None = None) -> StrainMap:
        """Return the map from states to strains under a load."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A model, a library and a sampling that fit each other.

    Attributes
    ----------
    model : StrainModel
        The model.
    library : StateLibrary
        The states.
    sampling : Sampling
        What is drawn of each.
    columns : IntArray
        Column of each library parameter among the model's (n_library_parameters,).
    kept : IntArray
        Place of each gauge of the dataset among the model's (n_gauges,).
    offsets : tuple of FloatArray
        What each noise draws once (n_gauges,) [microstrain].
    """

    model: StrainModel
    library: StateLibrary
    sampling: Sampling
    columns: IntArray
    kept: IntArray
    offsets: tuple[FloatArray, ...]

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the dataset's gauges."""
        return tuple(self.model.gauges.names[k] for k in self.kept)

    def states(self, first: int, stop: int) -> FloatArray:
        """Return states of the library in the model's columns; parameters that it does not name are undamaged."""
        wide = np.zeros((stop - first, len(self.model.parameters)))
        wide[:, self.columns] = self.library.between(first, stop)
        return wide


def stream_dataset(
    path: str | Path,
    model: StrainModel,
    library: StateLibrary,
    sampling: Sampling | None = None,
    *,
    history: Sequence[str | Path | pd.DataFrame] = (),
    n_jobs: int | None = None,
) -> StoredDataset:
    """Write noisy readings of every state under every load to a Parquet file, and return it, opened.

    Columns: `state` (its number in the library, -1 for historical rows), the damage parameters [fraction of stiffness
    lost], `load` (name), `load_factor`, `is_train`, `source` ("simulated" or "history 0", ...), then one for each gauge
    [microstrain, compressive positive, divided by the load factor unless the sampling says otherwise]. The side file,
    named `path` with .json added, has seed, noise, model hash, units and what the states come from. Both files appear
    whole or not at all, also when interrupted.

    Parameters
    ----------
    path : str or Path
        File to write (.parquet).
    model : StrainModel
        A wing or a reduced model of it.
    library : StateLibrary
        States; their parameters must be the model's, or some of them.
    sampling : Sampling, optional
        Loads, readings of each state, noise, gauges, seed; the study's if not given.
    history : sequence of str, Path or DataFrame
        Tables of historical readings to append (see `femlib.dataset.history`), noise as it is.
    n_jobs : int, optional
        States solved at a time, as joblib counts; None: what `joblib.parallel_config` says, else one.

    Raises
    ------
    InputError
        If the path cannot be written to, or model, library, sampling and history do not fit.
    """
    if isinstance(history, str | Path | pd.DataFrame):
        raise InputError("history is one table; expected a list of tables; put it in a list")
    if n_jobs is not None and (not is_whole(n_jobs) or n_jobs == 0):
        raise InputError(f"n_jobs is {n_jobs!r}; expected a whole number other than 0; -1 is all processors")
    plan = _plan(model, library, Sampling() if sampling is None else sampling)
    with threadpool_limits(1):
        pieces = chain(_simulated(plan, n_jobs), _historical(plan, history))
        return store(path, pieces, _side(plan, len(history)))


def _plan(model: StrainModel, library: StateLibrary, sampling: Sampling) -> Plan:
    if not isinstance(model, StrainModel):
        raise InputError(
            f"model is a {type(model).__name__}; expected one with gauges, parameters, model_hash and "
            "strains_microstrain, as a Wing has; of a twin, pass its wing"
        )
    if not isinstance(library, StateLibrary):
        raise InputError(
            f"library is a {type(library).__name__}; expected a StateLibrary; listed_states makes one of rows"
        )
    unknown = [name for name in library.parameters if name not in model.parameters]
    if unknown:
        raise InputError(
            f"the library has the parameters {unknown}; expected among the model's {model.parameters}; name those"
        )
    if not len(library):
        raise InputError("the library has no states; expected at least one; give grid_states a level or add a library")
    if any(load.force is not None for load in sampling.loads) and not isinstance(model, MapsStrains):
        raise InputError(f"a load has forces, which a {type(model).__name__} does not take; expected a full model")
    columns = np.array([list(model.parameters).index(name) for name in library.parameters])
    kept = _kept_gauges(model, sampling)
    offsets = [
        noise.fix(len(kept), np.random.default_rng([OFFSETS, sampling.seed, k]))
        for k, noise in enumerate(sampling.noise)
    ]
    return Plan(model, library, sampling, columns, kept, tuple(offsets))


def _kept_gauges(model: StrainModel, sampling: Sampling) -> IntArray:
    names = list(model.gauges.names)
    if sampling.gauges is None:
        kept = np.flatnonzero(model.gauges.is_usable)
    else:
        unknown = [name for name in sampling.gauges if name not in names]
        if unknown or len(set(sampling.gauges)) != len(sampling.gauges):
            raise InputError(
                f"sampling names the gauges {unknown or sorted(sampling.gauges)}; expected each once, among "
                f"{names[0]} to {names[-1]}; correct the names"
            )
        kept = np.array([names.index(name) for name in sampling.gauges], dtype=np.int64)
    if not len(kept):
        raise InputError(f"none of {len(names)} gauges is left; expected at least one outside the regions; name some")
    return kept


def _side(plan: Plan, n_history: int) -> dict[str, Any]:
    """Return what the rows lack, for the side file."""
    sampling = plan.sampling
    return {
        "seed": sampling.seed,
        "parameters": list(plan.library.parameters),
        "gauges": list(plan.gauges),
        "n_states": len(plan.library),
        "states": [part.describe() for part in plan.library.parts],
        "n_history": n_history,
        "loads": [
            {"name": one.name, "factor": one.factor, "has_force": one.force is not None} for one in sampling.loads
        ],
        "samples_per_state": sampling.samples_per_state,
        "train_fraction": sampling.train_fraction,
        "noise": [
            {"kind": type(noise).__name__} | asdict(noise) | {"offsets": offsets.tolist()}  # type: ignore[call-overload]
            for noise, offsets in zip(sampling.noise, plan.offsets, strict=True)
        ],
        "model_hash": plan.model.model_hash,
        "units": _units(sampling),
    }


def _units(sampling: Sampling) -> dict[str, str]:
    divided = ", divided by load_factor" if sampling.divide_by_load else " at load_factor"
    return {
        "gauges": "microstrain, compressive positive" + divided,
        "parameters": "fraction of stiffness lost",
        "load_factor": "multiples of steady level flight",
        "noise": "microstrain at the load factor, before any division",
    }


def _simulated(plan: Plan, n_jobs: int | None) -> Iterator[pd.DataFrame]:
    """Yield the simulated rows; the states' strains are solved a wave of tasks at a time."""
    loads = plan.sampling.loads
    maps = [_strain_map(plan.model, load) for load in loads]
    n_states = len(plan.library)
    step = min(MOST_TASK_STATES, -(-n_states // LEAST_TASKS))
    with Parallel(n_jobs=n_jobs) as parallel:
        for begin in range(0, n_states, WAVE * step):
            firsts = range(begin, min(begin + WAVE * step, n_states), step)
            tasks = [(first, plan.states(first, min(first + step, n_states))) for first in firsts]
            solved = parallel(delayed(_strains)(maps, states) for _, states in tasks)
            for (first, _), strains in zip(tasks, solved, strict=True):
                yield from _rows(plan, first, strains[:, :, plan.kept])


def _strain_map(model: StrainModel, load: Load) -> StrainMap:
    if isinstance(model, MapsStrains):
        return model.strain_map(load.factor, load.force)
    return partial(model.strains_microstrain, load_factor=load.factor)


def _strains(maps: Sequence[StrainMap], states: FloatArray) -> FloatArray:
    """Return the strains (n_loads, n_states, n_gauges): the work of one task."""
    with threadpool_limits(1):
        return np.stack([strain_map(states) for strain_map in maps])


def _rows(plan: Plan, first: int, strains: FloatArray) -> Iterator[pd.DataFrame]:
    """Yield the rows of clean strains (n_loads, n_states, n_gauges) whose first state has the number `first`."""
    n_readings = plan.sampling.samples_per_state
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
    rng = np.random.default_rng([READINGS, sampling.seed, first, number, done])
    readings = np.repeat(clean[:, None, :], n_readings, axis=1)
    for noise, offsets in zip(sampling.noise, plan.offsets, strict=True):
        readings += noise.draw(len(clean), n_readings, offsets, rng)
    readings /= sampling.divisor(load)
    states = np.repeat(np.arange(first, first + len(clean)), n_readings)
    is_train = rng.random(len(states)) < sampling.train_fraction
    damage = np.repeat(plan.library.between(first, first + len(clean)), n_readings, axis=0)
    return _table(
        plan, states, damage, load.name, load.factor, is_train, "simulated", readings.reshape(len(states), -1)
    )


def _historical(plan: Plan, history: Sequence[str | Path | pd.DataFrame]) -> Iterator[pd.DataFrame]:
    for k, source in enumerate(history):
        name = f"history {k}" if isinstance(source, pd.DataFrame) else f"history {k} ({source})"
        rng = np.random.default_rng([READINGS, plan.sampling.seed, k])
        for piece in history_pieces(source, name, plan.library.parameters, plan.gauges):
            factor = piece["load_factor"].to_numpy()
            if plan.sampling.divide_by_load and (factor == 0.0).any():
                raise InputError(f"{name} has a load factor of 0, by which readings are divided; drop those rows")
            strains = piece[list(plan.gauges)].to_numpy()
            readings = strains / factor[:, None] if plan.sampling.divide_by_load else strains
            damage = piece[list(plan.library.parameters)].to_numpy()
            is_train = rng.random(len(piece)) < plan.sampling.train_fraction
            yield _table(plan, np.full(len(piece), -1), damage, "", factor, is_train, f"history {k}", readings)


def _table(
    plan: Plan,
    states: IntArray,
    damage: FloatArray,
    load: str,
    factor: float | FloatArray,
    is_train: np.ndarray,
    source: str,
    readings: FloatArray,
) -> pd.DataFrame:
    """Return rows in the columns of the file."""
    columns: dict[str, object] = {"state": states}
    columns |= dict(zip(plan.library.parameters, damage.T, strict=True))
    columns |= {"load": load, "load_factor": factor, "is_train": is_train, "source": source}
    columns |= dict(zip(plan.gauges, readings.T, strict=True))
    return pd.DataFrame(columns)
