"""The families of cases: each is one file under benchmarks/cases, or a study of its own, and one line here.

A family's module has `cases()`, questions that several solvers answer side by side, or `results(limit, threads)`, a
study that yields its own result lines; it may have `summary(lines)`, which returns its table in Markdown.
"""

import importlib
from types import ModuleType

FAMILIES = {
    # Exact proofs beside their peers: docs/benchmarks.md
    "exact_uci": "benchmarks.cases.exact.uci",
    "exact_uav": "benchmarks.cases.exact.uav",
    "sparse": "benchmarks.cases.exact.sparse",
    "deep": "benchmarks.cases.exact.deep",
    "two_feature_trees": "benchmarks.cases.two_feature_trees",
    "regression_speed": "benchmarks.cases.regression_speed",
    # What an option and a bound cost and save: docs/results/options.md, docs/theory/exact.md
    "option_prices": "benchmarks.cases.exact.option_prices",
    "exact_ablation": "benchmarks.cases.exact.ablation",
    # The heuristic against the optimum: docs/benchmarks.md
    "search_hits": "benchmarks.cases.search_hits",
    # Trees on new rows of public tables: docs/results/tables.md
    "command_tables": "benchmarks.cases.command.tables",
    "held_out_tables": "benchmarks.cases.held_out_tables",
    "held_out_numbers": "benchmarks.cases.held_out_numbers",
    # Answers against enumeration: docs/reliability.md, as all below but the last two
    "fuzz_everything": "benchmarks.cases.fuzz.everything",
    "mio_random": "benchmarks.cases.mio_random",
    "scopes": "benchmarks.cases.exact.scopes",
    # Corrupted proof logs and files
    "fuzz_proofs": "benchmarks.cases.fuzz.proofs",
    "fuzz_check_command": "benchmarks.cases.fuzz.check_command",
    "verified_logs": "benchmarks.cases.fuzz.verified",
    "fuzz_files": "benchmarks.cases.fuzz.files",
    "exports": "benchmarks.cases.fuzz.exports",
    # Ends: limits, signals, kills, long runs
    "limits": "benchmarks.cases.doors.limits",
    "command_ends": "benchmarks.cases.command.ends",
    "fuzz_signals": "benchmarks.cases.command.signals",
    "fuzz_kills": "benchmarks.cases.fuzz.kills",
    "fuzz_workers": "benchmarks.cases.fuzz.workers",
    "soak": "benchmarks.cases.fuzz.soak",
    # Doors: what other programs write and read
    "campaigns": "benchmarks.cases.doors.campaigns",
    "recordings": "benchmarks.cases.doors.recordings",
    "modes": "benchmarks.cases.doors.modes",
    "sql_engines": "benchmarks.cases.doors.sql_engines",
    "printed_rules": "benchmarks.cases.doors.printed_rules",
    "doors_pyomo": "benchmarks.cases.doors.pyomo_models",
    # The tests and the sources: wrong code that tests must find, and how far a reader walks (docs/developing.md)
    "mutants": "benchmarks.mutants.study",
    "walk": "benchmarks.source_map.walk",
    # Shells: docs/results/shells.md. Meshes of the wing: docs/wing.md. Noise of a campaign: docs/gap/noise.md
    "fem_shells": "benchmarks.cases.fem_shells",
    "capability_meshes": "benchmarks.cases.fem_capability",
    "capability_regions": "benchmarks.cases.fem_capability_regions",
    "gap_noise": "benchmarks.cases.gap_noise",
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
