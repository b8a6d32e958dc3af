"""octmip: classification and regression trees that are optimal, with the proof."""

import importlib

TYPE_CHECKING = False  # as `typing` has it: a command waits for all that is imported here before it hears a signal
if TYPE_CHECKING:
    from octmip.errors import OctmipError
    from octmip.interfaces.estimator import OptimalTreeClassifier, OptimalTreeRegressor
    from octmip.trees.answer.certificate import Certificate, certify
    from octmip.trees.answer.solution import Limits, Progress, Solution, Stop
    from octmip.trees.methods.options import (
        BendersOptions,
        ExactOptions,
        MipOptions,
        Options,
        SearchOptions,
        Study,
    )
    from octmip.trees.mip.pyomo_model import model, solution_of
    from octmip.trees.near_sets import near_optimal, sensor_roles
    from octmip.trees.nodes.prediction import predict, predict_values
    from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split, ValueLeaf
    from octmip.trees.question.losses import AbsoluteError, ClassCosts, QuantileError, SquaredError
    from octmip.trees.question.problem import Problem
    from octmip.trees.solver import solve
else:  # a checker of types sees no name that is not there
    _MODULES = {
        "trees.answer.certificate": ("Certificate", "certify"),
        "errors": ("OctmipError",),
        "interfaces.estimator": ("OptimalTreeClassifier", "OptimalTreeRegressor"),
        "trees.question.losses": ("AbsoluteError", "ClassCosts", "QuantileError", "SquaredError"),
        "trees.methods.options": ("BendersOptions", "ExactOptions", "MipOptions", "Options", "SearchOptions", "Study"),
        "trees.mip.pyomo_model": ("model", "solution_of"),
        "trees.near_sets": ("near_optimal", "sensor_roles"),
        "trees.nodes.prediction": ("predict", "predict_values"),
        "trees.question.problem": ("Problem",),
        "trees.answer.solution": ("Limits", "Progress", "Solution", "Stop"),
        "trees.solver": ("solve",),
        "trees.nodes.tree": ("HyperplaneSplit", "Leaf", "Split", "ValueLeaf"),
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
    "BendersOptions",
    "Certificate",
    "ClassCosts",
    "ExactOptions",
    "HyperplaneSplit",
    "Leaf",
    "Limits",
    "MipOptions",
    "OctmipError",
    "OptimalTreeClassifier",
    "OptimalTreeRegressor",
    "Options",
    "Problem",
    "Progress",
    "QuantileError",
    "SearchOptions",
    "Solution",
    "Split",
    "SquaredError",
    "Stop",
    "Study",
    "ValueLeaf",
    "certify",
    "model",
    "near_optimal",
    "predict",
    "predict_values",
    "sensor_roles",
    "solution_of",
    "solve",
]
