"""octmip: classification and regression trees that are optimal, with the proof."""

import importlib

TYPE_CHECKING = False  # as `typing` has it: a command waits for all that is imported here before it hears a signal
if TYPE_CHECKING:
    from octmip.certificate import Certificate, certify
    from octmip.errors import OctmipError
    from octmip.estimator import OptimalTreeClassifier, OptimalTreeRegressor
    from octmip.losses import AbsoluteError, ClassCosts, SquaredError
    from octmip.near_sets import near_optimal, sensor_roles
    from octmip.prediction import predict, predict_values
    from octmip.problem import Problem
    from octmip.solution import Limits, Progress, Solution, Stop
    from octmip.solver import solve
    from octmip.tree import HyperplaneSplit, Leaf, Split, ValueLeaf
else:  # a checker of types sees no name that is not there
    _MODULES = {
        "certificate": ("Certificate", "certify"),
        "errors": ("OctmipError",),
        "estimator": ("OptimalTreeClassifier", "OptimalTreeRegressor"),
        "losses": ("AbsoluteError", "ClassCosts", "SquaredError"),
        "near_sets": ("near_optimal", "sensor_roles"),
        "prediction": ("predict", "predict_values"),
        "problem": ("Problem",),
        "solution": ("Limits", "Progress", "Solution", "Stop"),
        "solver": ("solve",),
        "tree": ("HyperplaneSplit", "Leaf", "Split", "ValueLeaf"),
    }

    def __getattr__(name: str) -> object:
        """Import the module of a name when it is first asked for."""
        for module, names in _MODULES.items():
            if name in names:
                return getattr(importlib.import_module(f"octmip.{module}"), name)
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
