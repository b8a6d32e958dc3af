"""Metered loads: each row of a time series has its own. Rows of like loads become cells.

The loads of run and campaign are gathered around common centres c by k-means, each over the range of its amounts. In
each test and state the readings near a centre follow a polynomial p in l - c, of degree two where the rows bear it,
else one; a reading becomes y - p(l - c) + p(0), and its load c. Where a group's loads do not vary enough to tell p, it
stays at their mean. Loads at which one of the two stood still are the centres of the other.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Campaign
from octmip.twin import Load

Floats = NDArray[np.float64]

MOST_LOADS, REPEATS = 40, 3.0
"""Loads of a test up to which, and mean repeats from which, each load is its own cell."""
MOST_CENTRES, ROWS_OF_ONE = 20, 12
"""Centres at most, and rows for each on average at least."""
MOST_LOOKED = 4000
"""Rows by which the centres are found."""
BORNE = 4
"""Rows for each coefficient of a polynomial."""


def gathered_alike(campaigns: Sequence[Campaign]) -> tuple[list[Campaign], list[str]]:
    """Return campaigns whose rows of like loads share one, and a note; as they are where none is metered."""
    if not any(_is_metered(campaign) for campaign in campaigns):
        return list(campaigns), []
    applied = np.concatenate([campaign.applied for campaign in campaigns])
    extent = np.where(np.ptp(applied, axis=0) > 0.0, np.ptp(applied, axis=0), 1.0)
    still = [campaign.applied for campaign in campaigns if not _is_metered(campaign)]
    if still:
        centres = np.unique(np.concatenate(still), axis=0)
    else:
        centres = _centres(applied / extent, min(len(campaign.test) for campaign in campaigns)) * extent
    moved = [_moved(campaign, centres, extent) for campaign in campaigns]
    n_left_out = sum(len(before.test) - len(after.test) for before, after in zip(campaigns, moved, strict=True))
    left_out = f"; {n_left_out} rows with too few like them are left out" if n_left_out else ""
    return moved, [
        f"Nearly every row has its own load: rows are gathered around {len(centres)} loads, the readings moved there "
        f"along the curve through their like{left_out}."
    ]


def looked_at(campaign: Campaign) -> list[tuple[Load, NDArray[np.int64]]]:
    """Return loads with the rows that are like them: all loads, or of metered ones a few and the rows nearest to each.

    To see whether readings are plausible, nobody's model has to answer ten thousand questions.
    """
    if not _is_metered(campaign):
        return [(cell.load, cell.rows) for cell in campaign.cells]
    applied = campaign.applied
    scaled = applied / np.where(np.ptp(applied, axis=0) > 0.0, np.ptp(applied, axis=0), 1.0)
    order = np.lexsort(scaled.T[::-1])
    chosen = order[np.linspace(0, len(order) - 1, MOST_LOADS).round().astype(int)]
    nearest = np.argmin(np.linalg.norm(scaled[:, None] - scaled[chosen], axis=2), axis=1)
    of_row = {int(row): cell.load for cell in campaign.cells for row in cell.rows}
    return [(of_row[int(row)], np.flatnonzero(nearest == k)) for k, row in enumerate(chosen)]


def _is_metered(campaign: Campaign) -> bool:
    n_cells = len(campaign.cells)
    return n_cells > MOST_LOADS and len(campaign.test) < REPEATS * n_cells


def _centres(scaled: Floats, n_rows: int) -> Floats:
    """Return centres (k, n_loads) of rows (n, n_loads)."""
    from sklearn.cluster import KMeans  # only here: a diagnosis of a few loads does not need it

    looked = scaled[:: max(1, len(scaled) // MOST_LOOKED)]
    n_centres = min(MOST_CENTRES, max(2, n_rows // ROWS_OF_ONE), len(np.unique(looked, axis=0)))
    found = KMeans(n_centres, n_init=1, random_state=0).fit(looked).cluster_centers_
    return np.asarray(found[np.lexsort(found.T[::-1])], dtype=np.float64)


def _moved(campaign: Campaign, centres: Floats, extent: Floats) -> Campaign:
    """Return the rows of a campaign at the nearest centres; those that are too few to be moved are left out."""
    apart = np.linalg.norm((campaign.applied[:, None] - centres) / extent, axis=2)
    nearest = np.argmin(apart, axis=1)
    groups: dict[tuple[str, bytes, int], list[int]] = {}
    for row, test in enumerate(campaign.test):
        groups.setdefault((test, campaign.states[row].tobytes(), int(nearest[row])), []).append(row)
    readings, loads, kept = campaign.readings.copy(), centres[nearest], []
    for (_, _, centre), members in groups.items():
        rows = np.array(members)
        away = (campaign.applied[rows] - centres[centre]) / extent
        columns = _columns(away)
        if columns is None:
            loads[rows] = campaign.applied[rows].mean(axis=0)
        elif len(rows) >= BORNE * (1 + away.shape[1]):
            readings[rows] -= _course(columns, readings[rows])
        else:
            continue
        kept += members
    loads = loads[:, 0] if campaign.load_factor.ndim == 1 else loads
    return replace(campaign, readings=readings, load_factor=loads).of_rows(np.array(sorted(kept), dtype=np.int64))


def _columns(away: Floats) -> Floats | None:
    """Return what a polynomial of rows (n, n_loads) away from a centre consists of (n, k); None if they do not vary."""
    pairs = [away[:, i] * away[:, j] for i in range(away.shape[1]) for j in range(i + 1)]
    varied = np.ptp(away, axis=0) > 0.0
    for columns in (np.column_stack([away, *pairs]), away[:, varied]):
        design = np.column_stack([np.ones(len(away)), columns])
        is_borne = len(away) >= BORNE * design.shape[1] or columns.shape[1] <= away.shape[1]
        if is_borne and columns.size and np.linalg.matrix_rank(design) == design.shape[1]:
            return columns
    return None


def _course(columns: Floats, readings: Floats) -> Floats:
    """Return what readings (n, n_gauges) change by these columns (n, k), by least squares."""
    found = np.zeros_like(readings)
    design = np.column_stack([np.ones(len(columns)), columns])
    for gauge in range(readings.shape[1]):
        seen = np.isfinite(readings[:, gauge])
        if seen.sum() >= design.shape[1]:
            coefficients = np.linalg.lstsq(design[seen], readings[seen, gauge], rcond=None)[0]
            found[:, gauge] = columns @ coefficients[1:]
    return found
