"""What frozen objects hold: mappings that cannot be written, answers that are made once."""

import pickle

import pytest

from femlib.kept import Kept, ReadOnly
from femlib.wing import uav_wing


def test_a_read_only_mapping_is_a_copy_that_goes_to_other_processes():
    given = {"a": 1, "b": 2}
    held = ReadOnly(given)
    given["c"] = 3
    assert held == {"a": 1, "b": 2} == pickle.loads(pickle.dumps(held))
    assert list(held) == ["a", "b"]
    with pytest.raises(TypeError, match="does not support item assignment"):
        held["a"] = 5


def test_an_answer_is_made_once_and_goes_along():
    kept: Kept[str, int] = Kept()
    assert kept.get("a", lambda: 1) == kept.get("a", lambda: 2) == 1
    assert pickle.loads(pickle.dumps(kept)).get("a", lambda: 3) == 1


def test_a_structure_goes_to_other_processes_without_its_factors():
    wing = uav_wing(refinement=0.25)
    before = len(pickle.dumps(wing.structure))
    strains = wing.structure.solve_outputs([[0.3, 0.6]], wing.lift, wing.strain_rows)
    sent = pickle.loads(pickle.dumps(wing.structure))
    assert len(pickle.dumps(wing.structure)) < 1.01 * before
    assert (sent.solve_outputs([[0.3, 0.6]], wing.lift, wing.strain_rows) == strains).all()
