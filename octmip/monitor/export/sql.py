"""A tree as one SQL expression over the columns of the user's own table.

The wording is the same for all databases; `octmip.monitor.export.sql_cells` says how it asks the cells of a column.

Names. The only texts of the user's in it are names of columns, in double quotes with inner ones doubled, and texts of
columns and classes, in single quotes in the same way: nothing that they hold can end them. ClickHouse reads a backslash
in quotes as an escape, so names and texts with one are refused. SQLite takes a quoted name that no column bears for a
text, without an error; with `table` every column is written ``"table"."column"``, and a missing one is an error in
every database.

Depth. Parsers of SQLite before 3.46 hold some 16 nested CASE; deeper trees are written flat, one condition per leaf.
"""

from collections.abc import Iterator, Sequence
from typing import Any

from octmip.errors import TreeError
from octmip.formats.columns import Columns
from octmip.input.names import shown
from octmip.monitor.export.legend import Legend, comment, quoted
from octmip.monitor.export.questions import (
    Answer,
    Asked,
    ClassNames,
    NumberAsked,
    OwnTree,
    Part,
    SumAsked,
    Term,
    TextAsked,
    own_tree,
)
from octmip.monitor.export.sql_cells import Cells, exact, plain, text_literal
from octmip.trees.nodes.tree import SIDES, Node, Side, depth

DEEPEST_NEST = 10
"""Levels written as CASE within CASE."""
MOST_TERMS = 900
"""Columns of one sum: a sum of more is deeper than the 1,000 levels of SQLite's and DuckDB's expressions."""
INT32, INT64 = 2**31, 2**63


def sql_expression(
    tree: Node,
    columns: Columns | Sequence[str],
    class_names: ClassNames = None,
    *,
    table: str = "",
    legend: Legend | None = None,
) -> str:
    """Return the expression for ``SELECT <expression> FROM readings``: the class's own value, or a number.

    NULL is what it returns where the tree has no answer. PostgreSQL tells columns apart by their first 63 bytes, and
    stops with an error where a product of a hyperplane leaves the range of float64, which the other databases and the
    tree carry on as infinite or zero.

    Raises
    ------
    TreeError
        the names do not cover the tree, or it reads or answers what no expression can hold in all databases: a name or
        text with a backslash, a duration, a number that is written with a sign or with marks between its digits, a date
        that is neither one of the database nor ISO text.

    Examples
    --------
    >>> print(sql_expression(Split(0, 2.5, Leaf(0), Leaf(1)), ["g1"], ["sound", "damaged"]))
    /* Answers one of "sound", "damaged"; ... */
    CASE ... THEN NULL ... <= ... THEN 'sound' ELSE 'damaged' END
    """
    own = own_tree(tree, columns, class_names)
    _check_names(own)
    owner = f"{_column(table)}." if table else ""
    cells = {k: Cells.of(own.columns[k], owner + _column(own.columns[k].name)) for k in own.read}
    named = [quoted(column.name) for column in own.columns]
    head = (legend or Legend()).lines(own, named.__getitem__, lambda column: Cells.of(column, "").words, "NULL")
    wide = any(isinstance(value, int) and not -INT32 <= value < INT32 for value in own.answers)
    writer = _Expression(cells, wide)
    text = writer.nested(own.root, "") if depth(tree) <= DEEPEST_NEST else writer.flat(own.root)
    return f"{comment(head)}\n{text}"


def _check_names(own: OwnTree) -> None:
    """Refuse names that a database which knows no case takes for another column's."""
    folded = [column.name.casefold() for column in own.columns]
    for k in own.read:
        if folded.count(folded[k]) > 1:
            other = next(j for j, name in enumerate(folded) if name == folded[k] and j != k)
            raise TreeError(
                f"column names {shown(own.columns[k].name)} and {shown(own.columns[other].name)} differ in case only; "
                "expected names that differ otherwise, since SQLite and DuckDB take these for one column; rename one"
            )


def _column(name: str) -> str:
    """Return the name of a column or table in quotes."""
    return '"' + plain(name, "the name of a column; rename the feature and the column").replace('"', '""') + '"'


