"""A tree as one C function without memory or loops: for the smallest processor.

Numbers are hexadecimal (C99), so no bit is lost in reading them. Products go through a volatile double, because a
compiler may otherwise fuse multiplication and addition into one rounding, and the result could then differ. Under
-ffast-math a compiler takes every reading for a number that is there, so the source does not compile there.

Texts stand in the source byte by byte, everything but plain characters as octal escapes, so nothing in them acts.
"""

import re
from collections.abc import Sequence
from typing import Any

from octmip.errors import TreeError
from octmip.formats.columns import Columns
from octmip.formats.columns.column import Column
from octmip.formats.columns.written import words_of
from octmip.input.cells import EXACT_INTEGERS
from octmip.input.names import shown
from octmip.monitor.export.legend import Legend, comment, quoted
from octmip.monitor.export.questions import (
    Answer,
    Asked,
    ClassNames,
    OwnTree,
    Part,
    SumAsked,
    Term,
    TextAsked,
    own_tree,
)
from octmip.trees.nodes.tree import SIDES, Node, Side

KEYWORDS = frozenset(
    [
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
        "bool",
        "true",
        "false",
        "nullptr",
        "class",
        "new",
        "delete",
        "this",
        "template",
        "typename",
        "namespace",
        "using",
        "try",
        "catch",
        "throw",
        "operator",
    ]
)
"""Of C, and those of C++ that a header would meet."""
GUARD = """\
#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "compile without -ffast-math, -Ofast and -ffinite-math-only: they take a missing reading (NaN) for a number"
#endif
#include <math.h>
"""
LONGEST = 4095
"""Bytes of a string that every compiler of C99 takes."""
UNKNOWN = -1.0
"""Code of a text that training had not."""


def c_source(
    tree: Node,
    columns: Columns | Sequence[str],
    class_names: ClassNames = None,
    *,
    name: str = "octmip_predict",
    legend: Legend | None = None,
) -> str:
    """Return the source of a function of ``const double *reading``, C99 and C++.

    A reading holds one number for each column of the table, in its order: a date as days since 1970-01-01 (UTC), a
    Boolean as 1 or 0, a text as the code that the head of the source gives it, NaN where a cell is missing. Numbers and
    Booleans (1 or 0) come back as double, NaN without an answer; texts as ``const char *`` in UTF-8, a null pointer
    without one.

    Raises
    ------
    TreeError
        `name` is no C name, the names do not cover the tree, or C has no such answer.

    Examples
    --------
    >>> print(c_source(Split(0, 2.5, Leaf(0), Leaf(1)), ["g1"], ["sound", "damaged"], name="state"))
    /* Answers one of "sound", "damaged"; ... */ ...
    const char *state(const double *reading) ...
    """
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) or name in KEYWORDS:
        raise TreeError(
            f"function name {name!r} is no C name; expected letters, digits and _, no digit first and no word of the "
            "language; choose another"
        )
    own = own_tree(tree, columns, class_names)
    kind, none = ("const char *", "0") if own.answers_text else ("double ", "NAN")
    places = " to ".join(f"reading[{k}]" for k in sorted({0, max(0, len(own.columns) - 1)}))
    given = f"It is given {places}, and reads{'' if own.read else ' none'}:"
    nothing = "a null pointer" if own.answers_text else "NaN"
    head = (legend or Legend()).lines(own, "reading[{}]".format, _cells, nothing, given)
    lines = [comment(head), GUARD, f"{kind}{name}(const double *reading)", "{"]
    if _adds(own.root):
        lines.append("    volatile double product, total;")
    if not own.read:
        lines.append("    (void)reading;")
    return "\n".join([*lines, *_Body(own, none).statements(own.root, "    "), "}"]) + "\n"


def _cells(column: Column) -> str:
    """Return what the number of a column is."""
    if column.kind != "number":
        codes = ", ".join(f"{k}: {quoted(value)}" for k, value in enumerate(column.values))
        return f"the code of {quoted(column.name)} ({codes}, {UNKNOWN:g}: another text)"
    meaning = f", {words_of(column.form)}" if column.form else ", 1 or 0" if column.stored == "truths" else ""
    return f"{quoted(column.name)}{quoted(meaning)[1:-1]}"


def _adds(part: Part) -> bool:
    """Whether some sum is made in a tree."""
    if isinstance(part, Answer):
        return bool(part.terms)
    return isinstance(part.asked, SumAsked) or _adds(part.left) or _adds(part.right)


