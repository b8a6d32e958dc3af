"""Time series reduced to readings by a stated rule, and a campaign made of blocks of rows."""

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import Recorded, function_twin, gathered
from octmip.gap.reductions.repeats import phase_means

TIME = np.arange(0.0, 12.0, 0.001)


def test_phase_means_are_the_means_of_every_cycle():
    found = phase_means(TIME, np.sin(np.pi * TIME), 2.0, 8)
    assert found.shape == (6, 8)
    edges = np.linspace(0.0, 2.0, 9)
    exact = -np.diff(np.cos(np.pi * edges)) / np.pi / 0.25
    assert found == pytest.approx(np.tile(exact, (6, 1)), abs=2e-3)


def test_phase_means_start_where_they_are_told_and_leave_a_part_of_a_cycle_out():
    saw = (TIME - 0.5) % 2.0
    assert phase_means(TIME, saw, 2.0, 4, start=0.5) == pytest.approx(
        np.tile([0.25, 0.75, 1.25, 1.75], (5, 1)), abs=2e-3
    )


@pytest.mark.parametrize(
    ("rule", "told"),
    [
        (lambda: phase_means(TIME[:100], TIME[:100], 2.0, 4), "fills 0 cycles"),
        (lambda: phase_means(TIME[::500], TIME[::500], 2.0, 8), "parts empty"),
        (lambda: phase_means(TIME, TIME, -1.0, 8), "expected both above 0"),
        (lambda: phase_means(TIME, TIME[1:], 2.0, 8), "expected the same length"),
        (lambda: phase_means(TIME[::-1], TIME, 2.0, 8), "do not rise"),
    ],
)
def test_a_series_that_the_rule_does_not_fit_is_refused(rule, told):
    with pytest.raises(DataError, match=told):
        rule()


TWIN = function_twin(lambda p, loads: [loads["a"], loads["b"]], {"u": "mm", "v": "mm"}, {}, ("a", "b"), ("crack",))


def test_blocks_of_rows_become_a_campaign():
    blocks = [
        Recorded(np.ones((3, 2)), {"a": 1.0, "b": 2.0}, "first", {"crack": 0.2}),
        Recorded([5, 6], {"b": 4, "a": 3}),
    ]
    campaign = gathered(TWIN, blocks)
    assert [cell.name for cell in campaign.cells] == ["first at a 1, b 2", "test at a 3, b 4"]
    assert campaign.states[:, 0].tolist() == [0.2, 0.2, 0.2, 0.0]
    assert campaign.units == ("mm", "mm")


@pytest.mark.parametrize(
    ("block", "told"),
    [
        (Recorded(np.ones((3, 3)), {"a": 1, "b": 2}), r"shape \(3, 3\)"),
        (Recorded(np.ones((3, 2)), {"a": 1}), r"loads \['a'\]; expected \['a', 'b'\]"),
        (Recorded(np.ones((3, 2)), {"a": 1, "b": 2}, state={"hole": 1}), r"state \['hole'\]"),
    ],
)
def test_a_block_that_is_not_the_twins_is_refused(block, told):
    with pytest.raises(DataError, match=told):
        gathered(TWIN, [block])
