"""OCT and OCT-H as Pyomo models that read as on paper: the oracle that the rows of `octmip.mip` are compared with."""
