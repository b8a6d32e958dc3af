"""What the wing bears in every state of a mission, from femlib's capability, as a table that missions look up.

The gauges' strains come from `uav_wing`, which reads the published ones best, or from the published table itself;
strength comes from `built_wing`, which one would build (docs/wing.md). Both have the same regions by name.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from femlib.wing import reduce_wing
from femlib.wing.built import BUILT_REGIONS, built_library, built_wing
from femlib.wing.strength import wing_capability
from femlib.wing.structure import CARBON_LENGTH

Floats = NDArray[np.float64]

THIRD = "R7"
"""The third region of missions with damage outside the library."""
STEP, MOST = 0.02, 0.9
"""Step of the table in each damage, and its end."""
REFINEMENT = 0.5
"""Of the mesh, which is closer at the regions' edges: what the wing bears is within 2 % of finer meshes'."""
GUST = 0.04
"""Standard deviation of a manoeuvre's greatest load factor over the one flown: turns and gusts vary. Assumed."""


@dataclass(frozen=True, slots=True, eq=False)
class Capable:
    """The greatest load factors of a mission's states.

    Attributes
    ----------
    both
        (n, n) [g] over mu1 and mu2 in steps of STEP.
    third
        (n,) [g] over the third region's damage alone.
    """

    both: Floats
    third: Floats

    def bears(self, damage: Floats) -> Floats:
        """Return the load factors (n,) that damages (n, 2 or 3) leave: the least of both tables."""
        n = len(self.third)
        place = np.clip(damage / STEP, 0.0, n - 1.0)
        low = np.minimum(place.astype(np.intp), n - 2)
        share = place - low
        (i, j), (a, b) = low.T[:2], share.T[:2]
        near = (1 - b) * self.both[i, j] + b * self.both[i, j + 1]
        found = (1 - a) * near + a * ((1 - b) * self.both[i + 1, j] + b * self.both[i + 1, j + 1])
        if damage.shape[1] == 3:
            k, c = low[:, 2], share[:, 2]
            found = np.minimum(found, (1 - c) * self.third[k] + c * self.third[k + 1])
        return np.asarray(found)

    def fails(self, damage: Floats, load: Floats | float) -> Floats:
        """Return the probability (n,) that a manoeuvre at a load factor asks for more than a wing bears."""
        return chance_of_failing(self.bears(damage), load)


def chance_of_failing(bears: Floats, load: Floats | float) -> Floats:
    """Return P(load (1 + GUST z) > bears) of a standard normal z."""
    return np.asarray(ndtr((1.0 - bears / load) / GUST))


def capable_wing(folder: Path) -> Capable:
    """Return the table, kept in `folder` for the same wing."""
    third = next(region for region in built_library() if region.name == THIRD)
    wing = built_wing(refinement=REFINEMENT, regions=(*BUILT_REGIONS, third), edge_step=CARBON_LENGTH)
    path = folder / f"capability-{wing.model_hash[:12]}.npz"
    if path.exists():
        with np.load(path) as kept:
            return Capable(kept["both"], kept["third"])
    capability = wing_capability(wing, reduce_wing(wing))
    levels = np.linspace(0.0, MOST, round(MOST / STEP) + 1)
    first, second = (axis.ravel() for axis in np.meshgrid(levels, levels, indexing="ij"))
    none = np.zeros_like(first)
    both = capability.load_factors(np.column_stack([first, second, none])).reshape(len(levels), -1)
    alone = capability.load_factors(np.column_stack([0.0 * levels, 0.0 * levels, levels]))
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(path, both=both, third=alone, error=capability.error)
    return Capable(both, alone)
