"""The scatter of cells beside each other, where a gauge says nothing of it."""

import numpy as np

from octmip.gap.channels.outliers import _scale


def test_a_gauge_whose_readings_never_change_has_cells_of_one_scale():
    cell_of = np.repeat([0, 1], 4)
    values = np.full((8, 2), 3.0)
    assert np.array_equal(_scale(values, cell_of), np.ones(8))
