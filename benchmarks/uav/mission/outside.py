"""Damage in a third region: its signature at the gauges, from a wing that has that region as a component.

The 26 regions of femlib's damage library beyond the study's two are the truth; the watch's candidates are other zones,
with signatures to first order only. A third damage is added to the readings of the first two: within the library
damages add up to 0.2 microstrain in 3000 (published table).
"""

import numpy as np
from numpy.typing import NDArray

from femlib.wing import uav_wing
from femlib.wing.damage import UAV_REGIONS, damage_library

Floats = NDArray[np.float64]

EXAMPLE = "R7"
"""The region of the missions with damage outside the library: the top skin's nose beside region R1."""


def example_signature(gauges: tuple[str, ...]) -> Floats:
    """Return the signature (n_gauges,) of the example region per unit of load and of damage: at 60 %, over 0.6."""
    region = next(region for region in damage_library() if region.name == EXAMPLE)
    wing = uav_wing(regions=(*UAV_REGIONS, region))
    strains = wing.strains_microstrain(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.6]]), 1.0)
    columns = [wing.gauges.names.index(gauge) for gauge in gauges]
    return np.asarray((strains[1] - strains[0])[columns] / 0.6)
