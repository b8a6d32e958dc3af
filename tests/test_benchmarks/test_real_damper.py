"""The friction damper: its twin, its cycles as rows, and a lack that was put in found again."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.real.damper import LOADS, PARAMETERS, PARTS, damper_twin, diagnosed, force, read_test, said
from octmip.gap import Recorded

NOMINAL = {name: values[0] for name, values in PARAMETERS.items()}
AT = dict(zip(LOADS, (0.5, 1.0, 1000.0, 800.0), strict=True))


def test_whole_cycles_of_a_test_are_its_rows_and_begin_at_the_lowest_displacement(tmp_path: Path):
    time = np.arange(0.0, 14.0, 1 / 128)
    ramp = np.clip(np.minimum(time, 14.0 - time) / 2.0, 0.0, 1.0)
    place = ramp * np.sin(2 * np.pi * 0.5 * time + 0.7)
    speed = np.gradient(place, time)
    table = {"time_s": time, "displacement_in": place, "force_kip": -2.0 * np.sign(speed)}
    ends = {"tension_a_lb": np.where(speed > 0, 1000.0, 5.0), "tension_b_lb": np.where(speed > 0, 5.0, 800.0)}
    pd.DataFrame(table | ends).to_csv(tmp_path / "t1.csv", index=False)
    found = read_test(tmp_path, "t1", 0.5)
    rows = np.asarray(found.rows)
    assert len(rows) >= 4
    assert rows.mean(axis=0)[1 : PARTS // 2 - 1] == pytest.approx(2.0, abs=0.05)
    assert dict(found.loads) == pytest.approx(AT, rel=0.015)


def test_a_backlash_that_was_put_in_is_found_with_its_size():
    rng = np.random.default_rng(2)
    tests = []
    for k, (amplitude, tension) in enumerate([(1.0, 500.0), (1.0, 900.0), (0.5, 700.0), (1.5, 1200.0)]):
        loads = dict(zip(LOADS, (0.5, amplitude, tension, 1.1 * tension), strict=True))
        rows = force(NOMINAL | {"backlash": 0.2}, loads) + 0.02 * rng.standard_normal((5, PARTS))
        tests.append(Recorded(rows, loads, f"t{k}"))
    found = diagnosed(tests, damper_twin())
    assert found.which[0].effects == ("backlash",)
    [size] = found.which[0].parameters
    assert size.size == pytest.approx(0.2, abs=0.03)
    assert said(found)[0].startswith(f"{found.which[0].probability:.2f}: backlash 0.")
