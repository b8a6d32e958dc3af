"""What the readings and the answers of an export are, said in its head: names, units, the load, the values.

A name is text from outside, and in a comment it must not act: it stands there as JSON in ASCII, and the star that
would end or begin a comment as its escape.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from octmip.formats.columns.column import Column
from octmip.formats.tree_file import NO_READINGS, Readings
from octmip.monitor.export.questions import OwnTree
from octmip.trees.nodes.digits import exact


@dataclass(frozen=True, slots=True)
class Legend:
    """What is known of the readings and the answer beside the tree.

    Attributes
    ----------
    target
        name of what is answered.
    readings
        units, of what is answered too, and loads.

    Examples
    --------
    >>> print(c_source(Leaf(1), ["g1"], ["sound", "damaged"], legend=Legend("state")).splitlines()[0])
    /* Answers "state": one of "sound", "damaged";
    """

    target: str = ""
    readings: Readings = NO_READINGS

    def lines(
        self, own: OwnTree, place: Callable[[int], str], cells: Callable[[Column], str], none: str, given: str = ""
    ) -> list[str]:
        """Return the lines of a head.

        Parameters
        ----------
        place
            what the export calls the input of a column, such as "reading[2]".
        cells
            what stands there, in words.
        none
            what the export returns where the tree has no answer.
        given
            a sentence before the list of columns.
        """
        target = f"{quoted(self.target)}{self._unit(self.target)}: " if self.target else ""
        values = f"one of {', '.join(map(quoted, own.answers))}" if own.answers else "a number"
        what = "the index of a class, as the classes have no names, " if own.are_indices else ""
        lines = [f"Answers {target}{what}{values};"]
        lines.append(f"{none} where the tree has no answer, as a cell that it asks for is missing or unknown.")
        if self.readings.loads:
            at = ", ".join(f"{quoted(name)} {exact(value)}" for name, value in self.readings.loads.items())
            lines.append(f"Readings are taken at the load {at}, and go in as they are.")
        lines += [given] * bool(given)
        for k in own.read:
            column = own.columns[k]
            lines.append(f"{place(k)}{self._unit(column.name)}: {cells(column)}")
        return lines

    def _unit(self, name: str) -> str:
        unit = self.readings.units.get(name, "")
        return f" [{quoted(unit)[1:-1]}]" if unit else ""


def quoted(value: Any) -> str:
    """Return a name or a value for a comment of C or SQL: JSON in ASCII, which neither ends nor begins one."""
    return json.dumps(value).replace("*/", "\\u002a/").replace("/*", "/\\u002a")


def comment(lines: list[str]) -> str:
    """Return lines as one comment of C or SQL."""
    return "/* " + "\n   ".join(lines) + " */"
