"""What a campaign says before any effect: residuals (n_gauges, n_cells), their covariance gauge by gauge, nuisances.

Asset and twin differ by a Gaussian process in each gauge: a constant, a part proportional to the twin's reading, one to
its square, and one free for each load and state. Run and campaign share it, so that it cancels in cells of one load.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from octmip.gap import Campaign
from octmip.gap.twins import CachedTwin
from octmip.twin import Load, state_limits_of, units_of

LEARNT, BARE = (1.0, 1.0, 0.3, 0.5), (0.003, 0.01, 0.003, 0.003)
"""Constant, proportional, square and free part of the difference, over its level in a run or over the readings."""
COMMON = 0.01
"""Sd of a factor that all gauges share, without a run."""
OF_CHANGE = (0.08, 0.05)
"""Error of what a damage changes: as a whole, and at each gauge by itself."""
STATE_SD, STEP, MOST = 0.3, 0.02, 0.95
"""Prior sd of an unknown state, step of its tangents, and up to which share of its limit it is looked for."""
WIDTHS = (0.5, 0.125, 0.03)
"""Half widths of the grids of states, over the limit of a state."""
OUT = 1e12
"""Variance over the square of the typical reading where nothing was recorded."""


@dataclass(eq=False)
class Readings:
    """The campaign as a linear model takes it: arrays by gauge and cell; nuisances in units of their prior sd."""

    twin: CachedTwin
    campaign: Campaign
    states: FloatArray
    expected: FloatArray
    residual: FloatArray
    covariance: FloatArray
    nuisances: FloatArray
    typical: FloatArray

    @property
    def loads(self) -> tuple[Load, ...]:
        """Load of each cell."""
        return tuple(cell.load for cell in self.campaign.cells)

    @property
    def order(self) -> list[int]:
        """Place of each gauge of the campaign among the twin's."""
        return [self.twin.gauges.index(name) for name in self.campaign.gauges]

    def predicted(self, states: FloatArray) -> FloatArray:
        """Return the twin's readings in these states (n_cells, n_parameters)."""
        asked = zip(states, self.loads, strict=True)
        return np.array([self.twin.predict_states(state[None], load)[0] for state, load in asked])[:, self.order].T


def readings_of(campaign: Campaign, twin: CachedTwin, run: Campaign | None, noise_sd: float | None = None) -> Readings:
    """Return the residuals of a campaign, conditioned on a commissioning run where there is one."""
    parts = [_means(c, twin, campaign.gauges) for c in (campaign, *([run] if run else []))]
    mean, count, twins = (np.concatenate([part[k] for part in parts], axis=1) for k in range(3))
    n, units = len(campaign.cells), np.array(units_of(twin))[[twin.gauges.index(name) for name in campaign.gauges]]
    rms = np.sqrt(np.mean(twins**2, axis=1))
    typical = np.array([max(r, 0.01 * rms[units == u].max(), 1e-12) for r, u in zip(rms, units, strict=True)])
    noise = np.full(len(units), noise_sd**2) if noise_sd else _noise([campaign, *([run] if run else [])])
    out = OUT * typical[:, None] ** 2
    variance = np.where(count > 0, np.minimum(noise[:, None] / np.maximum(count, 1), out), out)
    rest = np.where(count > 0, np.nan_to_num(mean) - twins, 0.0)
    share = np.array(LEARNT if run else BARE)
    level = _levels(rest[:, n:], variance[:, n:], typical, units) if run else typical
    keys = [(cell.load, cell.state.tobytes()) for c in (campaign, *([run] if run else [])) for cell in c.cells]
    same = np.array([[a == b for b in keys] for a in keys], dtype=float)
    bent = [np.ones_like(twins), twins / typical[:, None], twins * np.abs(twins) / typical[:, None] ** 2]
    kernel = sum(s**2 * b[:, :, None] * b[:, None, :] for s, b in zip(share, bent, strict=False)) + share[3] ** 2 * same
    kernel = level[:, None, None] ** 2 * kernel + variance[:, :, None] * np.eye(len(keys))
    gain = np.linalg.solve(kernel[:, n:, n:], kernel[:, n:, :n]).transpose(0, 2, 1)
    shift = np.einsum("gab,gb->ga", gain, rest[:, n:])
    states = np.nan_to_num([cell.state for cell in campaign.cells])
    common = np.zeros((0, *shift.shape)) if run else COMMON * twins[None, :, :n]
    block = kernel[:, :n, :n] - gain @ kernel[:, n:, :n]
    return Readings(twin, campaign, states, twins[:, :n] + shift, rest[:, :n] - shift, block, common, typical)


