"""What a command line says of classes: their order from low to high, and the weight of each."""

import argparse
import math
from typing import Any

from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.table import Table
from octmip.input.cells import plain_number
from octmip.input.messages import several, shown
from octmip.interfaces.cli.samples.names import cells_of
from octmip.trees.question.classes import ClassWeight, class_order_of, distinct_labels


def order_of_column(
    table: Table, label: str, labels: NDArray[Any], arguments: argparse.Namespace
) -> dict[str, tuple[Any, ...]]:
    """Return the order of the classes as a Problem takes it: that of --class-order, else of the column's type.

    Raises
    ------
    DataError
        --class-order names what no row has.
    ProblemError
        it lacks a class, or names one twice.
    """
    classes, _ = distinct_labels(labels)
    given = None
    if arguments.class_order is not None:
        given = [
            _class_named(word, classes, "--class-order") for word in cells_of("--class-order", arguments.class_order)
        ]
    column = table.frame[label] if given is None else None
    return {"class_order": class_order_of(column, classes, given)}


def class_weight_of(words: str | None, classes: list[Any]) -> ClassWeight:
    """Return the weights of classes that --class-weight gives, as estimators take them.

    Raises
    ------
    DataError
        the words are neither "balanced" nor CLASS=WEIGHT, or name what no row has.
    """
    if words is None or words == "balanced":
        return words  # type: ignore[return-value]
    given = {}
    for cell in cells_of("--class-weight", words):
        name, sign, word = cell.rpartition("=")
        number = plain_number(word)
        if not sign or number is None or not 0 <= number < math.inf:
            raise DataError(
                f"--class-weight is {shown(words)}; expected balanced, or CLASS=WEIGHT with a weight of 0 or more, "
                "several joined by commas, such as a=2,b=1"
            )
        given[_class_named(name, classes, "--class-weight")] = number
    return given


def _class_named(word: str, classes: list[Any], option: str) -> Any:
    """Return the class that a word of an option names."""
    found = {str(name): name for name in classes}
    if word not in found and word.strip() not in found:
        raise DataError(f"{option} names {shown(word)}, which no row has; expected some of {several(found)}")
    return found.get(word, found.get(word.strip()))
