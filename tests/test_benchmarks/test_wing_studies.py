"""Studies of the wing: what moves with the parameters of a design, and how the uncertainty of a capability is drawn."""

import numpy as np
import pytest

from benchmarks.wing import kinds
from benchmarks.wing.buildable import PARAMETERS, SKINS, buildable_design
from benchmarks.wing.design import WingDesign
from benchmarks.wing.envelope import N_DRAWS, SHARED, drawn
from benchmarks.wing.regions import LEVELS, bayes, confusion, labels, pair_rows
from benchmarks.wing.regions import drawn as drawn_readings
from femlib.dataset.samples import study_states_percent
from femlib.wing.built import built_materials


@pytest.fixture(scope="module")
def design() -> WingDesign:
    if not (SHARED / "uav").exists():
        pytest.skip(f"{SHARED} is not there")
    return buildable_design(0.3)


def values(design: WingDesign) -> dict[str, float]:
    starts = {p.name: p.start for p in PARAMETERS}
    return {**design.fixed, **starts, "r1_in": 0.213, "r1_out": 0.351, "r1_fore": 0.371, "r1_aft": 0.613}


@pytest.mark.parametrize("name", ["r1_in", "r1_out", "r1_fore", "r1_aft"])
def test_a_region_grows_with_its_edges_as_the_derivatives_say(design, name):
    v, step = values(design), 1e-6
    state = "mu1 80 %"
    up, down = (design.design({**v, name: v[name] + s}).states[state].value for s in (step, -step))
    slope = design.design(v).states[state].slopes[name]
    np.testing.assert_allclose(slope, (up - down) / (2 * step), atol=1e-6 * np.abs(slope).max())
    assert slope.any()


@pytest.mark.parametrize("name", ["skin", "rise", "step", "web", "rib"])
def test_stiffness_has_the_derivatives_that_it_says(design, name):
    v, step = {**values(design), "step": 0.7, "rise": -0.2}, 1e-6
    up, down = (design.design({**v, name: v[name] + s}).stiffness.value for s in (step, -step))
    slope = design.design(v).stiffness.slopes[name]
    np.testing.assert_allclose(slope, (up - down) / (2 * step), atol=1e-6 * np.abs(slope).max())


def test_the_built_skin_only_steps_down_and_wood_stays_plywood():
    (step,) = SKINS["one step down"]
    assert (step.name, step.upper) == ("step", 1.0)
    for parameter in PARAMETERS:
        if parameter.name in ("rib", "web"):
            young = built_materials().wood_young * np.array([parameter.lower, parameter.upper])
            np.testing.assert_allclose(young, [4e9, 9e9])


def test_drawn_capabilities_scatter_by_strength_and_modulus_where_each_counts(design):
    limits = np.array([[3.0, 9.0, 9.0], [9.0, 3.0, 9.0]])
    by_ply, by_buckling = np.log(drawn(limits)).T
    assert len(by_ply) == N_DRAWS
    assert by_ply.std() == pytest.approx(0.08, abs=0.004)
    assert by_buckling.std() == pytest.approx(0.0095, abs=0.002)


def test_bayes_names_regions_that_are_far_apart_and_the_labels_are_those_of_the_states():
    region, level = labels()
    assert len(region) == 1 + 28 * len(LEVELS)
    assert (np.bincount(region) == [1, *[len(LEVELS)] * 28]).all()
    means = 1000.0 * np.eye(29)[region] * (1 + level)[:, None]
    readings, state = drawn_readings(means, 3, 0)
    assert (bayes(means, readings) == region[state]).all()


def test_a_confusion_has_a_row_of_shares_for_each_damaged_region():
    region, _ = labels()
    means = 1000.0 * np.eye(29)[region]
    table = confusion(means, lambda readings: np.where(readings.argmax(axis=1) == 3, 7, readings.argmax(axis=1)))
    assert table.sum(axis=1) == pytest.approx(np.ones(29))
    assert table[3, 7] == pytest.approx(1.0)
    rows = pair_rows({"rule": table}, [str(k) for k in range(29)])
    assert {"true": "3", "named": "7", "rule %": 100.0} in rows
    assert len(rows) == 29


def test_kinds_of_sensors_share_a_budget_and_an_inspection_is_paid_once():
    lost = study_states_percent()[:, 1].astype(float)
    gauge = kinds.Kind(("g1",), ("g1",), lost[:, None], np.array([40.0]))
    found = {"gauge": gauge, "inspection": kinds.inspected(lost)}
    readings, state = kinds.drawn(found, 400, 0)
    told = readings["inspection"].argmax(axis=1)
    true = np.searchsorted(kinds.LIMITS_OF_RESULTS, lost[state])
    assert (told != true).mean() == pytest.approx(kinds.MISNAMED, abs=0.01)
    rows = [kinds.row_of(found, chosen, 4.0, 10.0) for chosen in (("gauge",), ("inspection",), ("gauge", "inspection"))]
    assert [row["cost"] for row in rows] == [1.0, 3.0, 4.0]
    assert rows[2]["reads"] == "g1, inspection"
    assert rows[2]["MAE training %"] < min(rows[0]["MAE training %"], rows[1]["MAE training %"])
    assert all(row["proven"] for row in rows)
