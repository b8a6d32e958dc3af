"""What frozen objects hold: mappings that cannot be written, answers that are made once."""

import pickle
from dataclasses import replace

import pytest

from femlib.kept import Kept, ReadOnly


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


def test_a_structure_goes_to_other_processes_without_its_factors(tiny):
    structure = replace(tiny.structure)
    before = len(pickle.dumps(structure))
    strains = structure.solve_outputs([[0.3, 0.6]], tiny.lift, tiny.strain_rows)
    sent = pickle.loads(pickle.dumps(structure))
    assert len(pickle.dumps(structure)) < 1.01 * before
    assert (sent.solve_outputs([[0.3, 0.6]], tiny.lift, tiny.strain_rows) == strains).all()
