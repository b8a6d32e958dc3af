"""octmip: classification trees that are optimal, with the proof."""

from octmip.certificate import Certificate, certify
from octmip.errors import OctmipError
from octmip.problem import Problem
from octmip.solution import Limits, Progress, Solution, Stop
from octmip.solver import solve
from octmip.tree import HyperplaneSplit, Leaf, Split, predict

__version__ = "0.1.0"
__all__ = [
    "Certificate",
    "HyperplaneSplit",
    "Leaf",
    "Limits",
    "OctmipError",
    "Problem",
    "Progress",
    "Solution",
    "Split",
    "Stop",
    "certify",
    "predict",
    "solve",
]
