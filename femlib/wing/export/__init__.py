"""Export: the wing as a CalculiX deck, as VTU, as pictures."""
