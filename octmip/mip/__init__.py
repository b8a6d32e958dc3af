"""Mixed-integer formulations of optimal trees on HiGHS: the only home of Pyomo and HiGHS.

Import it when it is first asked for: `pyomo.environ` alone takes 0.6 s.

    problem -> encode (one file a formulation) -> rows -> HiGHS -> decode, re-routed sample by sample -> Solution
"""
