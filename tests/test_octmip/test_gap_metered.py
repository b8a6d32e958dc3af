"""Metered loads: rows that each have their own become cells of like loads."""

from dataclasses import replace

import numpy as np
import pytest

from octmip.gap import Recorded, diagnose, gathered
from octmip.gap.campaign.metered import gathered_alike
from tests.test_octmip.test_gap_built import SD, SPRINGS, springs

NOMINAL = {name: own.nominal for name, own in SPRINGS.card.ranges.items()}


def metered(n: int, seed: int, **values: float):
    """Return a time series of the springs: each row its own force."""
    rng = np.random.default_rng(seed)
    forces = 40.0 + 20.0 * np.sin(np.arange(n) / n * 40.0) + 2.0 * rng.standard_normal(n)
    noise = SD * rng.standard_normal((n, len(SD)))
    rows = np.array([springs(NOMINAL | values, {"force": force}) for force in forces]) + noise
    return gathered(
        SPRINGS, [Recorded(row, {"force": force}) for row, force in zip(rows, forces.tolist(), strict=True)]
    )


@pytest.mark.parametrize("n", [150, 1500])
def test_a_time_series_beside_another_is_diagnosed_with_its_size(n):
    found = diagnose(metered(n, 2, k1=9.7), SPRINGS, commissioning=metered(n, 1))
    assert found.which[0].effects == ("k1",)
    size = found.which[0].parameters[0]
    assert size.low < -0.3 < size.high
    assert size.high - size.low < 0.05
    assert "Nearly every row has its own load" in " ".join(found.notes)
    assert len(found.posterior.model.inputs.campaign.cells) <= 20


def test_rows_are_moved_along_the_square_through_their_like_and_the_rest_is_their_noise():
    rng = np.random.default_rng(3)
    forces, sd = rng.uniform(0.0, 10.0, 600), 0.01
    rows = np.column_stack([forces**2, np.where(rng.random(600) < 0.3, np.nan, 3.0 * forces), forces, 0.0 * forces])
    series = gathered(
        SPRINGS,
        [
            Recorded(row, {"force": force})
            for row, force in zip(rows + sd * rng.standard_normal(rows.shape), forces, strict=True)
        ],
    )
    (moved,), notes = gathered_alike([series])
    assert len(notes) == 1
    assert len(moved.cells) == 20
    for cell in moved.cells:
        assert cell.mean == pytest.approx([cell.load**2, 3.0 * cell.load, cell.load, 0.0], abs=0.02)
        assert np.nanstd(moved.readings[cell.rows], axis=0) == pytest.approx(sd, rel=0.6)


def test_tests_and_states_stay_apart_and_few_loads_stay_as_they_are():
    series = metered(300, 1)
    half = ["a"] * 150 + ["b"] * 150
    (moved,), _ = gathered_alike([replace(series, test=tuple(half))])
    assert {cell.test for cell in moved.cells} == {"a", "b"}
    assert len({cell.load for cell in moved.cells}) <= 20
    steady = gathered(SPRINGS, [Recorded(np.ones((5, 4)), {"force": float(k)}) for k in range(45)])
    assert gathered_alike([steady]) == ([steady], [])


def test_a_time_series_beside_steady_loads_is_gathered_at_these_and_moves_no_reading_of_them():
    rows = np.array([springs(NOMINAL | {"k1": 9.5}, {"force": f}) for f in (25.0, 40.0, 55.0)])
    noise = np.random.default_rng(4)
    steady = gathered(
        SPRINGS,
        [
            Recorded(row + SD * noise.standard_normal((12, 4)), {"force": f})
            for f, row in zip((25.0, 40.0, 55.0), rows, strict=True)
        ],
    )
    run, now = gathered_alike([metered(1500, 1), steady])[0]
    assert now.readings == pytest.approx(steady.readings)
    assert {cell.load for cell in run.cells} == {cell.load for cell in now.cells} == {25.0, 40.0, 55.0}
    found = diagnose(steady, SPRINGS, commissioning=metered(1500, 1))
    assert found.which[0].effects == ("k1",)
    assert found.which[0].parameters[0].size == pytest.approx(-0.5, abs=0.06)


def test_plateaus_of_two_tests_near_one_centre_stay_at_their_own_loads():
    series = metered(400, 1)
    plateau = gathered(SPRINGS, [Recorded(np.full((30, 4), 3.0), {"force": 41.37}, test="B")])
    both = replace(
        series,
        test=(*series.test, *plateau.test),
        load_factor=np.concatenate([series.load_factor, plateau.load_factor]),
        states=np.zeros((430, 0)),
        readings=np.concatenate([series.readings, plateau.readings]),
        time=np.full(430, np.nan),
        temperature=np.full(430, np.nan),
    )
    (moved,), _ = gathered_alike([both])
    (own,) = [cell for cell in moved.cells if cell.test == "B"]
    assert own.load == pytest.approx(41.37)
    assert own.mean == pytest.approx(3.0)
