"""Exact axis-aligned trees on the numeric UCI sets, depth 2, 3 and 4, beside pycontree, pystreed and pydl8.5."""

from collections.abc import Iterator
from functools import partial

from benchmarks.case import Case
from benchmarks.data import numeric_sets, uci
from benchmarks.rivals import can_be_binary
from benchmarks.tables import race_table
from octmip.trees.question.problem import Problem

DEPTHS = (2, 3, 4)


def cases() -> Iterator[Case]:
    """Yield a case for each numeric set and depth."""
    for depth in DEPTHS:
        for name in numeric_sets()[0]:
            binary = ("pystreed", "pydl8.5") if can_be_binary(uci(name).features) else ()
            yield Case(
                f"{name}, depth {depth}",
                0,
                partial(_problem, name, depth),
                ("octmip", "octmip-core", "pycontree", *binary),
            )


def _problem(name: str, depth: int) -> Problem:
    table = uci(name)
    return Problem(table.features, table.labels, depth=depth)


summary = race_table
