"""octmip: classification and regression trees that are optimal, with the proof."""

from typing import TYPE_CHECKING, Any

from octmip.certificate import Certificate, certify
from octmip.errors import OctmipError
from octmip.losses import AbsoluteError, ClassCosts, SquaredError
from octmip.prediction import predict, predict_values
from octmip.problem import Problem
from octmip.solution import Limits, Progress, Solution, Stop
from octmip.solver import solve
from octmip.tree import HyperplaneSplit, Leaf, Split, ValueLeaf

if TYPE_CHECKING:
    from octmip.estimator import OptimalTreeClassifier, OptimalTreeRegressor
    from octmip.near_sets import near_optimal, sensor_roles
else:  # a checker of types sees no name that is not there

    def __getattr__(name: str) -> Any:
        """Import what needs scikit-learn or the native core when it is first asked for."""
        if name in ("OptimalTreeClassifier", "OptimalTreeRegressor"):
            from octmip import estimator

            return getattr(estimator, name)
        if name in ("near_optimal", "sensor_roles"):
            from octmip import near_sets

            return getattr(near_sets, name)
        raise AttributeError(f"module 'octmip' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


__version__ = "0.1.0"
__all__ = [
    "AbsoluteError",
    "Certificate",
    "ClassCosts",
    "HyperplaneSplit",
    "Leaf",
    "Limits",
    "OctmipError",
    "OptimalTreeClassifier",
    "OptimalTreeRegressor",
    "Problem",
    "Progress",
    "Solution",
    "Split",
    "SquaredError",
    "Stop",
    "ValueLeaf",
    "certify",
    "near_optimal",
    "predict",
    "predict_values",
    "sensor_roles",
    "solve",
]
