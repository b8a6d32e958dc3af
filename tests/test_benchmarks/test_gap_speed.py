"""The times of diagnoses, on a coarse wing: the lines and their table."""

import numpy as np

from benchmarks.cases.gap import speed as gap_speed


def test_every_campaign_can_be_made():
    twin = gap_speed.wing_twin(0.25)
    for seed, one in enumerate(gap_speed.CAMPAIGNS):
        assert np.isfinite(gap_speed.campaign(twin, one, seed).readings).all()
        assert not one.size or one.place in twin.effects[one.effect].places(twin)


def test_speed_lines_name_what_was_found_and_make_a_table():
    lines = list(gap_speed.measured(0.25, gap_speed.CAMPAIGNS[1:2], again=1))
    assert [line["state"] for line in lines] == ["known"]
    assert [line["found"] for line in lines] == ["temperature_gradient"]
    assert all(line["first_cpu_seconds"] > line["again_cpu_seconds"] > 0.0 for line in lines)
    assert "| known | temperature_gradient 6 | temperature_gradient |" in gap_speed.summary(lines)
