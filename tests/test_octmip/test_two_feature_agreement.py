"""Branch and bound, mixed-integer programs and enumeration agree: part of `benchmarks.cases.two_feature.agreement`."""

from itertools import islice

import pytest

from benchmarks.cases.two_feature.agreement import compared, problems, verdict


@pytest.mark.parametrize("first", [0, 6])
def test_three_programs_agree_on_small_problems(first: int) -> None:
    for name, problem, is_small in islice(problems(), first, first + 6):
        line = compared(problem, is_small, 20.0, 1)
        assert line["verdict"] == "agree", f"{name}: {line}"


def test_the_verdict_tells_contradictions_from_the_distance_that_programs_keep() -> None:
    line = {"exact": 3.0, "exact_bound": 3.0, "enumeration": None}
    line |= {
        "flow": 3.0,
        "flow_bound": 3.0,
        "flow_proven": True,
        "oct_h": 4.0,
        "oct_h_bound": 1.0,
        "oct_h_proven": False,
    }
    assert verdict(line) == "agree"
    assert verdict(line | {"flow": 4.0, "flow_bound": 4.0}) == "mu"
    assert verdict(line | {"flow": 2.0, "flow_bound": 2.0}) == "NO: flow has a better tree"
    assert verdict(line | {"enumeration": 2.0}) == "NO: enumeration"
