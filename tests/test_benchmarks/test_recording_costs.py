"""The benchmark of recordings, on small ones."""

import pytest

from benchmarks.cases.doors.recordings import measured


@pytest.mark.long("DataFlash")
@pytest.mark.parametrize("form", ["DataFlash", "rosbag"])
def test_a_recording_is_measured_to_its_diagnosis(form):
    pytest.importorskip({"DataFlash": "pymavlink", "rosbag": "rosbags"}[form])
    line = measured(form, 5_000)
    assert line["verdict"].startswith("Gain g2 is 1.2")
    assert 0.0 < line["cpu_seconds"] < 600.0
    assert 50 < line["megabytes"] < 2000
