"""What can be measured: each family of cases is one file under benchmarks/cases and one line here.

A family's module has `cases()`, questions that several solvers answer side by side, or `results(limit, threads)`, a
study that yields its own result lines; it may have `summary(lines)`, which returns its table in Markdown.
"""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

from octmip.problem import Problem


@dataclass(frozen=True, slots=True)
class Case:
    """One question to be answered by several solvers, each in a process of its own.

    Attributes
    ----------
    size
        what is asked, in words that name it within its family ("iris, depth 3").
    seed
        of the data.
    build
        returns the problem; called in the solver's process, not measured.
    solvers
        names in `benchmarks.rivals.RIVALS`.
    """

    size: str
    seed: int
    build: Callable[[], Problem]
    solvers: tuple[str, ...]


FAMILIES = {
    "exact_uci": "benchmarks.cases.exact_uci",
    "exact_uav": "benchmarks.cases.exact_uav",
    "exact_budget": "benchmarks.cases.exact_budget",
    "exact_call": "benchmarks.cases.exact_call",
    "exact_growth": "benchmarks.cases.exact_growth",
    "exact_proofs": "benchmarks.cases.exact_proofs",
    "search_hits": "benchmarks.cases.search_hits",
    "search_planes": "benchmarks.cases.search_planes",
    "search_lines": "benchmarks.cases.search_lines",
    "search_growth": "benchmarks.cases.search_growth",
    "fuzz_everything": "benchmarks.cases.fuzz_everything",
    "fuzz_exact": "benchmarks.cases.fuzz_exact",
    "fuzz_proofs": "benchmarks.cases.fuzz_proofs",
    "fuzz_files": "benchmarks.cases.fuzz_files",
    "mio_forms": "benchmarks.cases.mio_forms",
    "mio_agreement": "benchmarks.cases.mio_agreement",
    "mio_binary": "benchmarks.cases.mio_binary",
    "mio_build": "benchmarks.cases.mio_build",
    "oblique_trees": "benchmarks.cases.oblique_trees",
    "oblique_single": "benchmarks.cases.oblique_single",
    "oblique_proofs": "benchmarks.cases.oblique_proofs",
    "oblique_agreement": "benchmarks.cases.oblique_agreement",
    "fuzz_oblique": "benchmarks.cases.fuzz_oblique",
    "fuzz_oblique_proofs": "benchmarks.cases.fuzz_oblique_proofs",
    "exports": "benchmarks.cases.exports",
    "fem_mesh": "benchmarks.cases.fem_mesh",
    "fem_shells": "benchmarks.cases.fem_shells",
    "fem_calculix": "benchmarks.cases.fem_calculix",
    "fem_calibration": "benchmarks.cases.fem_calibration",
    "fem_dataset": "benchmarks.cases.fem_dataset",
    "fem_rom": "benchmarks.cases.fem_rom",
    "gap_detect": "benchmarks.cases.gap_detect",
    "gap_speed": "benchmarks.cases.gap_speed",
}


def family(name: str) -> ModuleType:
    """Return the module of a family.

    Raises
    ------
    SystemExit
        there is no such family.
    """
    if name not in FAMILIES:
        raise SystemExit(f"no benchmark family is called {name!r}; choose from: {', '.join(FAMILIES)}")
    return importlib.import_module(FAMILIES[name])
