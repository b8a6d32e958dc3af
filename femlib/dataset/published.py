"""The published table of the study's strains, which takes the place of a simulation."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from femlib.arrays import FloatArray
from femlib.dataset.gauge_draws import N_PUBLISHED_GAUGES, STUDY_GAUGES
from femlib.dataset.samples import LEVELS_PERCENT, LOAD_FACTOR, MeanStrains, study_states_percent
from femlib.errors import InputError
from femlib.files import regular_file


def published_strains(path: str | Path) -> MeanStrains:
    """Return the strains of the 25 states from a table in the published layout, rows `mean` at load factor 3.

    Columns: mu1_percent, mu2_percent, load_factor, kind, strain_01 to strain_24 [microstrain at that load].

    Raises
    ------
    InputError
        If the file is missing, a column is missing, a state is missing or double, or a number is not finite.

    Examples
    --------
    >>> import pandas as pd
    >>> states = pd.DataFrame(study_states_percent(), columns=["mu1_percent", "mu2_percent"])
    >>> strains = {f"strain_{k:02d}": 1000.0 - 2.0 * states["mu1_percent"] for k in range(1, 25)}
    >>> states.assign(load_factor=3, kind="mean", **strains).to_csv("table.csv", index=False)
    >>> published_strains("table.csv").strain_microstrain.shape
    (25, 24)
    """
    table = _read_table(Path(path))
    columns = [f"strain_{k:02d}" for k in range(1, N_PUBLISHED_GAUGES + 1)]
    missing = [c for c in ("mu1_percent", "mu2_percent", "load_factor", "kind", *columns) if c not in table.columns]
    if missing:
        raise InputError(f"{path} lacks the columns {missing}; expected the published layout; complete the table")
    is_mean = (table["kind"].astype(str) == "mean").to_numpy() & (_floats(table["load_factor"]) == LOAD_FACTOR)
    states = np.stack([_floats(table[name][is_mean]) for name in ("mu1_percent", "mu2_percent")], axis=1)
    order = np.lexsort(states.T[::-1])
    states = states[order]
    if not np.array_equal(states, study_states_percent()):
        raise InputError(
            f"{path} has {len(states)} mean rows at load factor {LOAD_FACTOR:g}; expected one for each of the 25 "
            f"states of mu1_percent and mu2_percent in {list(LEVELS_PERCENT)}; complete the table"
        )
    names = tuple(f"g{k:02d}" for k in range(1, N_PUBLISHED_GAUGES + 1))
    usable = np.array([name in STUDY_GAUGES for name in names])
    strains = np.stack([_floats(table[name][is_mean])[order] for name in columns], axis=1)
    source = f"published table {Path(path).name}"
    return MeanStrains(study_states_percent(), strains, LOAD_FACTOR, names, usable, source, "")


def _read_table(path: Path) -> pd.DataFrame:
    """Return a CSV as a table, or one sentence on why not."""
    with regular_file(path, "a CSV table") as file:
        try:
            return pd.read_csv(file, low_memory=False)
        except (ValueError, LookupError, OSError, OverflowError, MemoryError) as error:  # pandas' own among them
            reason = " ".join(str(error).split())[:300]
            raise InputError(f"{path} cannot be read ({reason}); expected a CSV table; repair the file") from error


def _floats(column: "pd.Series[Any]") -> FloatArray:
    """Return a column as numbers (n,), NaN where a cell is none."""
    if column.dtype.kind in "biuf":
        return np.asarray(column.to_numpy(dtype=np.float64, na_value=np.nan))
    return np.array([_float(value) for value in column], dtype=np.float64)


def _float(value: Any) -> float:
    words = str(value)
    if not words.isascii() or "_" in words:  # Python takes 1_000, and digits of any script
        return math.nan
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan
