"""The walk from a question to its answer: what is counted, and how far it is now."""

from benchmarks.source_map import walk


def test_from_a_problem_to_its_certificate_it_is_twenty_files_and_no_climb():
    asked = walk.to_certificate()
    asked()
    found = walk.figures(walk.stays(asked))
    assert found["files"] <= 20
    assert found["stays"] <= 43
    assert found["climbs"] == 0


def test_a_call_to_a_higher_level_is_a_climb():
    walked = [("trees.solver", "trees.answer.certificate"), ("trees.answer.certificate", "trees.solver")]
    found = walk.figures(walked)
    assert (found["files"], found["stays"], found["which"]) == (2, 2, ["trees.answer.certificate > trees.solver"])
