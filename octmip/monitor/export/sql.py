"""A tree as one SQL expression over columns named like the features.

Numbers. A decimal literal is not read to the last bit by every database, so a number is written as a whole number over
powers of two, all exact in float64, and so is their quotient.

Missing readings. NULL is on no side of a split. SQLite stores NaN as NULL; PostgreSQL and DuckDB keep it and hold it
for larger than every number, so the right side is asked as ``-x < -threshold``: true for what is larger than the
threshold, false for NaN in either order. A sum that is no number, infinity minus infinity, goes right as in the tree.
Where a split has a side for missing readings, that side is also asked for
what is neither 0 or less nor, in the same way, more.

Names. The only names in the text are column names, always in double quotes with inner ones doubled: nothing that a
name holds can end it. SQLite takes a quoted name that no column bears for a text, without an error; with `table` every
column is written ``"table"."column"``, and a missing one is an error in every database.

Depth. Parsers of SQLite before 3.46 hold some 16 nested CASE; deeper trees are written flat, one condition per leaf.
"""

from collections.abc import Iterator, Sequence
from typing import Any

from octmip.errors import TreeError
from octmip.input.names import shown
from octmip.monitor.export.fit import check_column, check_fit
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Split, depth, features_used, splits

LARGEST = 62
"""Powers of two up to 2**62 are whole numbers of every database."""
DEEPEST_NEST = 10
"""Levels written as CASE within CASE."""
MOST_TERMS = 900
"""Features of one hyperplane: a sum of more is deeper than the 1,000 levels of SQLite's and DuckDB's expressions."""


def sql_expression(
    tree: Node, feature_names: Sequence[str], class_names: Sequence[Any] | None = None, table: str = ""
) -> str:
    """Return the expression for ``SELECT <expression> FROM readings``: the index of the class, -1 for no result.

    Names of classes are not part of it (`names_json` has them); `class_names` only have to cover its classes.
    PostgreSQL tells columns apart by their first 63 bytes, and stops with an error where a product of a hyperplane
    leaves the range of float64, which the other databases and the tree carry on as infinite or zero.

    Raises
    ------
    TreeError
        the names do not cover the tree, or a feature that it reads has a name that no database takes.
    """
    check_fit(tree, feature_names, class_names)
    _check_columns(tree, feature_names)
    owner = f"{_quoted(check_column(table))}." if table else ""
    columns = [owner + _quoted(str(name)) for name in feature_names]
    return _nested(tree, columns, "") if depth(tree) <= DEEPEST_NEST else _flat(tree, columns)


def _check_columns(tree: Node, names: Sequence[str]) -> None:
    """Refuse names that no database takes, or that a database which knows no case takes for another feature's."""
    folded = [str(name).casefold() for name in names]
    for feature in features_used(tree):
        check_column(names[feature])
        if folded.count(folded[feature]) > 1:
            other = next(j for j, name in enumerate(folded) if name == folded[feature] and j != feature)
            raise TreeError(
                f"feature names {shown(names[feature])} and {shown(names[other])} differ in case only; expected names "
                "that differ otherwise, since SQLite and DuckDB take these for one column; rename one"
            )
    widest = max((len(split.features) for split in splits(tree)), default=0)
    if widest > MOST_TERMS:
        raise TreeError(
            f"a split of the tree adds {widest} features; expected at most {MOST_TERMS}, since databases refuse longer "
            "sums; export to C or ONNX, or limit the problem's split_size"
        )


def _nested(node: Node, columns: Sequence[str], indent: str) -> str:
    if isinstance(node, Leaf):
        return str(node.label)
    left, right = _conditions(node, columns)
    inner = indent + "  "
    return (
        f"CASE\n{indent}WHEN {left} THEN {_nested(node.left, columns, inner)}\n"
        f"{indent}WHEN {right} THEN {_nested(node.right, columns, inner)}\n{indent}ELSE -1 END"
    )


def _flat(tree: Node, columns: Sequence[str]) -> str:
    lines = [f"WHEN {' AND '.join(path)} THEN {leaf.label}" for path, leaf in _paths(tree, columns, ())]
    return "\n".join(["CASE", *lines, "ELSE -1 END"])


def _paths(node: Node, columns: Sequence[str], path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Leaf]]:
    """Yield every leaf with the conditions on its way."""
    if isinstance(node, Leaf):
        yield path, node
        return
    left, right = _conditions(node, columns)
    yield from _paths(node.left, columns, (*path, left))
    yield from _paths(node.right, columns, (*path, right))


def _conditions(split: Split | HyperplaneSplit, columns: Sequence[str]) -> tuple[str, str]:
    """Return when a reading goes left and when right; neither holds for what is missing and has no side."""
    missing, present = (_ask_for_missing([columns[j] for j in split.features], of_missing) for of_missing in (1, 0))
    if isinstance(split, Split) and split.threshold is None:
        return (missing, present) if split.missing == "left" else (present, missing)
    left, right = _sides(split, columns)
    if isinstance(split, HyperplaneSplit):  # a sum that is no number goes right, where no reading is missing
        right = f"(CASE WHEN {left} THEN 0 ELSE 1 END = 1 AND {present})"
    if split.missing is None:
        return left, right
    return (f"({left} OR {missing})", right) if split.missing == "left" else (left, f"({right} OR {missing})")


def _ask_for_missing(columns: Sequence[str], of_missing: int) -> str:
    """Return the condition that some column lacks its number (1), or that none does (0)."""
    zero = _exact(0.0)
    present = " AND ".join(f"({column} <= {zero} OR -{column} < {zero})" for column in columns)
    return f"CASE WHEN {present} THEN 0 ELSE 1 END = {of_missing}"


def _sides(split: Split | HyperplaneSplit, columns: Sequence[str]) -> tuple[str, str]:
    """Return when a number lies left of a threshold and when right."""
    if isinstance(split, Split):
        assert split.threshold is not None
        asked, threshold = columns[split.feature], float(split.threshold)
    else:  # added from the first to the last, as SQL adds without parentheses, and as `goes_left` does
        terms = zip(split.coefficients, split.features, strict=True)
        asked = f"({' + '.join(f'{_exact(float(c))} * {columns[j]}' for c, j in terms)})"
        threshold = float(split.offset)
    return f"{asked} <= {_exact(threshold)}", f"-{asked} < {_exact(-threshold)}"


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _exact(number: float) -> str:
    """Return a number as an expression that is exact in float64."""
    numerator, denominator = number.as_integer_ratio()
    shift = (numerator & -numerator).bit_length() - 1 if denominator == 1 and numerator else 0
    text = f"CAST({numerator >> shift} AS DOUBLE PRECISION)"
    for power in _powers(shift):
        text = f"{text} * CAST({power} AS DOUBLE PRECISION)"
    for power in _powers(denominator.bit_length() - 1):
        text = f"{text} / CAST({power} AS DOUBLE PRECISION)"
    return f"({text})"


def _powers(exponent: int) -> list[int]:
    whole, rest = divmod(exponent, LARGEST)
    return [2**LARGEST] * whole + ([2**rest] if rest else [])
