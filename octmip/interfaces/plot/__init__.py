"""Figures: a tree, the partition of a two-feature plane, bound and gap over time, frontiers, cross-validation.

Every function returns a `matplotlib.figure.Figure` made without pyplot: no window, no global state, any thread. Save
it with ``figure.savefig``. Classes that are numbers (a loss of stiffness of 0, 20, 40 percent) get the colours of one
scale in their order, other classes get colours that colour-blind readers can tell apart too.
"""

from octmip.errors import needed_by

with needed_by("a picture"):
    from octmip.interfaces.plot.curves import choice_figure
    from octmip.interfaces.plot.drawing import tree_figure
    from octmip.interfaces.plot.plane import partition_figure
    from octmip.interfaces.plot.sensors import sensors_figure

__all__ = [
    "choice_figure",
    "partition_figure",
    "sensors_figure",
    "tree_figure",
]
