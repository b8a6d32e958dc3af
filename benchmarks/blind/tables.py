"""All tables of a set: the diagnosis beside other selectors, families beside each other."""

from collections.abc import Mapping, Sequence

from benchmarks.blind.assets.families import slug
from benchmarks.blind.guards import guards
from benchmarks.blind.reliability import errors
from benchmarks.blind.score import Pair, by_effect, by_family, figures, is_standard, strata
from benchmarks.figure import Figure, table

UNSAID = ("seconds", "noise named", "channel named", "localisation", "exactly confounded")
"""Rows of which a selector that does no more than select says nothing."""
Told = Mapping[str, Sequence[Pair]]
"""Answers with their keys, by what answered."""


def all_tables(told: Told) -> list[str]:
    """Return the tables of a main set: of the first selector, and a column for each other."""
    with_run, without = (
        {n: [(f, a) for f, a in part if f["calibrated"] == has_run] for n, part in told.items()}
        for has_run in (True, False)
    )
    first = next(iter(with_run.values()))
    standard = [(f, a) for f, a in first if is_standard(a)]
    return [
        table(
            "With the commissioning run",
            {"known healthy state, loads 0 to 3": figures(standard), **_beside(with_run)},
        ),
        table("Without a commissioning run", _beside(without)),
        table("Families, with the commissioning run", _families(with_run)),
        table("Families, without a commissioning run", _families(without)),
        table("Reliability, with the commissioning run", _reliability(with_run)),
        table(
            "Single effects",
            {f"{name}, {run}": strata(part) for run, of in _runs(with_run, without) for name, part in of.items()},
        ),
        table("Top-1 by effect, d' >= 5", {name: by_effect(part) for name, part in with_run.items()}),
        table("Guards, d' >= 5, with the commissioning run", {"single effects": guards(first)}),
    ]


def judged(cases: Sequence[Pair]) -> list[Figure]:
    """Return the figures of what does no more than select: those that a diagnosis is judged by."""
    return [row for row in figures(cases) if not any(word in row.name for word in UNSAID)]


def _runs(with_run: Told, without: Told) -> tuple[tuple[str, Told], ...]:
    return ("with the commissioning run", with_run), ("without", without)


def _beside(told: Told) -> dict[str, list[Figure]]:
    (_, cases), *others = told.items()
    return {"all cases": figures(cases), **{name: judged(part) for name, part in others}}


def _families(told: Told) -> dict[str, list[Figure]]:
    (_, cases), *others = told.items()
    columns: dict[str, list[Figure]] = {}
    for family, own in by_family(cases).items():
        columns[family] = figures(own)
        for name, part in others:
            columns[f"{name}, {slug(family)}"] = judged(by_family(part).get(family, []))
    return columns


def _reliability(told: Told) -> Mapping[str, Sequence[Figure]]:
    (_, cases), *others = told.items()
    columns = {slug(name): errors(own) for name, own in by_family(cases).items()}
    return {**columns, "all families": errors(cases), **{name: errors(part) for name, part in others}}
