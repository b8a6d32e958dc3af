"""What the wing bears in every state of a mission, from femlib's capability, as a table that missions look up.

The gauges' strains come from `uav_wing`, which reads the published ones best, or from the published table itself;
strength comes from `built_wing`, which one would build (docs/wing.md). Both have the same regions by name.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from benchmarks.uav.mission.table_twin import between
from femlib.wing import reduce_wing
from femlib.wing.built import CLOSE, built_wing, close_wing
from femlib.wing.strength import wing_capability
from femlib.wing.structure import CARBON_LENGTH

Floats = NDArray[np.float64]

STEP, MOST = 0.02, 0.9
"""Step of the table in each damage, and its end."""
REFINEMENT = 0.5
"""Of the mesh, whose factors finer ones of each region correct."""
GUST = 0.04
"""Standard deviation of a manoeuvre's greatest load factor over the one flown: turns and gusts vary. Assumed."""


@dataclass(frozen=True, slots=True, eq=False)
class Capable:
    """The greatest load factors of a mission's states: `both` (n, n) [g] over mu1 and mu2 in steps of STEP."""

    both: Floats

    def bears(self, damage: Floats) -> Floats:
        """Return the load factors (n,) that damages (n, 2) leave."""
        return between(self.both[..., None], damage / STEP)[:, 0]

    def fails(self, damage: Floats, load: Floats | float) -> Floats:
        """Return the probability (n,) that a manoeuvre at a load factor asks for more than a wing bears."""
        return chance_of_failing(self.bears(damage), load)


def chance_of_failing(bears: Floats, load: Floats | float) -> Floats:
    """Return P(load (1 + GUST z) > bears) of a standard normal z."""
    return np.asarray(ndtr((1.0 - bears / load) / GUST))


def capable_wing(folder: Path, *, is_coarse: bool = False) -> Capable:
    """Return the table, kept in `folder` for the same meshes; `is_coarse`: that of one mesh without close lines."""
    wing = built_wing(refinement=REFINEMENT, edge_step=0.0 if is_coarse else 3.0 * CARBON_LENGTH)
    path = folder / f"capability-{wing.model_hash[:12]}{'' if is_coarse else f'-{CLOSE:g}'}.npz"
    if path.exists():
        with np.load(path) as kept:
            return Capable(kept["both"])
    capability = wing_capability(wing, reduce_wing(wing), finer=None if is_coarse else close_wing)
    levels = np.linspace(0.0, MOST, round(MOST / STEP) + 1)
    states = np.stack(np.meshgrid(levels, levels, indexing="ij"), axis=-1).reshape(-1, 2)
    both = capability.load_factors(states).reshape(len(levels), -1)
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(path, both=both, error=capability.error, mesh_error=capability.mesh_error)
    return Capable(both)
