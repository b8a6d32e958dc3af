"""The families of cases: each is one file under benchmarks/cases, or a study of its own, and one line here.

A family's module has `cases()`, questions that several solvers answer side by side, or `results(limit, threads)`, a
study that yields its own result lines; it may have `summary(lines)`, which returns its table in Markdown.
"""

import importlib
from types import ModuleType

FAMILIES = {
    "exact_uci": "benchmarks.cases.exact.uci",
    "exact_uav": "benchmarks.cases.exact.uav",
    "walk": "benchmarks.source_map.walk",
    "exact_ablation": "benchmarks.cases.exact.ablation",
    "option_prices": "benchmarks.cases.exact.option_prices",
    "scopes": "benchmarks.cases.exact.scopes",
    "sparse": "benchmarks.cases.exact.sparse",
    "held_out_tables": "benchmarks.cases.held_out_tables",
    "held_out_numbers": "benchmarks.cases.held_out_numbers",
    "regression_speed": "benchmarks.cases.regression.speed",
    "search_hits": "benchmarks.cases.search.hits",
    "fuzz_everything": "benchmarks.cases.fuzz.everything",
    "fuzz_proofs": "benchmarks.cases.fuzz.proofs",
    "fuzz_check_command": "benchmarks.cases.fuzz.check_command",
    "verified_logs": "benchmarks.cases.fuzz.verified",
    "command_ends": "benchmarks.cases.command.ends",
    "fuzz_signals": "benchmarks.cases.command.signals",
    "printed_rules": "benchmarks.cases.doors.printed_rules",
    "fuzz_files": "benchmarks.cases.fuzz.files",
    "mio_random": "benchmarks.cases.mio.random_problems",
    "two_feature_trees": "benchmarks.cases.two_feature.trees",
    "exports": "benchmarks.cases.fuzz.exports",
    "sql_engines": "benchmarks.cases.doors.sql_engines",
    "limits": "benchmarks.cases.doors.limits",
    "recordings": "benchmarks.cases.doors.recordings",
    "soak": "benchmarks.cases.fuzz.soak",
    "fuzz_kills": "benchmarks.cases.fuzz.kills",
    "fuzz_workers": "benchmarks.cases.fuzz.workers",
    "mutants": "benchmarks.mutants.study",
    "fem_shells": "benchmarks.cases.fem.shells",
    "command_tables": "benchmarks.cases.command.tables",
    "campaigns": "benchmarks.cases.doors.campaigns",
    "gap_noise": "benchmarks.cases.gap.noise",
    "doors_pyomo": "benchmarks.cases.doors.pyomo_models",
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
