"""A campaign made of blocks of rows."""

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import Recorded, function_twin, gathered

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
