"""OCT and OCT-H as Pyomo models that read as on paper, the comparison for the rows of `octmip.mip`.

The only home of Pyomo, whose import takes 0.6 s: no solver imports this package.
"""

from octmip.errors import needed_by

with needed_by("a paper's model"):
    import pyomo.environ  # noqa: F401 (its files import it too: here the extra is named)
