"""Mixed-integer formulations of optimal trees on HiGHS, and its only home. Pyomo has its own, `octmip.mip.statements`.

problem -> encode (one file a formulation) -> rows -> HiGHS -> decode, re-routed sample by sample -> Solution
"""
