"""Files of rows for solvers outside: the model (.lp, .mps), a solution to start from (.mst), a solution back (.sol).

Columns and rows have the names of the paper's letters, ``a(3,1)``: in .lp files a bracket means a square. HiGHS writes
.mps. It writes .lp too, but neither GLPK nor CBC reads that (a constant in the objective, empty sections), so .lp is
written here, in the part of the format that every solver reads.

A solution file is whatever a solver writes of a solution: a column's name and its value behind it. HiGHS, SCIP, CBC,
GLPK (--output), Gurobi and CPLEX write such; a column that is not named is 0. HiGHS reads its own raw
style alone.
"""

import math
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import highspy
import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, SolverError
from octmip.input.cells import plain_number
from octmip.input.files import PathLike, read_bytes, read_text, write_bytes
from octmip.input.messages import shown
from octmip.trees.mip.highs import worker
from octmip.trees.mip.highs.highs import VERSION, arrays
from octmip.trees.mip.rows import Rows
from octmip.trees.question.problem import Problem

COMMENT = {".lp": "\\", ".mps": "*", ".mst": "#"}
"""How a line of a comment begins, by kind of file."""
CONSTANT = "constant"
"""Column of value 1 whose cost is the constant of the objective: not every solver reads a number there."""
TITLE = re.compile(r"octmip model (\w+), problem (\w+)")
"""What `title_of` makes."""
WORD = re.compile(r'\w+\([^()\s]*\)|[^\s"<>=,:{}]+')
"""A column's name, whose indices stand between commas, or what blanks, commas and marks of XML and JSON part."""
NEAR = 6
"""Words behind a column's name among which its value stands."""
BY_NUMBER = re.compile(r"^s (bas|ipt|mip) ", re.MULTILINE)
"""A line of GLPK's raw format, which has the numbers of columns only."""
TABLE = re.compile(r"\s*Index\b.*\b(Primal)\b.*\bName\s*$")
"""The header of a table of HiGHS's style 1."""
WIDTH = 240
"""Of a line of an .lp file: solvers read 255 letters at least."""


def title_of(problem: Problem, method: str) -> str:
    """Return the first line of a model's file."""
    return f"octmip model {method}, problem {problem.digest()}"


def write_rows(rows: Rows, path: PathLike, title: str) -> None:
    """Write a model to a file (.lp or .mps) that begins with `title` as a comment.

    Raises
    ------
    SolverError
        the file has another ending, or HiGHS cannot write it.
    WriteError
        the file cannot be written.
    """
    target = Path(path)
    if target.suffix not in (".mps", ".lp"):
        raise SolverError(f"model file {path} ends in {target.suffix!r}; expected .mps or .lp; rename it")
    if target.suffix == ".lp":
        text = "\n".join(_lp_lines(rows)) + "\n"
        write_bytes(target, _title(title, target) + text.encode())
        return
    highs = worker.load(_priced_by_columns(rows) | {"names": (_with_constant(rows), _file_names(rows.row_names()))})
    if highs is None or highs.writeModel(str(target)) == highspy.HighsStatus.kError:
        raise SolverError(f"HiGHS {VERSION} could not write the model to {path}; expected a writable folder; create it")
    write_bytes(target, _title(title, target) + read_bytes(target))


def read_title(path: PathLike) -> tuple[str, str]:
    """Return the method and the problem's digest in the first line of a model's file.

    Raises
    ------
    DataError
        octmip did not write it.
    """
    found = TITLE.search(read_text(path).partition("\n")[0])
    if found is None:
        raise DataError(
            f"model {path} does not begin with 'octmip model'; expected a file that octmip wrote; give that one, "
            "or leave it out"
        )
    return found[1], found[2]


def write_values(rows: Rows, values: NDArray[np.float64], path: PathLike, title: str) -> None:
    """Write a solution (n_columns,) to start from, line by line a column and its value."""
    lines = [f"{name} {value:.17g}" for name, value in zip(names(rows), values, strict=True) if value]
    write_bytes(path, _title(title, Path(path)) + ("\n".join(lines) + "\n").encode())


def read_values(rows: Rows, path: PathLike) -> NDArray[np.float64]:
    """Return the values (n_columns,) of a solution file; whether they are a solution is for others to say.

    Raises
    ------
    DataError
        the file names no column of the model, or one that the model lacks.
    """
    column, text = {name: j for j, name in enumerate(names(rows))}, read_text(path)
    if BY_NUMBER.search(text):
        raise DataError(
            f"solution {path} names no column: it is in the raw format of GLPK (glpsol --write, style 2 of HiGHS); "
            "expected names and values; write it by glpsol --output, or in style 0 of HiGHS"
        )
    words, found = WORD.findall(_plain_lines(text)), dict[int, float]()
    for at, word in enumerate(words):
        letter, bracket, _ = word.partition("(")
        if word.replace("_", ",") in column and word not in column:
            raise DataError(
                f"solution {path} names the column {shown(word)} as Pyomo does, whose model may have rows of the "
                "user's; expected that of a model that octmip wrote; set the values in the Pyomo model, and give it to "
                "octmip.solution_of"
            )
        if bracket and letter in rows.families and word not in column:
            raise DataError(
                f"solution {path} names the column {shown(word)}, which the model lacks; expected those up to "
                f"{names(rows)[int(rows.families[letter][0].flat[-1])]}; give table, "
                "depth and method of the model that was solved"
            )
        value = _value(words[at + 1 : at + NEAR]) if word in column else None
        if value is not None:
            found.setdefault(column[word], value)  # HiGHS may list reduced costs after the values
    if not found:
        raise DataError(
            f"solution {path} gives no column of the model a value; expected lines such as '{next(iter(column))} 1'; "
            "give the file that a solver wrote for the model that octmip wrote"
        )
    values = np.zeros(len(column))
    values[list(found)] = list(found.values())
    if not np.isfinite(values).all():
        odd = int(np.isfinite(values).argmin())
        raise DataError(
            f"solution {path} gives {names(rows)[odd]} the value {values[odd]}; expected finite numbers; solve it again"
        )
    return values


