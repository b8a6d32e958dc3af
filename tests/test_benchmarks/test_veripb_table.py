"""The table of proofs for veripb: one small line here, all in the benchmark `veripb`; and the proofs in the docs."""

import lzma
from pathlib import Path

import pytest

from benchmarks.cases.exact.veripb import measured, summary
from benchmarks.data import first_rows, uci
from benchmarks.oracles.cutting_planes import verified_bounds
from octmip.problem import Problem
from octmip.pseudo_boolean.formula import Formula
from octmip.pseudo_boolean.question import question_of

DATA = Path(__file__).parents[2] / "docs" / "theory" / "proofs" / "data"


def test_a_line_of_the_table_has_its_figures():
    line = {"size": "iris, 100 rows"} | measured(first_rows(uci("iris"), 100))
    assert line["samples"] == 100
    assert line["lemmas"] > 0
    assert line["proof_bytes"] > line["steps"] > 0
    assert "| iris, 100 rows | 100 x 4 | " in summary([line])


def unpacked(name):
    """Return the text of a file of the docs."""
    return lzma.decompress((DATA / f"{name}.xz").read_bytes()).decode("ascii")


@pytest.mark.parametrize("name", ["iris", "wine"])
def test_the_formulas_in_the_docs_are_those_of_the_data(name):
    table = uci(name)
    question, _, _ = question_of(Problem(table.features, table.labels, depth=2))
    assert Formula(question).opb() == unpacked(f"{name}.opb")


def test_the_kernel_proof_of_iris_in_the_docs_holds():
    assert verified_bounds(unpacked("iris.opb"), unpacked("iris.kernel.pbp")) == (6, 6)
