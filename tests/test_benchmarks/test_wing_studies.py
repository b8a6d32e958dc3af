"""Studies of the wing: how the uncertainty of a capability is drawn."""

import numpy as np
import pytest

from benchmarks.data import SHARED
from benchmarks.wing.envelope import N_DRAWS, drawn


@pytest.mark.skipif(not (SHARED / "uav").exists(), reason=f"{SHARED} is not there")
def test_drawn_capabilities_scatter_by_strength_and_modulus_where_each_counts():
    limits = np.array([[3.0, 9.0, 9.0], [9.0, 3.0, 9.0]])
    by_ply, by_buckling = np.log(drawn(limits)).T
    assert len(by_ply) == N_DRAWS
    assert by_ply.std() == pytest.approx(0.08, abs=0.004)
    assert by_buckling.std() == pytest.approx(0.0095, abs=0.002)
