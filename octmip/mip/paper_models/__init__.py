"""OCT and OCT-H as Pyomo models that read as on paper: what the rows of `octmip.mip` are compared with.

The only home of Pyomo, whose import takes 0.6 s: no solver imports this package.
"""
