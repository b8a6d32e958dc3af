"""Defaults: a name has one default wherever a user meets it, and all solvers share theirs."""

import importlib
import inspect
import math
from collections.abc import Callable
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import pytest

from octmip import Limits, Options
from octmip.trees.runs.registry import REGISTRY

PACKAGES = ("octmip", "octmip.formats.columns", "octmip.monitor", "octmip.sensing", "femlib.rom")
PACKAGES += tuple(f"octmip.trees.{name}" for name in ("question.losses", "near_sets", "tradeoff", "uncertainty"))
EVERYWHERE = {
    "break_ties": False,
    "by_impurity": False,
    "by_sets": False,
    "categories": "yes-no",
    "change": 0.0,
    "dual_tolerance": 1e-6,
    "folds": 5,
    "horizon": 100,
    "largest_load": 3.0,
    "leaf_model": "constant",
    "leaf_penalty": 0.0,
    "leaf_size": 1,
    "limits": Limits(seconds=math.inf, gap=0.0, nodes=math.inf, memory=8 * 2**30),
    "load_factor": 1.0,
    "loss": "squared",
    "max_depth": "auto",
    "method": "auto",
    "min_samples_leaf": 1,
    "min_weight_fraction_leaf": 0.0,
    "missing": "either-side",
    "most_damage": 0.98,
    "most_predictions": 10**6,
    "most_solves": 32,
    "n_draws": 2000,
    "n_dual_states": 24,
    "n_jobs": 1,
    "n_joint": 20,
    "n_modes": 4,
    "n_states": 600,
    "options": {},
    "over": "number",
    "pairs": False,
    "per_sample": False,
    "random_state": 0,
    "rate": 0.01,
    "ridge": 1e-3,
    "rule": "least",
    "seconds": math.inf,
    "seed": 0,
    "smoothing": "out-of-fold",
    "split": "axis",
    "start": "cart",
    "strength": 0.0,
    "sudden": 0.0,
    "takes_missing": False,
    "target_name": "target",
    "tolerance": 0.0,
    "value": "",
    "verbose": 0,
    "with_motion": False,
    "within": 0.0,
}
OWN = {
    **dict.fromkeys([("OptimalTreeClassifier", "seconds"), ("OptimalTreeRegressor", "seconds")], 60.0),
    **dict.fromkeys([("OptimalTreeClassifier", "takes_missing"), ("OptimalTreeRegressor", "takes_missing")], True),
    ("explain", "row"): 0,
    ("explain", "state"): 0,
    ("Limits", "gap"): 0.0,
    ("Limits", "nodes"): math.inf,
    ("Limits", "memory"): 8 * 2.0**30,
    ("leaves_on_fresh_rows", "seconds"): 60.0,
    ("learnt_rates", "weight"): 1.0,
    ("model", "method"): "oct",
    ("reduce_modes", "tolerance"): 0.005,
}
"""Where another one serves better."""


def offered() -> dict[str, Callable[..., Any]]:
    """Return what a user may call, and all solvers."""
    modules = map(importlib.import_module, PACKAGES)
    found = {name: getattr(module, name) for module in modules for name in module.__all__}
    found |= {f"{cell} {name}": one.load() for cell, solvers in REGISTRY.items() for name, one in solvers.items()}
    return {name: one for name, one in found.items() if inspect.isroutine(one) or is_dataclass(one)} | {
        name: found[name] for name in ("OptimalTreeClassifier", "OptimalTreeRegressor")
    }


OFFERED = offered()


@pytest.mark.parametrize("package", ["octmip", "femlib"])
def test_every_package_passes_on_what_it_names(package: str) -> None:
    root = Path(str(importlib.import_module(package).__file__)).parents[1]
    for file in sorted((root / package).rglob("__init__.py")):
        if "__all__" in file.read_text(encoding="utf-8"):
            module = importlib.import_module(".".join(file.parent.relative_to(root).parts))
            assert [name for name in module.__all__ if not hasattr(module, name)] == []


@pytest.mark.parametrize("name", OFFERED)
def test_a_default_is_that_of_the_table(name: str) -> None:
    for argument, given in inspect.signature(OFFERED[name]).parameters.items():
        value = given.default.given() if isinstance(given.default, Options) else given.default
        if value not in (inspect.Parameter.empty, None, ()) and "factory" not in repr(value):
            default = OWN.get((name, argument), EVERYWHERE.get(argument))
            assert (value, type(value)) == (default, type(default))
