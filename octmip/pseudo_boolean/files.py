"""Files FILE.opb and FILE.pbp: the formula of a problem, and a proof of bound and tree for the checker veripb."""

from fractions import Fraction
from pathlib import Path

from octmip.encoding.numbers import power_of_two
from octmip.errors import SolverError
from octmip.formats.files import check_writable, write_bytes
from octmip.problem import Problem
from octmip.pseudo_boolean.formula import Formula
from octmip.pseudo_boolean.lines import Lines
from octmip.pseudo_boolean.question import question_of
from octmip.pseudo_boolean.tree_proof import prove
from octmip.pseudo_boolean.witness import assignment, true_variables
from octmip.tree import Node, without_empty_sides

SUFFIX = ".pbp"


def is_pseudo_boolean(path: str | Path | None) -> bool:
    """Whether a proof goes into a file of veripb's format, by its name."""
    return path is not None and Path(path).suffix == SUFFIX


def formula_path(path: str | Path) -> Path:
    """Return where the formula of a proof lies."""
    return Path(path).with_suffix(".opb")


def check_possible(problem: Problem, path: str | Path) -> None:
    """Refuse a problem that has no formula, or a place where its files cannot be written.

    Raises
    ------
    ProblemError, DataError
        with the reason.
    """
    question_of(problem)
    for place in (Path(path), formula_path(path)):
        check_writable(place)


def write_proof(path: str | Path, problem: Problem, tree: Node, bound: float) -> float:
    """Write the formula and the proof that no tree costs less than `bound` and that `tree` costs what it costs.

    Costs are whole multiples of a unit, so the bound is proved rounded up to the next of them; it is returned. The
    proof is there only once its formula is.

    Raises
    ------
    ProblemError
        there is no formula for such trees or costs.
    SolverError
        the second search, which the proof is made of, finds a tree below the bound.
    DataError
        a file cannot be written.
    """
    question, costs, ranks = question_of(problem)
    formula = Formula(question)
    tree = without_empty_sides(tree, problem.features)
    claim = max(0, -(-Fraction(bound) // power_of_two(-costs.exponent)))
    objective = costs.whole_objective(problem, tree)
    if claim > objective:
        raise SolverError(f"the bound {bound} is above its tree's {costs.value(objective)}; please report it")
    lines, number = prove(formula, int(claim))
    witness = assignment(formula, true_variables(formula, tree, ranks))
    Path(path).unlink(missing_ok=True)  # of another formula
    write_bytes(formula_path(path), formula.opb().encode("ascii"))
    write_bytes(path, _text(lines, int(claim), number, objective, witness).encode("ascii"))
    return costs.value(int(claim))


def _text(lines: Lines, claim: int, number: int, objective: int, witness: str) -> str:
    """Return the proof with its conclusion."""
    end = [
        "output NONE;",
        f"conclusion BOUNDS {claim} : {number} {objective} : {witness};",
        "end pseudo-Boolean proof;",
        "",
    ]
    return "\n".join([*lines.text, *end])
