"""Scene: campaign, twin and library laid out as one linear Gaussian problem about one assignment of states.

    y = f(z) + phi d + S theta + J dz + e_damage + eps

stacked over blocks (a cell, or half a cell where time matters) and gauges. Everything but theta is Gaussian with
known covariance C0 = V/N + phi K phi' + damage nugget + J D J', so all that hypotheses need is the whitened library's
Gram matrix:

    G = S' C0^-1 S,    b = S' C0^-1 r,    log p0 = -(r' C0^-1 r + log det 2 pi C0) / 2.

Source: Woodbury's identity applied to C0 + S P S'; Rasmussen and Williams (2006), "Gaussian Processes for Machine
Learning", eq. 2.43 (basis functions with Gaussian weights).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.noise import Noise
from octmip.gap.inference.candidates import Column, Priors
from octmip.gap.inference.discrepancy import Discrepancy
from octmip.gap.twins.cached import Memory
from octmip.twin import Effect, State

Floats = NDArray[np.float64]

OPEN_STATE = 0.5
"""Sd of an unknown damage about its point of linearisation: wide, so that the readings decide."""
STEP = 0.01
"""Step of the damage tangents."""
LATTICE = 0.2
"""Signatures of structural effects are taken at the nearest state of this lattice: they change slowly with damage."""
OWN_STATE = 0.7
"""Share of the damage nugget's sd that is common to all states of one gauge; the rest is each state's own."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Repeats that are averaged together.

    Attributes:
        cell: index of the campaign's cell.
        mean, count: (n_gauges,) of these repeats.
        time: mean time [s].
    """

    cell: int
    mean: Floats
    count: NDArray[np.int64]
    time: float


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """What does not depend on the states: the campaign in blocks, the noise, the discrepancy, the library.

    Attributes:
        campaign, memory, noise, discrepancy, columns: as named.
        blocks: averaged repeats.
        order: position in the twin's gauges of each of the campaign's.
        reference: load factor of the greatest healthy strain.
        groups: cells that share one unknown state, each a tuple of cell indices.
        priors: of the columns.
    """

    campaign: Campaign
    memory: Memory
    noise: Noise
    discrepancy: Discrepancy
    columns: tuple[Column, ...]
    blocks: tuple[Block, ...]
    order: tuple[int, ...]
    reference: float
    groups: tuple[tuple[int, ...], ...]
    priors: Priors

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the state parameters."""
        return self.memory.parameters

    def places(self) -> list[tuple[Effect, tuple[str, ...]]]:
        """Return every effect with its places, in the order of `columns`."""
        grouped = [list(group) for _, group in groupby(self.columns, key=lambda column: column.name)]
        return [(group[0].effect, tuple(column.variant for column in group)) for group in grouped]

    def cell_of(self, block: Block) -> Cell:
        """Return the cell of a block."""
        return self.campaign.cells[block.cell]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """The linear Gaussian problem about one assignment of states.

    Attributes:
        setting: what it was made of.
        states: (n_cells, n_parameters), all known.
        block, gauge: (n,) indices of every entry of the stacked vectors.
        predicted: (n,) twin and discrepancy.
        residual: (n,) readings less `predicted`.
        covariance: (n, n) C0.
        factor: (n, n) lower Cholesky factor of C0.
        signatures: (n, n_columns) S.
        white: (n, n_columns) factor^-1 S.
        white_residual: (n,).
        lengths: (n_columns,) diagonal of G.
        pull: (n_columns,) b.
        log_none: log p0.
        tangents: (n, n_open) J of all groups' parameters.
        lean: (n_open, n_columns) how far the open states move per unit of each column's size, sign turned.
        lean_residual: (n_open,) how far they move when no column acts.
        open_covariance: (n_open, n_open) of the open states when no column acts.
        fitted: what `evidence.fit` has found here, by members.
        errors, shaped, allowed: what `shape_error` has found here, by column and by members.
        clear: the members that `causes` has left of a set.
    """

    setting: Setting
    states: Floats
    block: NDArray[np.int64]
    gauge: NDArray[np.int64]
    predicted: Floats
    residual: Floats
    covariance: Floats
    factor: Floats
    signatures: Floats
    white: Floats
    white_residual: Floats
    lengths: Floats
    pull: Floats
    log_none: float
    tangents: Floats
    lean: Floats
    lean_residual: Floats
    open_covariance: Floats
    fitted: dict[tuple[int, ...], Any] = field(init=False, repr=False, default_factory=dict)
    errors: dict[int, tuple[Floats, float]] = field(init=False, repr=False, default_factory=dict)
    shaped: dict[tuple[int, ...], Any] = field(init=False, repr=False, default_factory=dict)
    allowed: dict[tuple[int, ...], "Scene"] = field(init=False, repr=False, default_factory=dict)
    clear: dict[tuple[int, ...], tuple[int, ...]] = field(init=False, repr=False, default_factory=dict)

    @property
    def n(self) -> int:
        """Number of averaged readings."""
        return len(self.residual)

    @property
    def gram(self) -> Floats:
        """The whole of G (n_columns, n_columns): dear, `products` gives the rows that are needed."""
        return self.products(range(self.white.shape[1]))

    def products(self, members: Sequence[int]) -> Floats:
        """Return the rows (n_members, n_columns) of G."""
        return np.asarray(self.white[:, list(members)].T @ self.white)

    def whitened(self, columns: Floats) -> Floats:
        """Return factor^-1 columns."""
        return np.asarray(linalg.solve_triangular(self.factor, columns, lower=True, check_finite=False))

    def shift(self, members: Sequence[int], size: Floats) -> Floats:
        """Return how far the open states move (n_open,) when the columns `members` have these sizes."""
        return np.asarray(self.lean_residual - self.lean[:, list(members)] @ size)


