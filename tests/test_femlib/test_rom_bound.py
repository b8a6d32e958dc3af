"""The error bound of the reduced model on two regions of one measure each, where the error is known by hand."""

import numpy as np
import pytest

from femlib.rom.bound import SAFETY, ErrorBound, couplings

OWN, ACROSS = 0.3, 0.3
NO_MODES = np.zeros(0, dtype=np.int64)


def two_regions() -> ErrorBound:
    """Return the bound of S = 1 / mu - H without modes: residuals are the load and the output themselves, both 1."""
    own, across = np.full(2, OWN), np.array([[0.0, ACROSS], [ACROSS, 0.0]])
    joint, pairs = couplings(own, across, np.array([0, 1, 2]))
    ones = (np.ones((1, 1)), np.ones((1, 1)))
    return ErrorBound(ones, ones, own, joint, pairs)


def bound_of(damage: float, left: float = 0.0) -> float:
    nothing = np.zeros(0)
    found = two_regions().bound(np.full(2, damage), NO_MODES, NO_MODES, nothing, np.zeros((0, 1)), np.array([left]))
    return float(found[0])


@pytest.mark.parametrize("damage", [0.5, 0.8, 0.95])
def test_the_bound_by_couplings_holds_and_is_sharp_where_regions_move_alike(damage: float) -> None:
    error = 2.0 / (1.0 / damage - OWN - ACROSS)
    assert error <= bound_of(damage) <= error * (1.0 + 10.0 * SAFETY)


def test_beyond_the_last_level_the_plain_bound_and_what_the_dual_leaves_count_together() -> None:
    damage = 0.99
    plain = 2.0 * damage / (1.0 - damage)
    assert 2.0 / (1.0 / damage - OWN - ACROSS) <= plain
    for left in (10.0, -10.0):
        assert bound_of(damage, left) == pytest.approx(10.0 + plain)
