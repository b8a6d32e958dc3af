"""The published table of the study's strains, which takes the place of a simulation."""

from pathlib import Path

import numpy as np
import pandas as pd

from femlib.dataset.gauge_draws import N_PUBLISHED_GAUGES, STUDY_GAUGES
from femlib.dataset.samples import LEVELS_PERCENT, LOAD_FACTOR, MeanStrains, study_states_percent
from femlib.dataset.storage import ROWS_AT_A_TIME, csv_pieces, floats
from femlib.errors import InputError


def published_strains(path: str | Path) -> MeanStrains:
    """Return the strains of the 25 states from a table in the published layout, rows `mean` at load factor 3.

    Columns: mu1_percent, mu2_percent, load_factor, kind, strain_01 to strain_24 [microstrain at that load].

    Raises
    ------
    InputError
        If the file is missing, a column is missing, a state is missing or double, or a number is not finite.
    """
    table = _read_table(Path(path))
    columns = [f"strain_{k:02d}" for k in range(1, N_PUBLISHED_GAUGES + 1)]
    missing = [c for c in ("mu1_percent", "mu2_percent", "load_factor", "kind", *columns) if c not in table.columns]
    if missing:
        raise InputError(f"{path} lacks the columns {missing}; expected the published layout; complete the table")
    is_mean = (table["kind"].astype(str) == "mean").to_numpy() & (floats(table["load_factor"]) == LOAD_FACTOR)
    states = np.stack([floats(table[name][is_mean]) for name in ("mu1_percent", "mu2_percent")], axis=1)
    order = np.lexsort(states.T[::-1])
    states = states[order]
    if not np.array_equal(states, study_states_percent()):
        raise InputError(
            f"{path} has {len(states)} mean rows at load factor {LOAD_FACTOR:g}; expected one for each of the 25 "
            f"states of mu1_percent and mu2_percent in {list(LEVELS_PERCENT)}; complete the table"
        )
    names = tuple(f"g{k:02d}" for k in range(1, N_PUBLISHED_GAUGES + 1))
    usable = np.array([name in STUDY_GAUGES for name in names])
    strains = np.stack([floats(table[name][is_mean])[order] for name in columns], axis=1)
    source = f"published table {Path(path).name}"
    return MeanStrains(study_states_percent(), strains, LOAD_FACTOR, names, usable, source, "")


def _read_table(path: Path) -> pd.DataFrame:
    """Return a CSV as a table, or one sentence on why not."""
    if not path.exists():
        raise InputError(f"{path} does not exist; expected a CSV table; correct the path")
    pieces = list(csv_pieces(path, ROWS_AT_A_TIME))
    if not pieces:
        raise InputError(f"{path} cannot be read (no rows); expected a CSV table; repair the file")
    return pd.concat(pieces, ignore_index=True)
