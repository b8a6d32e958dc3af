"""Studies of the wing: what moves with the parameters of a design, and how the uncertainty of a capability is drawn."""

import numpy as np
import pytest

from benchmarks.wing.design import WingDesign
from benchmarks.wing.envelope import N_DRAWS, SHARED, drawn
from benchmarks.wing.published import PARAMETERS, wing_design


@pytest.fixture(scope="module")
def design() -> WingDesign:
    if not (SHARED / "uav").exists():
        pytest.skip(f"{SHARED} is not there")
    return wing_design(0.3)


def values(design: WingDesign) -> dict[str, float]:
    starts = {p.name: p.start for p in PARAMETERS}
    return {**design.fixed, **starts, "r1_fore": 0.371, "r1_aft": 0.613}


@pytest.mark.parametrize("name", ["r1_fore", "r1_aft"])
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


def test_drawn_capabilities_scatter_by_strength_and_modulus_where_each_counts(design):
    limits = np.array([[3.0, 9.0, 9.0], [9.0, 3.0, 9.0]])
    by_ply, by_buckling = np.log(drawn(limits)).T
    assert len(by_ply) == N_DRAWS
    assert by_ply.std() == pytest.approx(0.08, abs=0.004)
    assert by_buckling.std() == pytest.approx(0.0095, abs=0.002)