def _plain_lines(text: str) -> str:
    """Return a solution as lines of name and value, where it is a table with the name behind the value.

    HiGHS's style 1 is one: the value ends below the last letter of "Primal".
    """
    lines, end = [], None
    for line in text.splitlines():
        header = TABLE.match(line)
        end = header.end(1) if header else end if line.strip() else None
        words = line[:end].split()
        lines.append(line if end is None or not words else f"{line.split()[-1]} {words[-1]}")
    return "\n".join(lines)


def names(rows: Rows) -> list[str]:
    """Return the names of all columns as files have them."""
    return _file_names(rows.column_names())


def _file_names(given: list[str]) -> list[str]:
    return [name.replace("[", "(").replace("]", ")") for name in given]


def _priced_by_columns(rows: Rows) -> dict[str, Any]:
    """Return a model for HiGHS whose constant is a column: GLPK reads the one of an .mps file with the other sign."""
    model = arrays(rows)
    if rows.offset:
        for name, value in {"cost": rows.offset, "lower": 1.0, "upper": 1.0, "is_integer": False}.items():
            model[name] = np.append(model[name], value)
    return model | {"offset": 0.0}


def _with_constant(rows: Rows) -> list[str]:
    return names(rows) + [CONSTANT] * bool(rows.offset)


def _title(title: str, path: Path) -> bytes:
    return f"{COMMENT.get(path.suffix, '#')} {title}\n".encode()


def _value(words: list[str]) -> float | None:
    """Return the value behind a name: a number there, what CPLEX calls value, or what stands behind GLPK's star."""
    if "value" in words[:-1] and plain_number(words[0]) is None:
        words = words[words.index("value") + 1 :]
    return next((number for word in words if (number := plain_number(word)) is not None), None)


def _lp_lines(rows: Rows) -> Iterator[str]:
    """Yield the lines of an .lp file."""
    column, matrix, (low, high) = names(rows), rows.matrix(), rows.row_bounds
    priced = np.flatnonzero(rows.cost)
    constant = [f"{rows.offset:+.17g} {CONSTANT}"] if rows.offset else []
    yield "Minimize"
    yield from _wrapped(f"cost: {_sum(rows.cost[priced], priced, column)} {' '.join(constant)}")
    yield "Subject To"
    for i, name in enumerate(_file_names(rows.row_names())):
        begin, end = matrix.indptr[i : i + 2]
        body = _sum(matrix.data[begin:end], matrix.indices[begin:end], column)
        if low[i] == high[i]:
            yield from _wrapped(f"{name}: {body} = {low[i]:.17g}")
            continue
        both = math.isfinite(low[i]) and math.isfinite(high[i])
        if math.isfinite(low[i]):
            yield from _wrapped(f"{name}: {body} >= {low[i]:.17g}")
        if math.isfinite(high[i]):
            yield from _wrapped(f"{name}{'_above' if both else ''}: {body} <= {high[i]:.17g}")
    yield from _bounds(rows, column, bool(constant))


def _bounds(rows: Rows, column: list[str], has_constant: bool) -> Iterator[str]:
    """Yield the lines of bounds and integrality, and the last one."""
    yield "Bounds"
    if has_constant:
        yield f" {CONSTANT} = 1"
    is_binary = rows.is_integer & (rows.lower == 0) & (rows.upper == 1)
    for j in np.flatnonzero(~is_binary):
        yield f" {_end(rows.lower[j])} <= {column[j]} <= {_end(rows.upper[j])}"
    for section, chosen in (("Binaries", is_binary), ("Generals", rows.is_integer & ~is_binary)):
        if chosen.any():
            yield section
            yield from _wrapped(" ".join(column[j] for j in np.flatnonzero(chosen)))
    yield "End"


def _end(value: float) -> str:
    return f"{value:.17g}" if math.isfinite(value) else f"{value:+}"


def _sum(numbers: NDArray[np.float64], columns: NDArray[np.integer], column: list[str]) -> str:
    return " ".join(f"{number:+.17g} {column[j]}" for number, j in zip(numbers, columns, strict=True))


def _wrapped(line: str) -> list[str]:
    return textwrap.wrap(
        line, WIDTH, initial_indent=" ", subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
    )
