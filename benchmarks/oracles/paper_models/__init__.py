"""OCT and OCT-H as Pyomo models that read as on paper: the oracle of the rows of `octmip.trees.mip`."""
