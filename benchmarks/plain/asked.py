"""What a plain rival has: means of a campaign, what the twin and effects make of them, and the noise."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from octmip.gap import Addition, AugmentedTwin, Campaign
from octmip.gap.doors.built import as_built
from octmip.gap.effects import in_chain
from octmip.gap.preparation import library_of
from octmip.gap.twins import CachedTwin
from octmip.twin import Effect, Twin

BARE, LEFT, CONSTANTS = 0.05, 0.003, 0.08
"""Sd of what twin and asset differ by, over a typical reading, without a run and beside one; of a constant."""
Member = tuple[Effect, str]


@dataclass(frozen=True, eq=False)
class Asked:
    """Means (n_cells, n_gauges) with their variance, typical readings (n_gauges,), and the twin as it was built."""

    campaign: Campaign
    twin: CachedTwin
    mean: FloatArray
    variance: FloatArray
    typical: FloatArray
    difference: FloatArray

    @classmethod
    def of(cls, campaign: Campaign, twin: Twin, run: Campaign | None) -> "Asked":
        """Return what there is: what the run reads more than the twin at each load, and means with their noise."""
        sound = twin if isinstance(twin, CachedTwin) else CachedTwin(twin)
        sound = sound if run is None else as_built(sound, run, CONSTANTS)
        mean, count = (np.array([getattr(cell, what) for cell in campaign.cells]) for what in ("mean", "count"))
        zero = np.zeros_like(mean)
        bare = cls(campaign, sound, zero, zero, zero[0], zero).reading((), ())
        typical = np.maximum(np.sqrt(np.mean(bare**2, axis=0)), 0.01 * np.sqrt(np.mean(bare**2)))
        of_load = (
            {} if run is None else {c.load: c.mean[[run.gauges.index(g) for g in campaign.gauges]] for c in run.cells}
        )
        difference = np.nan_to_num(
            [of_load.get(c.load, own) - own for c, own in zip(campaign.cells, bare, strict=True)]
        )
        is_run = np.array([c.load in of_load for c in campaign.cells])[:, None]
        variance = (
            _noise(campaign) * (1.0 + is_run) / np.maximum(count, 1) + (np.where(is_run, LEFT, BARE) * typical) ** 2
        )
        variance = np.where(count > 0, variance, 1e12 * typical**2)
        return cls(campaign, sound, np.where(count > 0, np.nan_to_num(mean), 0.0), variance, typical, difference)

    @property
    def members(self) -> list[Member]:
        """Every effect of the library that has a name, at every place."""
        library = [e for e in library_of(self.twin, self.campaign).values() if not getattr(e, "is_nameless", False)]
        return [(effect, place) for effect in library for place in effect.places(self.twin)]

    def reading(self, members: Sequence[Member], sizes: Sequence[float] | FloatArray) -> FloatArray:
        """Return the readings (n_cells, n_gauges) with effects of these sizes; unknown states are sound."""
        parts = [Addition(e, place, float(size)) for (e, place), size in zip(members, sizes, strict=True)]
        parts.sort(key=lambda part: in_chain(part.effect))  # the structure first, the chain last
        whole = AugmentedTwin(self.twin, tuple(parts))
        order = [self.twin.gauges.index(name) for name in self.campaign.gauges]
        rows = []
        for cell in self.campaign.cells:
            state = dict(zip(self.campaign.parameters, np.nan_to_num(cell.state).tolist(), strict=True))
            rows.append(whole.predict(state, cell.load, cell.time)[order])
        return np.array(rows) + self.difference


def _noise(campaign: Campaign) -> FloatArray:
    """Return the variance (n_gauges,) of one reading, grown by how alike neighbours in time are."""
    rests = [campaign.readings[cell.rows] - cell.mean for cell in campaign.cells if len(cell.rows) > 1]
    free = np.sum([np.isfinite(rest).sum(axis=0) - 1 for rest in rests], axis=0)
    variance = np.sum([np.nansum(rest**2, axis=0) for rest in rests], axis=0) / np.maximum(free, 1)
    alike = np.sum([np.nansum(rest[1:] * rest[:-1], axis=0) for rest in rests], axis=0)
    rho = float(np.clip(np.mean(alike / np.maximum(variance * free, 1e-300)), 0.0, 0.9))
    grown = (1.0 + rho) / (1.0 - rho) if rho > 2.0 / np.sqrt(free.sum()) else 1.0
    return np.asarray(grown * np.maximum(variance, 1e-12 * variance.max()))
