"""Mixed-integer formulations of optimal trees on HiGHS, and its only home.

problem -> encode (one file per formulation) -> rows -> HiGHS -> decode, re-routed sample by sample -> Solution
"""
