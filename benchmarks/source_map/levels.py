"""Levels: a file uses only what lies lower in this table, and equal levels are strangers.

Who moves a module changes the table and says why in the commit; `tests/test_layers.py` holds every arrow against it.
A line is a file or folder of the package; a folder whose files have levels of their own has a line for each.
"""

from collections.abc import Mapping

LEVELS: Mapping[str, Mapping[str, int]] = {
    "octmip": {
        "errors": 0,
        "_native": 0,
        "formats.messages": 0,
        "formats.cells": 1,
        "formats.checked": 1,
        "formats.files": 1,
        "methods.margin": 1,
        "formats.names": 1,
        "tree": 1,
        "twin": 1,
        "problem_values": 1,
        "problem": 2,
        "solution": 2,
        "formats.columns": 2,
        "formats.table": 3,
        "run": 3,
        "encoding": 3,
        "formats.problem_file": 3,
        "formats.tree_nodes": 3,
        "formats.tree_schema": 3,
        "risk": 3,
        "uncertainty": 3,
        "methods.polish": 3,
        "certificate": 3,
        "methods.checkpoint": 4,
        "methods.keeper": 5,
        "methods.native_call": 4,
        "methods.merging": 4,
        "methods.ties": 4,
        "formats.tree_file": 4,
        "proof": 4,
        "set_certificate": 4,
        "mip": 6,
        "methods.exact": 6,
        "methods.two_feature": 6,
        "methods.search": 6,
        "methods.cart": 4,
        "solver": 7,
        "tradeoff": 8,
        "near_sets": 8,
        "monitor": 8,
        "sensing": 9,
        "gap": 9,
        "plot": 9,
        "report": 10,
        "estimator": 11,
        "cli": 11,
    },
    "femlib": {
        "errors": 0,
        "arrays": 0,
        "kept": 0,
        "files": 1,
        "checked": 1,
        "material": 1,
        "geometry": 1,
        "mesh": 2,
        "elements": 3,
        "assembly": 4,
        "components": 5,
        "rom": 6,
        "sensors": 7,
        "dataset": 8,
        "wing": 9,
    },
    "native": {
        "check": 0,
        "ranks": 0,
        "tree": 0,
        "costs": 1,
        "control": 1,
        "log": 1,
        "switches": 1,
        "supervise": 2,
        "exact": 3,
        "near_optimal": 4,
        "sequential": 4,
        "two_feature": 4,
        "search": 5,
        "python": 6,
    },
}


def part_of(package: str, inside: str) -> str:
    """Return the line of the table that a dotted name inside a package belongs to: its folder, or its file."""
    first, second = (*inside.split("."), "")[:2]
    return f"{first}.{second}" if f"{first}.{second}" in LEVELS.get(package, ()) else first