def blocks_of(campaign: Campaign, split: bool) -> tuple[Block, ...]:
    """Return the blocks: whole cells, or the earlier and later half of each where `split` and time was recorded."""
    found = []
    start = float(np.nanmin(campaign.time)) if np.isfinite(campaign.time).any() else 0.0
    for k, cell in enumerate(campaign.cells):
        halves = [cell.rows]
        if split and campaign.has_time and len(cell.rows) >= 16:
            rows = cell.rows[np.argsort(campaign.time[cell.rows], kind="stable")]
            halves = [rows[: len(rows) // 2], rows[len(rows) // 2 :]]
        for rows in halves:
            readings = campaign.readings[rows]
            count = np.isfinite(readings).sum(axis=0)
            mean = np.where(count > 0, np.nansum(readings, axis=0) / np.maximum(count, 1), np.nan)
            time = float(np.nanmean(campaign.time[rows])) - start if campaign.has_time else cell.time
            found.append(Block(k, mean, count, time))
    return tuple(found)


def build_scene(setting: Setting, states: Floats) -> Scene:
    """Lay out the problem about states (n_cells, n_parameters)."""
    g = len(setting.order)
    blocks = setting.blocks
    _ask_together(setting, states)
    seen = np.array([b.count > 0 for b in blocks])
    block, gauge = (index.astype(np.int64) for index in np.nonzero(seen))
    flat = block * g + gauge
    y = np.array([b.mean for b in blocks]).ravel()[flat]
    strain, healthy = _predictions(setting, states)
    phi = np.array([setting.discrepancy.share(h, _reference(setting)) for h in healthy])
    expected = strain + phi[:, None] * setting.discrepancy.mean
    predicted = expected.ravel()[flat]
    covariance = _noise(setting, block, gauge)
    covariance += np.outer(phi[block], phi[block]) * setting.discrepancy.covariance[np.ix_(gauge, gauge)]
    covariance += _damage_nugget(setting, strain - healthy, block, gauge, states)
    tangents = _tangents(setting, states, flat)
    covariance += OPEN_STATE**2 * tangents @ tangents.T
    factor = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
    signatures = _signatures(setting, states, expected)[:, flat].T
    n_open = tangents.shape[1]
    stacked = np.column_stack([signatures, y - predicted, OPEN_STATE**2 * tangents])
    stacked = linalg.solve_triangular(factor, stacked, lower=True, overwrite_b=True, check_finite=False)
    white, residual, open_ = np.split(stacked, [signatures.shape[1], signatures.shape[1] + 1], axis=1)
    residual = residual[:, 0]
    log_none = (
        -0.5 * float(residual @ residual) - float(np.log(np.diag(factor)).sum()) - 0.5 * len(y) * np.log(2 * np.pi)
    )
    return Scene(
        setting, states, block, gauge, predicted, y - predicted, covariance, factor, signatures, white, residual,
        np.einsum("ij,ij->j", white, white), white.T @ residual, log_none, tangents,
        open_.T @ white, open_.T @ residual, OPEN_STATE**2 * np.eye(n_open) - open_.T @ open_,
    )  # fmt: skip


def _ask_together(setting: Setting, states: Floats) -> None:
    """Ask the twin once for open states and their tangents' ends: a batch costs little more than one state."""
    for group in setting.groups:
        state = states[group[0]]
        ahead = state + STEP * np.eye(len(state))
        for load in sorted({setting.campaign.cells[k].load_factor for k in group}):
            setting.memory.predict_states(np.vstack([state, ahead]), load)


def named_state(setting: Setting, row: Floats) -> dict[str, float]:
    """Return a state row as a mapping."""
    return dict(zip(setting.names, row.tolist(), strict=True))


def _reference(setting: Setting) -> Floats:
    return setting.memory.predict({}, setting.reference)[list(setting.order)]


def _predictions(setting: Setting, states: Floats) -> tuple[Floats, Floats]:
    """Return the twin's strains (n_blocks, n_gauges) in the given states and in the healthy state."""
    order = list(setting.order)
    cells = setting.campaign.cells
    now = [
        setting.memory.predict(named_state(setting, states[b.cell]), cells[b.cell].load_factor) for b in setting.blocks
    ]
    healthy = [setting.memory.predict({}, cells[b.cell].load_factor) for b in setting.blocks]
    return np.array(now)[:, order], np.array(healthy)[:, order]


def _noise(setting: Setting, block: NDArray[np.int64], gauge: NDArray[np.int64]) -> Floats:
    covariance = np.zeros((len(block), len(block)))
    for k, part in enumerate(setting.blocks):
        here = np.flatnonzero(block == k)
        of_mean = setting.noise.of_mean(part.count, setting.cell_of(part).load_factor)
        covariance[np.ix_(here, here)] = of_mean[np.ix_(gauge[here], gauge[here])]
    return covariance


def _damage_nugget(
    setting: Setting, change: Floats, block: NDArray[np.int64], gauge: NDArray[np.int64], states: Floats
) -> Floats:
    """Return the covariance of the twin's error in what damage changes: a factor a gauge, partly each state's own."""
    sd = setting.discrepancy.damage * change[block, gauge]
    cell = np.array([b.cell for b in setting.blocks])[block]
    same_state = (states[cell][:, None, :] == states[cell][None, :, :]).all(axis=2)
    shared = OWN_STATE**2 + (1.0 - OWN_STATE**2) * same_state
    return np.asarray(np.outer(sd, sd) * (gauge[:, None] == gauge[None, :]) * shared)


def _tangents(setting: Setting, states: Floats, flat: NDArray[np.int64]) -> Floats:
    order = list(setting.order)
    columns = []
    for group in setting.groups:
        for p in range(len(setting.names)):
            rows = np.zeros((len(setting.blocks), len(order)))
            for k, part in enumerate(setting.blocks):
                if part.cell in group:
                    rows[k] = _tangent(setting, states[part.cell], p, setting.cell_of(part).load_factor)[order]
            columns.append(rows.ravel()[flat])
    return np.array(columns).reshape(len(columns), len(flat)).T


def _tangent(setting: Setting, state: Floats, parameter: int, load: float) -> Floats:
    ahead = state.copy()
    ahead[parameter] += STEP
    memory = setting.memory
    after = memory.predict(named_state(setting, ahead), load)
    return np.asarray((after - memory.predict(named_state(setting, state), load)) / STEP)


def _signatures(setting: Setting, states: Floats, expected: Floats) -> Floats:
    """Return the signatures (n_columns, n_blocks * n_gauges); `expected` (n_blocks, n_gauges) is what is read."""
    places = [np.round(np.clip(states[b.cell], 0.0, None) / LATTICE) * LATTICE for b in setting.blocks]
    open_cells = {cell for group in setting.groups for cell in group}
    history = load_steps(setting.campaign)
    columns = [np.zeros((0, expected.size))]
    for effect, variants in setting.places():
        rows: list[Floats] = []
        for k, (part, place) in enumerate(zip(setting.blocks, places, strict=True)):
            if getattr(effect, "acts_on_readings", False):
                same = k > 0 and setting.blocks[k - 1].cell == part.cell
                rows.append(rows[-1] if same else _facts(setting, effect, variants, expected[k]))
                continue
            state = named_state(setting, place if part.cell in open_cells else states[part.cell])
            load = setting.cell_of(part).load_factor
            steps = [(change, part.time - start) for change, start in history if start <= part.time]
            if not getattr(effect, "superposes", False) or not steps:
                steps = [(load, part.time)]
            rows.append(_summed(setting, effect, variants, state, steps))
        columns.append(np.array(rows).transpose(1, 0, 2).reshape(len(variants), -1))
    return np.concatenate(columns)


def _summed(
    setting: Setting, effect: Effect, places: tuple[str, ...], state: dict[str, float], steps: list[tuple[float, float]]
) -> Floats:
    """Return the sum (n_places, n_gauges) of the signatures for loads and times."""
    parts = [setting.memory.signatures(effect, places, state, load, time) for load, time in steps]
    return np.asarray(np.sum(parts, axis=0)[:, list(setting.order)])


def load_steps(campaign: Campaign) -> list[tuple[float, float]]:
    """Return each change of the load factor with its time [s] since the first reading; empty without times."""
    if not campaign.has_time:
        return []
    start = float(np.nanmin(campaign.time))
    begun = sorted((float(campaign.time[cell.rows].min()) - start, cell.load_factor) for cell in campaign.cells)
    loads = [0.0, *(load for _, load in begun)]
    return [(after - before, time) for (time, after), before in zip(begun, loads, strict=False)]


@dataclass(frozen=True, slots=True, eq=False)
class _Readings:
    """A twin that answers with given readings (n_gauges,) of the campaign's gauges."""

    gauges: tuple[str, ...]
    readings: Floats

    def predict(self, state: State, load_factor: float) -> Floats:
        """Return the readings."""
        return self.readings


def _facts(setting: Setting, effect: Effect, places: Sequence[str], readings: Floats) -> Floats:
    """Return what a fact at each place does to readings (n_gauges,), calibrated: the whole signal counts."""
    seen: Any = _Readings(setting.campaign.gauges, readings)
    return np.array([effect.signature(seen, {}, 1.0, variant=place) for place in places])


def carried(scene: Scene, column: int, fact: int) -> Floats:
    """Return what a fact does to a column's signature (n,): a dead gauge hides it, a swapped one shows the other's."""
    setting = scene.setting
    change = np.zeros((len(setting.blocks), len(setting.order)))
    change[scene.block, scene.gauge] = scene.signatures[:, column]
    chosen = setting.columns[fact]
    moved = np.array([_facts(setting, chosen.effect, (chosen.variant,), row)[0] for row in change])
    return np.asarray(moved[scene.block, scene.gauge])
