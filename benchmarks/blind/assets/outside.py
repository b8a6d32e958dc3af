"""Changes that no library holds; three kinds belong to a family."""

from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.blind.assets.asset import HOUR, Asset, Flaw
from benchmarks.blind.assets.moment import Moment
from benchmarks.blind.truths import Truth
from femlib.arrays import FloatArray

Change = Callable[[Truth, Asset, Moment, FloatArray], FloatArray]
"""Change of the mean readings (n_times, n_gauges) of an asset at a moment by a truth."""
SUNSHINE = 1200.0
"""Half a period of the sun [s]: four loads of 50 readings."""
CRITICAL = 1.2
"""Load factor at which a panel buckles."""
BUCKLED = (0.3, 0.7)
"""Shares of a panel's stiffness for which its loss is solved; between and beyond them it is interpolated."""
SLIPS = 0.8
"""Load factor from which a slack joint slips."""


def _dice(truth: Truth) -> np.random.Generator:
    return np.random.default_rng(truth.extra["seed"])


def _buckled_panel(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return what a buckled panel of the upper skin no longer carries: its width counts by 1 / sqrt(load).

    Source: von Karman, Sechler & Donnell (1932), The strength of thin plates in compression, Trans. ASME 54.
    """
    place = f"{_dice(truth).choice([0.31, 0.40, 0.50, 0.60, 0.69])}:0.500:0.050"
    lost = 1.0 - np.exp(-abs(truth.size) * (1.0 - np.sqrt(CRITICAL / max(moment.load, CRITICAL))))
    less, more = (asset.flaw(Flaw("damage_outside_library", place, 100.0 * share)) / share for share in BUCKLED)
    slope = (more - less) / (BUCKLED[1] - BUCKLED[0])
    return np.asarray(moment.load * lost * (less + slope * (lost - BUCKLED[0])))


def _tip_cable(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return the strains of a cable that pulls at the tip whatever the load."""
    return truth.size * asset.field("tip_cable", moment.state)


def _moist_skin(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return the strains of an upper skin that swells by water, most at the tip, with the square root of time."""
    return truth.size * np.sqrt(moment.times / HOUR)[:, None] * asset.field("moist_skin", moment.state)


def _loose_rib(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return the strains of a rib that has come off in part."""
    place = _dice(truth).choice(["0.3", "0.4"])
    share = abs(truth.size) / (1.0 + abs(truth.size))
    return share * moment.load * asset.field(f"loose_rib:{place}", moment.state)


def _slack_joint(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return the strains of a joint that slips once the load is large enough."""
    return 0.5 * abs(truth.size) * max(0.0, moment.load - SLIPS) * asset.field("slack_joint", moment.state)


def _lead_wires(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return the apparent strains of long lead wires that warm up and cool down."""
    course = np.sin(2.0 * np.pi * moment.times[:, None] / SUNSHINE)
    return np.asarray(25.0 * truth.size * course * asset.eta**2)


def _other_wing(truth: Truth, asset: Asset, moment: Moment, before: FloatArray) -> FloatArray:
    """Return what another wing of the same drawing strains more: a share in common, as much again per gauge."""
    dice = _dice(truth)
    return np.asarray(before * truth.size * (dice.choice([-1.0, 1.0]) + dice.standard_normal(before.shape[1])))


OUTSIDE: Mapping[str, Change] = {
    "other_wing": _other_wing, "loose_rib": _loose_rib, "slack_joint": _slack_joint, "lead_wires": _lead_wires,
    "buckled_panel": _buckled_panel, "tip_cable": _tip_cable, "moist_skin": _moist_skin,
}  # fmt: skip
