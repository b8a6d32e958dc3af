"""The wing in trim: divergence of a uniform beam, lift of a rectangle, a fixed point of the full model."""

from dataclasses import replace

import numpy as np
import pytest

from femlib.arrays import FloatArray
from femlib.errors import InputError
from femlib.geometry import Planform
from femlib.wing import FlightPoint, Wing, uav_wing
from femlib.wing.model import reshaped
from femlib.wing.structure import WingMaterials
from femlib.wing.trim import harmonic_lift, lifting_line, trim_wing, twist_rows

STATES = np.array([[0.0, 0.0], [0.8, 0.3]])
FAST = FlightPoint(airspeed=60.0)


@pytest.mark.long
def test_a_uniform_wing_of_lone_strips_diverges_at_the_pressure_of_a_uniform_beam() -> None:
    """q_D = (pi / 2)^2 (GJ / e) / (2 pi c L^2). Source: Bisplinghoff, Ashley & Halfman (1955), equation 8-18.

    The lift acts two chords ahead of the leading edge, so that torsion alone counts and not the clamped root.
    """
    cards = WingMaterials(skin_rise=0.0, skin_step=1.0, web_factor=1.0, rib_factor=1.0, modulus_scale=1.0)
    length, chord = 2.7, 0.3
    wing = reshaped(uav_wing(refinement=0.25, materials=cards), Planform(length, chord, chord, 0.3))
    eta, edges = wing.grid.eta, wing.grid.upper[:, [0, -1]]
    lift, along = np.zeros_like(wing.lift), wing.lift[6 * wing.grid.upper + 2].sum(axis=1)
    lift[6 * edges + 2] = np.outer(2.0 * along, [3.0, -2.0])
    wing = replace(wing, lift=lift)
    tip = np.zeros_like(lift)
    tip[6 * edges[-1] + 2] = [3.0, -2.0]
    twist = twist_rows(wing) @ wing.structure.solve(STATES[:1], tip)[0]
    rate = np.polyfit(length * eta, twist, 1, w=(eta > 0.3) & (eta < 0.7))[0]  # e / GJ
    expected = (0.5 * np.pi) ** 2 / (rate * 2.0 * np.pi * chord * length**2)
    found = trim_wing(wing, is_induced=False).divergence_pressures(STATES[:1])[0]
    assert rate > 0.0
    assert found == pytest.approx(expected, rel=0.015)


def test_the_lift_slope_of_a_rectangle_is_that_of_the_lifting_line() -> None:
    """2 pi / (1 + 2 (1 + tau) / AR), tau 0.16 to 0.17 at AR 6. Source: Glauert (1926), chapter 11."""
    _, rise = lifting_line(Planform(3.0, 1.0, 1.0, 0.3), np.linspace(0.0, 1.0, 30), 2 * np.arange(8) + 1)
    assert np.pi * 6.0 * rise[0] == pytest.approx(2.0 * np.pi / (1.0 + 2.0 * 1.165 / 6.0), rel=0.005)
    by_twist, whole = lifting_line(Planform(3.0, 1.0, 0.6, 0.3), np.linspace(0.0, 1.0, 30), 2 * np.arange(8) + 1)
    np.testing.assert_allclose(by_twist.sum(axis=1), whole)  # an even twist is a root angle


def fixed_point(wing: Wing, state: FloatArray, pressure: float, factor: float, n: int = 6) -> FloatArray:
    """Nodal forces in trim: solve, twist, lift of the twist by Glauert's series, again; the root's angle holds A_1."""
    couple, chord = np.zeros_like(wing.lift), wing.planform.chord(wing.grid.eta)
    share = np.trapezoid(np.eye(len(chord)), wing.span * wing.grid.eta)
    couple[6 * wing.grid.upper[:, 0] + 2] = -0.106 * pressure * chord * share / factor
    couple[6 * wing.grid.upper[:, -1] + 2] = 0.106 * pressure * chord * share / factor
    theta, k = (np.arange(n) + 0.5) * np.pi / (2 * n), 2 * np.arange(n) + 1
    slope = 2.0 * np.pi * wing.planform.chord(np.cos(theta)) / (8.0 * wing.span)
    series = np.sin(np.outer(theta, k)) * (np.outer(slope, k) + np.sin(theta)[:, None])
    first = wing.lift.sum() / (2.0 * np.pi * pressure * wing.span**2)
    force = wing.lift + couple
    for _ in range(30):
        moved = wing.structure.solve(state[None], force)[0].reshape(-1, 6)[:, 2]
        edges = moved[wing.grid.upper[:, 0]] - moved[wing.grid.upper[:, -1]]
        twist = np.interp(np.cos(theta), wing.grid.eta, edges / wing.planform.chord(wing.grid.eta))
        by_twist, by_angle = (np.linalg.solve(series, slope * np.sin(theta) * a) for a in (twist, np.ones(n)))
        found = (by_twist - by_angle * by_twist[0] / by_angle[0]) / first
        force = (
            wing.lift
            + couple
            + sum(a * harmonic_lift(wing, int(order)) for a, order in zip(found[1:], k[1:], strict=True))
        )
    return np.asarray(force)


def test_trim_is_the_fixed_point_of_the_full_wing_at_the_same_lift(tiny: Wing) -> None:
    trimmed, state = trim_wing(tiny, FAST, 2.0), STATES[1]
    force = fixed_point(tiny, state, 0.5 * 1.225 * 60.0**2, 2.0)
    found = trimmed.lift(state)
    np.testing.assert_allclose(found, force, atol=1e-5 * np.abs(force).max())
    assert found.sum() == pytest.approx(tiny.lift.sum(), rel=1e-12)
    full = tiny.strain_microstrain({"mu1": 0.8, "mu2": 0.3}, 2.0, force)
    np.testing.assert_allclose(trimmed.strains_microstrain(STATES)[1], full, rtol=1e-4)
    with pytest.raises(InputError, match="load_factor is 0; expected another"):
        trim_wing(tiny, FAST, 0.0)
