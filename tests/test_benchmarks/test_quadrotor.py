"""The quadrotors: what parameters change in hover, and what practice says of causes."""

import numpy as np
import pytest

from benchmarks.real.quadrotor import KINDS, NO_LOAD, causes_of, odds_of, places_of, quadrotor_twin

USUAL = np.linspace(-3.0, -1.0, 7)
TWIN = quadrotor_twin(USUAL, {kind: np.full(7, 0.4) for kind in KINDS}, "A")


def change(**sizes):
    asked = {name.replace("_at_", " ").replace("_and_", "&"): size for name, size in sizes.items()}
    return TWIN.ask({}, NO_LOAD, asked) - TWIN.ask({}, NO_LOAD, {})


def test_cuts_on_two_rotors_are_both_cuts_and_shake_once():
    one, other, both = (change(**{f"blade_cut_at_{at}": 2.0}) for at in ("M1", "M3", "M1_and_M3"))
    assert both[:5] == pytest.approx(one[:5] + other[:5])
    assert both[5:] == pytest.approx(one[5:]) == np.full(7, 0.4 * (1.0 - np.exp(-4.0 / 3.5)))


@pytest.mark.parametrize(("rotor", "side"), [("M1", -1.0), ("M2", -1.0), ("M3", 1.0), ("M4", 1.0)])
def test_a_weight_on_a_thread_turns_to_its_side(rotor, side):
    assert np.sign(change(**{f"weight_on_string_at_{rotor}": 1.0})[4]) == side


def test_what_practice_showed_is_expected_again():
    before, after = (odds_of(told).effects for told in ([], [{"tape_on_blade M1": 1.0, "tape_on_blade M3": 1.0}]))
    assert set(before) == {f"{kind} {place}" for kind in KINDS for place in places_of(kind)} == set(TWIN.effects)
    grown = {name: after[name] / before[name] for name in before}
    assert max(grown, key=lambda name: grown[name]) == "tape_on_blade M1&M3"
    assert causes_of("tape_on_blade M1&M3") == {"tape_on_blade M1", "tape_on_blade M3"}