class _Expression:
    """The expression of a tree.

    Attributes
    ----------
    cells
        how each column that it reads is asked.
    wide
        whether whole numbers are written with 64 bits: Polars ends where a CASE mixes them with shorter ones.
    """

    def __init__(self, cells: dict[int, Cells], wide: bool) -> None:
        self.cells, self.wide = cells, wide

    def nested(self, part: Part, indent: str) -> str:
        if isinstance(part, Answer):
            return self.answer(part)
        inner = indent + "  "
        left, right = (self.nested(side, inner) for side in (part.left, part.right))
        lost, goes_left = self.in_turn(part.asked)
        nowhere = f"\n{indent}WHEN {lost} THEN NULL" if lost else ""
        return f"CASE{nowhere}\n{indent}WHEN {goes_left} THEN {left}\n{indent}ELSE {right} END"

    def in_turn(self, asked: Asked) -> tuple[str, str]:
        """Return when a row has no answer, "" where each has one, and when it goes left of those that have."""
        if isinstance(asked, SumAsked):
            left, right = self.conditions(asked)
            return ("" if asked.missing else f"NOT ({left} OR {right})"), left
        cells = self.cells[asked.column]
        missing, unknown = cells.missing, self.unknown(asked)
        test = self.test(asked, "left")
        if asked.missing is None:
            return (f"{missing} OR {unknown}" if unknown else missing), test
        lost = f"NOT {missing} AND {unknown}" if unknown else ""
        return lost, f"{missing} OR {test}" if asked.missing == "left" else f"NOT {missing} AND {test}"

    def unknown(self, asked: NumberAsked | TextAsked) -> str:
        """Return when a cell that is not missing has no answer either; "" where each has one."""
        cells = self.cells[asked.column]
        if isinstance(asked, NumberAsked):
            return "" if asked.threshold is None else cells.unknown
        return "" if asked.others else f"NOT {cells.among((*asked.left, *asked.right))}"

    def test(self, asked: NumberAsked | TextAsked, side: Side) -> str:
        """Return when a cell that is not missing goes to a side."""
        cells = self.cells[asked.column]
        if isinstance(asked, NumberAsked):
            return cells.beside(asked.threshold, side) if asked.threshold is not None else _holds(asked.missing != side)
        if asked.others != side:
            return cells.among(asked.texts(side))
        return f"NOT {cells.among(asked.texts('right' if side == 'left' else 'left'))}"

    def flat(self, root: Part) -> str:
        lines = [f"WHEN {' AND '.join(path)} THEN {self.answer(leaf)}" for path, leaf in self.paths(root, ())]
        return "\n".join(["CASE", *lines, "ELSE NULL END"])

    def paths(self, part: Part, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Answer]]:
        """Yield every leaf with the conditions on its way."""
        if isinstance(part, Answer):
            yield path, part
            return
        left, right = self.conditions(part.asked)
        yield from self.paths(part.left, (*path, left))
        yield from self.paths(part.right, (*path, right))

    def answer(self, answer: Answer) -> str:
        if answer.terms:
            return self.total(answer.terms, answer.value)
        return f"CAST({_constant(answer.value)} AS BIGINT)" if self.wide else _constant(answer.value)

    def conditions(self, asked: Asked) -> tuple[str, str]:
        """Return when a row goes left and when right; neither holds for what has no answer."""
        if isinstance(asked, SumAsked):
            return self.sides_of_sum(asked)
        missing, unknown = self.cells[asked.column].missing, self.unknown(asked)
        sides = []
        for side in SIDES:
            test = f"{self.test(asked, side)}{f' AND NOT ({unknown})' * bool(unknown)}"
            sides.append(f"({missing} OR {test})" if asked.missing == side else f"(NOT {missing} AND {test})")
        return sides[0], sides[1]

    def sides_of_sum(self, asked: SumAsked) -> tuple[str, str]:
        """Return when a sum is at most its offset; a sum that is no number goes right, where no cell is missing."""
        total = self.total(asked.terms, None)
        left = f"({total} <= {exact(asked.offset)} AND LOWER({total} || '') NOT IN ('nan', '-nan'))"
        missing = f"({' OR '.join(f'({self.counted(term)}) IS NULL' for term in asked.terms)})"
        right = f"CASE WHEN {left} THEN 0 ELSE 1 END = 1"
        sides = [
            f"({missing} OR {test})" if asked.missing == side else f"(NOT {missing} AND {test})"
            for side, test in zip(SIDES, (left, right), strict=True)
        ]
        return sides[0], sides[1]

    def total(self, terms: Sequence[Term], first: float | None) -> str:
        """Return a sum, added from the first to the last, as SQL adds without parentheses."""
        if len(terms) > MOST_TERMS:
            raise TreeError(
                f"a split of the tree adds {len(terms)} features; expected at most {MOST_TERMS}, since databases "
                "refuse longer sums; export to C or ONNX, or limit the problem's split_size"
            )
        products = [f"{exact(term.coefficient)} * {self.counted(term)}" for term in terms]
        return f"({' + '.join(([] if first is None else [exact(first)]) + products)})"

    def counted(self, term: Term) -> str:
        """Return what the cell of a term counts, NULL where it counts nothing."""
        cells = self.cells[term.column]
        missing = "NULL" if term.missing is None else exact(term.missing)
        choices = [f"WHEN {cells.missing} THEN {missing}"]
        if term.counts:
            choices += [f"WHEN {cells.among((word,))} THEN {exact(number)}" for word, number in term.counts]
            other = "NULL" if term.others is None else exact(term.others)
        else:
            other = cells.number
            ends = ((term.least, "<"), (term.most, ">"))
            choices += [f"WHEN {other} {sign} {exact(end)} THEN {exact(end)}" for end, sign in ends if end is not None]
        return f"CASE {' '.join(choices)} ELSE {other} END"


def _holds(is_so: bool) -> str:
    return "1 = 1" if is_so else "1 = 0"


def _constant(value: Any) -> str:
    """Return an answer as a literal."""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, str):
        return text_literal(value)
    if isinstance(value, float):
        return exact(value)
    if not -INT64 <= value < INT64:
        raise TreeError(f"the class {value} has more than 64 bits; expected a smaller one; make the classes texts")
    return str(value)
