"""The mutation run: its rows fit the sources as they are, and a mutant is really made, tried and killed."""

import pytest

from benchmarks.mutants.mutant import Mutant
from benchmarks.mutants.rows import MUTANTS
from benchmarks.mutants.study import ROOT, changed_texts, results, summary

QUICK = "octmip/input/checked.py"


def test_every_row_fits_the_sources_and_names_tests_that_exist():
    assert len(changed_texts(MUTANTS)) == len(MUTANTS) >= 60
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS)
    assert not [name for mutant in MUTANTS for name in mutant.tests if not (ROOT / "tests" / name).is_file()]


@pytest.mark.parametrize(
    ("source", "replacement", "reason"),
    [
        ("no such text stands there", "", "0 times; expected once"),
        ("def ", "", "times; expected once"),
        ("MOST_WHOLE = 2**63 - 1", "MOST_WHOLE = = 2", "is no Python"),
    ],
)
def test_a_row_that_does_not_fit_ends_the_run_with_its_name(source, replacement, reason):
    with pytest.raises(SystemExit, match=f"1 mutants do not apply:\n.*checked.py.*{reason}"):
        changed_texts([Mutant(QUICK, source, replacement, ())])


def test_a_mutant_is_killed_in_a_copy_and_the_tree_is_left_alone():
    before = (ROOT / QUICK).read_bytes()
    lines = list(results(60.0, [1], only=QUICK))
    assert [line["outcome"] for line in lines] == ["killed"]
    assert "::test_" in lines[0]["by"]
    assert (ROOT / QUICK).read_bytes() == before


def test_the_summary_counts_by_part_and_names_who_lives():
    lines = [
        {"size": "a", "file": "octmip/trees/certificate.py", "outcome": "killed", "by": "test"},
        {"size": "b", "file": "octmip/gap/causes.py", "outcome": "survived", "by": ""},
        {"size": "c", "file": "octmip/gap/odds.py", "outcome": "equivalent", "by": "no input differs"},
    ]
    said = summary(lines)
    assert "1 of 3 mutants killed." in said
    assert "| octmip.gap | 0 | 0 | 1 | 1 |" in said
    assert "survived: b" in said
    assert "equivalent: c no input differs" in said
