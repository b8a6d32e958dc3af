"""The comparison of reduced models runs, on a small mesh, and its table says what its lines say."""

from benchmarks.cases.fem.rom import compared, summary
from femlib.rom import ReductionSettings

QUICK = ReductionSettings(n_states=100, n_dual_states=4)


def test_the_reduced_model_is_within_its_aim_and_its_bound():
    lines = list(compared(2, 0.3, 20, with_pymor=False, settings=QUICK))
    full, *reduced = lines
    assert full["solver"] == "femlib full"
    assert full["worst_error"] < 1e-5
    assert [line["damaged"] for line in reduced] == [1, 2]
    assert all(line["worst_error"] < 0.01 and line["bound_below_error"] == 0 for line in reduced)
    assert "| femlib reduced | " in summary(lines)
    assert "0 of 10" in summary(lines)
