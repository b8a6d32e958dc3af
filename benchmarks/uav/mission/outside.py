"""Damage in a third region: its signature at the gauges, from a wing that has that region as a component.

The 26 regions of femlib's damage library beyond the study's two are the truth; the watch's candidates are other zones,
with signatures to first order only. A third damage is added to the readings of the first two: within the library
damages add up to 0.2 microstrain in 3000 (published table).
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from femlib.wing import uav_wing
from femlib.wing.damage import UAV_REGIONS, damage_library

Floats = NDArray[np.float64]

EXAMPLE = "R7"
"""The region of the missions with damage outside the library: the top skin's nose beside region R1."""
SIZES = (0.4, 0.6)


def example_signature(gauges: tuple[str, ...]) -> Floats:
    """Return the signature (n_gauges,) of the example region per unit of load and of damage: at 60 %, over 0.6."""
    region = next(region for region in damage_library() if region.name == EXAMPLE)
    wing = uav_wing(regions=(*UAV_REGIONS, region))
    strains = wing.strains_microstrain(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.6]]), 1.0)
    columns = [wing.gauges.names.index(gauge) for gauge in gauges]
    return np.asarray((strains[1] - strains[0])[columns] / 0.6)


def all_signatures(folder: Path, gauges: tuple[str, ...]) -> dict[tuple[str, float], Floats]:
    """Return the signature (n_gauges,) of each of the 26 regions per unit of load, by region and damage.

    The wing with 28 components takes a minute and a half; its strains are kept in `folder`.
    """
    path = folder / "outside.npz"
    names = [region.name for region in damage_library()]
    if path.exists():
        with np.load(path) as kept:
            strains, known = kept["strains"], tuple(kept["gauges"].tolist())
    else:
        wing = uav_wing(regions=damage_library())
        states = np.vstack([np.zeros(len(names)), *(size * np.eye(len(names)) for size in SIZES)])
        strains, known = wing.strains_microstrain(states, 1.0), wing.gauges.names
        np.savez(path, strains=strains, gauges=np.array(known))
    columns = [known.index(gauge) for gauge in gauges]
    added = (strains[1:] - strains[0])[:, columns].reshape(len(SIZES), len(names), -1)
    return {
        (name, size): added[s, k]
        for s, size in enumerate(SIZES)
        for k, name in enumerate(names)
        if k >= len(UAV_REGIONS)
    }
