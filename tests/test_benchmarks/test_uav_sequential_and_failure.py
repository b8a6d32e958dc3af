"""The studies of sequential sensing and of failure run, and say what docs/sensing.md says of them."""

import re

import numpy as np
import pytest

from benchmarks.data import SHARED
from benchmarks.uav.sensing import failure, sequential
from benchmarks.uav.sensing.readings import readings

pytestmark = pytest.mark.skipif(not (SHARED / "uav").exists(), reason="the published table is not beside the project")


def test_a_reading_less_never_makes_fewer_errors(tmp_path):
    text = sequential.report("published", tmp_path, 1, True)
    errors = [int(cell) for cell in re.findall(r"\| mu2 +\| +2 \| price [\d.]+ +\| +(\d+)", text)]
    assert len(errors) == 3
    assert errors == sorted(errors)
    assert "decide mu2 = 80 %" in text
    assert "already read: free" in text


def test_detection_holds_its_rate_and_finds_a_dead_gauge():
    detector = failure.detector_of(readings("published", 0, True))
    rng = np.random.default_rng(0)
    assert detector.is_alarm(detector.draw(5000, rng)).mean() == pytest.approx(0.01, abs=0.006)
    assert failure._special(detector, "dead", 50, rng).min() == 1.0