def _means(campaign: Campaign, twin: CachedTwin, gauges: tuple[str, ...]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return means, counts and the twin's readings (n_gauges, n_cells); an unknown state is taken as 0."""
    own, order = [campaign.gauges.index(name) for name in gauges], [twin.gauges.index(name) for name in gauges]
    rows = [twin.predict_states(np.nan_to_num(cell.state)[None], cell.load)[0] for cell in campaign.cells]
    read = [np.array([getattr(cell, what) for cell in campaign.cells])[:, own].T for what in ("mean", "count")]
    return read[0], read[1], np.array(rows)[:, order].T


def _noise(campaigns: list[Campaign]) -> FloatArray:
    """Return the variance (n_gauges,) of one reading, grown by how alike neighbours in time are; inf if it is stuck."""
    gauges = campaigns[0].gauges
    columns = [[c.gauges.index(name) for name in gauges] for c in campaigns]
    pairs = [(c, at, cell) for c, at in zip(campaigns, columns, strict=True) for cell in c.cells if len(cell.rows) > 1]
    rests = [(c.readings[cell.rows] - cell.mean)[:, at] for c, at, cell in pairs]
    free = np.sum([np.isfinite(rest).sum(axis=0) - 1 for rest in rests], axis=0)
    variance = np.sum([np.nansum(rest**2, axis=0) for rest in rests], axis=0) / np.maximum(free, 1)
    alike = np.sum([np.nansum(rest[1:] * rest[:-1], axis=0) for rest in rests], axis=0)
    rho = float(np.clip(alike.sum() / max(float((variance * free).sum()), 1e-300), 0.0, 0.9))
    grown = (1.0 + rho) / (1.0 - rho) if rho > 2.0 / np.sqrt(free.sum()) else 1.0
    return np.where(variance > 0.0, grown * variance, np.inf)


def _levels(rest: FloatArray, variance: FloatArray, typical: FloatArray, units: FloatArray) -> FloatArray:
    """Return how far each gauge of the run is off: its own rms, at least half of the median of its unit."""
    own = np.sqrt(np.mean(rest**2, axis=1)) / typical
    usual = np.array([np.median(own[units == unit]) for unit in units])
    return np.asarray(typical * np.maximum(own, 0.5 * usual) + np.sqrt(np.min(variance, axis=1)))


def with_states(read: Readings, columns: FloatArray, sd: FloatArray) -> Readings:
    """Return the readings with unknown states as they fit best beside any one of the columns, and tangents about them.

    A nine-by-nine grid is laid over all states of a test, then twice over a part of it, four times finer each time.
    """
    cells, limits = read.campaign.cells, MOST * np.array(state_limits_of(read.twin))
    unknown = {cell.test: ~np.isfinite(cell.state) & (limits > 0.0) for cell in cells if not cell.is_known}
    at = {cell.test: np.array([other.test == cell.test for other in cells]) for cell in cells}
    root = np.linalg.inv(np.linalg.cholesky(read.covariance))
    white = (root @ (columns * sd[:, None, None])[..., None]).reshape(len(columns), -1)
    length, healthy, base = (
        1.0 + np.sum(white**2, axis=1),
        read.predicted(0.0 * read.states),
        read.predicted(read.states),
    )
    states = read.states.copy()
    for test, is_open in unknown.items():
        states[np.ix_(at[test], is_open)] = 0.5 * limits[is_open]

    def score(asked: FloatArray) -> float:
        rest = (root @ (read.residual + base - read.predicted(asked))[..., None]).ravel()
        gain = 0.5 * (white @ rest) ** 2 / length - 0.5 * np.log(length) - np.log(len(length))
        return float(max(0.0, np.max(gain)) - 0.5 * rest @ rest)

    for width in WIDTHS:
        for test, is_open in unknown.items():
            axes = [np.unique(np.clip(s + np.linspace(-width, width, 9) * limit, 0.0, limit)) if o else [s]
                    for s, limit, o in zip(states[at[test]][0], limits, is_open, strict=True)]  # fmt: skip
            grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(limits))
            for load in {cell.load for cell in cells if cell.test == test}:
                read.twin.predict_states(grid, load)  # all at once: they are kept
            states = max((np.where(at[test][:, None], point, states) for point in grid), key=score)
    change, found = read.predicted(states) - healthy, [*read.nuisances]
    for test, rows in at.items():
        found += [OF_CHANGE[0] * change * rows] * bool(np.any(change * rows))
        for k in np.flatnonzero(unknown.get(test, np.zeros(len(limits), dtype=bool))):
            step = np.where(states[:, k] > 0.5 * limits[k], -STEP, STEP)
            moved = states + (step * rows)[:, None] * np.eye(len(limits))[k]
            found.append(STATE_SD * (read.predicted(moved) - read.predicted(states)) / step)
    own = OF_CHANGE[1] * change
    read.covariance = read.covariance + own[:, :, None] * own[:, None, :]
    moved_by = read.predicted(states) - base
    read.residual, read.expected = read.residual - moved_by, read.expected + moved_by
    read.states, read.nuisances = states, np.array(found).reshape(-1, *own.shape)
    return read
