"""The benchmark of sound assets by kind of noise."""

from benchmarks.cases.gap import noise as gap_noise


def test_every_kind_of_noise_is_drawn_and_one_line_holds_its_figures():
    assert all(gap_noise.drawn(kind, 0).readings.shape == (200, gap_noise.N_GAUGES) for kind in gap_noise.KINDS)
    line = gap_noise.alarms("white", 2)
    assert line["alarms"] == 0.0
    assert "| white | 0.00 |" in gap_noise.summary([line])
