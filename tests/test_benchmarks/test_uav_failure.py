"""The study of failed gauges finds what docs/sensing.md says of them."""

import numpy as np
import pytest

from benchmarks.data import SHARED
from benchmarks.uav.sensing import failure
from benchmarks.uav.sensing.readings import readings

pytestmark = pytest.mark.skipif(not (SHARED / "uav").exists(), reason="the published table is not beside the project")


def test_detection_holds_its_rate_and_finds_a_dead_gauge():
    detector = failure.detector_of(readings("published", 0, True))
    rng = np.random.default_rng(0)
    assert detector.is_alarm(detector.draw(5000, rng)).mean() == pytest.approx(0.01, abs=0.006)
    assert failure._special(detector, "dead", 50, rng).min() == 1.0
