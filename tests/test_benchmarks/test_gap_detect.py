"""The table of what damage hides, on a coarse mesh."""

import pytest

from benchmarks.cases.gap import detect as gap_detect


@pytest.fixture(scope="module")
def lines():
    return list(gap_detect.detected(0.4))


def test_scales_are_exactly_tied_in_every_set_up(lines):
    for line in lines:
        for name in ("modulus", "load_factor_error", "common_gain"):
            assert line["effects"][name][2] == pytest.approx(0.0, abs=0.2)


def test_unknown_damage_hides_and_a_commissioning_run_uncovers(lines):
    sound, bare, hidden = lines[0]["effects"], lines[1]["effects"], lines[2]["effects"]
    for name in ("modulus", "skin_thickness", "lift_distribution", "payload_inertia"):
        assert hidden[name][0] < sound[name][0]
        assert bare[name][0] < sound[name][0]
    assert bare["modulus"][0] < 3.0 < sound["modulus"][0]
    assert sound["root_flexibility"][0] == pytest.approx(0.0, abs=1e-3)


def test_the_table_has_a_row_for_every_effect(lines):
    table = gap_detect.summary(lines).splitlines()
    assert len(table) == 2 + len(lines[0]["effects"])
    assert "| modulus |" in gap_detect.summary(lines)