class _Body:
    """The statements of the function."""

    def __init__(self, own: OwnTree, none: str) -> None:
        self.columns, self.none = own.columns, none

    def statements(self, part: Part, indent: str) -> list[str]:
        if isinstance(part, Answer):
            return self.answer(part, indent)
        left, right = self.conditions(part.asked)
        inner = indent + "    "
        added = self.total(part.asked.terms, 0.0, indent) if isinstance(part.asked, SumAsked) else []
        return [
            *added,
            f"{indent}if ({left}) {{",
            *self.statements(part.left, inner),
            f"{indent}}} else if ({right}) {{",
            *self.statements(part.right, inner),
            f"{indent}}} else {{",
            f"{inner}return {self.none};",
            f"{indent}}}",
        ]

    def answer(self, answer: Answer, indent: str) -> list[str]:
        if not answer.terms:
            return [f"{indent}return {_constant(answer.value)};"]
        return [
            *self.total(answer.terms, answer.value, indent),
            f"{indent}return total - total == 0.0 ? total : {self.none};",
        ]

    def conditions(self, asked: Asked) -> tuple[str, str]:
        """Return when a reading goes left and when right; neither for what has no answer."""
        if isinstance(asked, SumAsked):
            missing = " || ".join(f"({self.counted(term)}) != ({self.counted(term)})" for term in asked.terms)
            present = "1" if asked.missing else f"!({missing})"
            lost = f" || {missing}" if asked.missing == "left" else ""
            return f"total <= {asked.offset.hex()}{lost}", present  # a sum that is no number goes right
        cell = f"reading[{asked.column}]"
        missing = f"{cell} != {cell}"
        if isinstance(asked, TextAsked):
            tests = {side: self.among(asked, side) for side in SIDES}
        elif asked.threshold is None:
            tests = {side: "0" if side == asked.missing else f"{cell} == {cell}" for side in SIDES}
        else:
            threshold = asked.threshold.hex()
            tests = {"left": f"{cell} <= {threshold}", "right": f"{cell} > {threshold}"}
        left, right = (f"{tests[side]} || {missing}" if asked.missing == side else tests[side] for side in SIDES)
        return left, right

    def among(self, asked: TextAsked, side: Side) -> str:
        """Return when the code of a column is one of those that go to a side."""
        cell, values = f"reading[{asked.column}]", self.columns[asked.column].values
        if asked.others == side:
            rest = [f"{cell} != {values.index(word)}.0" for word in asked.texts("right" if side == "left" else "left")]
            return f"({' && '.join([f'{cell} == {cell}', *rest])})"
        return " || ".join(f"{cell} == {values.index(word)}.0" for word in asked.texts(side)) or "0"

    def total(self, terms: Sequence[Term], first: float, indent: str) -> list[str]:
        lines = [f"{indent}total = {first.hex()};"]
        for term in terms:
            lines += [f"{indent}product = {term.coefficient.hex()} * ({self.counted(term)});"]
            lines += [f"{indent}total = total + product;"]
        return lines

    def counted(self, term: Term) -> str:
        """Return what the cell of a term counts, NaN where it counts nothing."""
        cell, values = f"reading[{term.column}]", self.columns[term.column].values
        choices = [f"{cell} == {values.index(word)}.0 ? {number!r}" for word, number in term.counts]
        choices += [f"{cell} < {end.hex()} ? {end.hex()}" for end in (term.least,) if end is not None]
        choices += [f"{cell} > {end.hex()} ? {end.hex()}" for end in (term.most,) if end is not None]
        if term.missing is not None:
            choices.insert(0, f"{cell} != {cell} ? {term.missing.hex()}")
        elif term.counts:
            choices.insert(0, f"{cell} != {cell} ? NAN")
        other = cell if not term.counts else "NAN" if term.others is None else repr(term.others)
        return " : ".join([*choices, other])


def _constant(value: Any) -> str:
    """Return an answer as C has it."""
    if isinstance(value, str):
        return f'"{"".join(_character(byte) for byte in _bytes(value))}"'
    if isinstance(value, int) and abs(value) > EXACT_INTEGERS:
        raise TreeError(
            f"the class {value} is beyond 2^53, and C answers numbers as double; expected a smaller one; make the "
            "classes texts"
        )
    return repr(float(value))


def _bytes(text: str) -> bytes:
    """Return a text as a string of C can hold it."""
    if "\0" in text or any(0xD800 <= ord(character) < 0xE000 for character in text):
        raise TreeError(
            f"the class {shown(text)} holds a character that no string of C can hold; expected text without NUL and "
            "halves of surrogate pairs; rename the class"
        )
    held = text.encode()
    if len(held) > LONGEST:
        raise TreeError(
            f"the class {shown(text[:60])}... has {len(held)} bytes; expected at most {LONGEST}; shorten it"
        )
    return held


def _character(byte: int) -> str:
    """Return one byte of a string; a question mark could begin a trigraph."""
    return chr(byte) if 32 <= byte < 127 and chr(byte) not in '"\\?' else f"\\{byte:03o}"
