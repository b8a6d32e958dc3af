"""What a tree is judged by, and all that the page says of it: of classes or of numbers, whichever the loss predicts.

Both have the same members: one of `OfClasses` stands in `OfNumbers` too.
"""

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.tree.of_classes import OfClasses
from octmip.interfaces.report.tree.of_numbers import OfNumbers

Measure = OfClasses | OfNumbers


def measure_of(file: TreeFile) -> Measure:
    """Return what the tree of a file is judged by."""
    return OfClasses.of(file) if file.loss.predicts == "class" else OfNumbers(file)
