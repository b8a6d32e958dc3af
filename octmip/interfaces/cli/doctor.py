"""Check this installation: `octmip.interfaces.cli.options.doctor` says how the command is called."""

import argparse
import importlib
import importlib.util
import json
import os
import platform
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from types import MappingProxyType
from typing import Any

from octmip.errors import EXTRA_OF
from octmip.input.names import visible
from octmip.trees.answer.interruption import is_heard

NEEDED: Mapping[str, str] = MappingProxyType(
    {name: name for name in ("numpy", "scipy", "pandas", "joblib", "highspy")} | {"scikit-learn": "sklearn"}
)
"""The packages that every installation has, and the module of each."""


@dataclass(frozen=True, slots=True)
class Extra:
    """An extra of the package: the modules that it brings, and what they give."""

    modules: tuple[str, ...]
    gives: str


EXTRAS: Mapping[str, Extra] = MappingProxyType(
    {
        "wing": Extra(("pyfe3d",), "beams in femlib's structures"),
        "plot": Extra(("matplotlib",), "drawings"),
        "parquet": Extra(("pyarrow",), "tables in Parquet files"),
        "onnx": Extra(("onnx",), "export to ONNX"),
        "model": Extra(("pyomo",), "formulations as models of Pyomo"),
        "recordings": Extra(tuple(name for name in EXTRA_OF if EXTRA_OF[name] == "recordings"), "files of loggers"),
        "modes": Extra(("pyoma2",), "frequencies and damping by vibrations"),
        "meshes": Extra(("meshio", "pyfe3d"), "structures from mesh files"),
        "cholmod": Extra(("sksparse",), "sparse factors by CHOLMOD"),
        "pictures": Extra(("pyvista",), "renderings of the wing"),
    }
)


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the examination."""

    name: str
    is_good: bool
    says: str
    is_needed: bool = True


def run(arguments: argparse.Namespace) -> int:
    """Examine and show."""
    findings = list(_findings())
    machine, methods, unknown = _machine(), _of_registry("options_by_method"), _of_registry("settings_unknown_to")
    is_healthy = all(finding.is_good for finding in findings if finding.is_needed)
    if arguments.json:
        listed = [{"name": f.name, "good": f.is_good, "needed": f.is_needed, "says": f.says} for f in findings]
        print(
            json.dumps(
                {"is_healthy": is_healthy, "findings": listed, "methods": methods, "unknown": unknown, **machine}
            )
        )
        return 0 if is_healthy else 1
    width = max(len(finding.name) for finding in findings)
    for finding in findings:
        mark = "ok     " if finding.is_good else "FAULT  " if finding.is_needed else "absent "
        print(f"{mark} {finding.name:<{width}}  {visible(finding.says)}")
    if methods:
        print("\nmethods and their options (octmip.trees.methods.options; the command takes them by --option)")
    for method, options in methods.items():
        print(f"{method:<8}  {', '.join(options)}")
    if unknown:
        print("\nwhat of a problem a solver refuses (octmip.trees.runs.registry.CAPABILITIES)")
    for solver, settings in unknown.items():
        print(f"{solver:<17}  {', '.join(settings)}")
    memory = machine["memory_gigabytes"]
    print(f"\n{machine['threads']} threads, {'unknown' if memory is None else f'{memory:.1f} GB'} of memory")
    print("This installation works." if is_healthy else "This installation does not work: see the lines with FAULT.")
    return 0 if is_healthy else 1


def _of_registry(name: str) -> dict[str, Any]:
    """Return a table of the registry of solvers; nothing where the package cannot be imported, as a finding says."""
    try:
        registry = importlib.import_module("octmip.trees.runs.registry")
    except Exception:
        return {}
    found: dict[str, Any] = getattr(registry, name)()
    return found


def _findings() -> Iterator[Finding]:
    """Yield what is found.

    Raises
    ------
    KeyboardInterrupt
        a signal was heard: a package that it left half imported is not broken.
    """
    here = f"Python {platform.python_version()} in {sys.prefix}, {platform.system()} {platform.machine()}"
    examined: list[Callable[[], Finding]] = [
        lambda: Finding("python", sys.version_info >= (3, 11), here),
        partial(_package, "octmip", "octmip"),
        *(partial(_package, name, module) for name, module in NEEDED.items()),
        _core,
    ]
    for examine in examined:
        finding = examine()
        if is_heard():
            raise KeyboardInterrupt
        yield finding
    yield from _extras()


def _package(name: str, module: str) -> Finding:
    """Return the version of a package that can be imported, or why it cannot."""
    shown = "HiGHS" if name == "highspy" else name
    try:
        importlib.import_module(module)
        return Finding(shown, True, version(name))
    except PackageNotFoundError:
        return Finding(shown, False, f"is not installed; install it again: pip install {name}")
    except Exception as error:  # a damaged package raises anything
        return Finding(shown, False, f"cannot be imported ({type(error).__name__}: {error}); install {name} again")


def _core() -> Finding:
    """Solve a tiny problem with the native core, and certify the result."""
    try:
        import numpy as np

        from octmip.trees.answer.certificate import certify
        from octmip.trees.question.problem import Problem
        from octmip.trees.solver import solve

        problem = Problem(np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]), np.array([0, 1, 1, 0]), depth=2)
        solution = solve(problem, "exact")
        certificate = certify(problem, solution)
    except Exception as error:  # whatever is broken, it is what the examination looks for
        return Finding("native core", False, f"does not work ({type(error).__name__}: {error}); install octmip again")
    is_right = solution.is_optimal and certificate.objective == 0.0
    says = (
        "solved a problem of 4 samples and certified it" if is_right else "gives a wrong result; install octmip again"
    )
    return Finding("native core", is_right, says)


def _extras() -> list[Finding]:
    found = []
    for name, extra in EXTRAS.items():
        absent = [module for module in extra.modules if importlib.util.find_spec(module) is None]
        cure = f"; without {', '.join(absent)} it is not there; install octmip[{name}]" if absent else ""
        found.append(Finding(f"octmip[{name}]", not absent, f"{extra.gives}{cure}", is_needed=False))
    return found


def _machine() -> dict[str, Any]:
    threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    names = getattr(os, "sysconf_names", {})
    has_memory = {"SC_PAGE_SIZE", "SC_PHYS_PAGES"} <= set(names)
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30 if has_memory else None
    return {"threads": threads, "memory_gigabytes": memory}
