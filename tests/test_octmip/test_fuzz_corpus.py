"""Calls in which the fuzz of every solver once found a fault, asked again."""

import dataclasses

import pytest

from benchmarks.kinds.asked import answer, questions

FOUND = [
    (2325, "oct_h", "a coefficient near the largest float64 overflowed when it was scaled"),
    (3980, "flow", "the strengthened form was written without a cut"),
    (4216, "exact", "a proof log decided a sensor that no allowed feature reads"),
    (9804, "oct_h", "an offset below the lowest float64"),
]


@pytest.mark.parametrize(("seed", "method", "what"), FOUND)
def test_what_the_fuzz_found_stays_mended(seed, method, what):
    asked = [entry for entry in questions(seed, ("axis", "hyperplane")) if entry[0].method == method]
    assert asked
    for question, problem, least in asked:
        patient = dataclasses.replace(question, limits=dataclasses.replace(question.limits, seconds=20.0))
        said = answer(patient, problem, least)
        assert not said["wrong"], f"{what}: {said['wrong']}"
