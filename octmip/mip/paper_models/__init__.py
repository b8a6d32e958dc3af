"""OCT and OCT-H as Pyomo models that read as on paper, the comparison for the rows of `octmip.mip`.

The only home of Pyomo, whose import takes 0.6 s: no solver imports this package.
"""
