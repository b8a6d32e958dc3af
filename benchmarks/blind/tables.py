"""All tables of a set: the diagnosis beside the limit of information, families beside each other."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.blind.assets.families import OWN, in_order, slug
from benchmarks.blind.figure import Figure, table
from benchmarks.blind.guards import guards
from benchmarks.blind.limit.limits import limit_figures
from benchmarks.blind.reliability import errors
from benchmarks.blind.score import Pair, by_effect, figures, is_standard, strata

LIMIT = "information limit"


def all_tables(cases: Sequence[Pair], limits: Sequence[Pair], retrained: Sequence[Figure]) -> list[str]:
    """Return the tables of a main set; `limits` are the same cases as the selector answers them."""
    with_run, limit_with = ([(f, a) for f, a in part if f["calibrated"]] for part in (cases, limits))
    without, limit_without = ([(f, a) for f, a in part if not f["calibrated"]] for part in (cases, limits))
    standard = [(f, a) for f, a in with_run if is_standard(a)]
    names = {f["name"] for f, _ in without}
    return [
        table(
            "With the commissioning run",
            {"known healthy state, loads 0 to 3": [*figures(standard), *retrained], **_beside(with_run, limit_with)},
        ),
        table(
            "Without a commissioning run", _beside(without, [(f, a) for f, a in limit_without if f["name"] in names])
        ),
        table("Families, with the commissioning run", _families(with_run, limit_with)),
        table("Families, without a commissioning run", _families(without, limit_without)),
        table("Own and foreign families, with the commissioning run", spread(with_run, limit_with)),
        table("Reliability, with the commissioning run", _reliability(with_run, limit_with)),
        table("Single effects", {"with the commissioning run": strata(with_run), "without": strata(without)}),
        table("Top-1 by effect, d' >= 5", {"with the commissioning run": by_effect(with_run)}),
        table("Guards and baselines, d' >= 5, with the commissioning run", {"single effects": guards(with_run)}),
    ]


def of_family(cases: Sequence[Pair], family: str) -> list[Pair]:
    """Return the cases of one family."""
    return [(f, a) for f, a in cases if a["case"]["family"] == family]


def families_of(cases: Sequence[Pair]) -> list[str]:
    """Return the families of cases, the own one first."""
    return in_order({a["case"]["family"] for _, a in cases})


def foreign(cases: Sequence[Pair]) -> list[Pair]:
    """Return the cases of assets that another hand modelled."""
    return [(f, a) for f, a in cases if slug(a["case"]["family"]) != OWN]


def spread(cases: Sequence[Pair], limits: Sequence[Pair]) -> dict[str, list[Figure]]:
    """Return the figures of the own family, of all foreign ones, what these lack, and the range over the families."""
    others = foreign(cases)
    own = [(f, a) for f, a in cases if slug(a["case"]["family"]) == OWN]
    first, second = figures(own), figures(others)
    every = [figures(of_family(cases, name)) for name in families_of(cases)]
    return {
        "own family": first,
        "foreign families": second,
        f"{LIMIT}, foreign": limit_figures(foreign(limits)),
        "foreign less own": [_difference(a, b) for a, b in zip(first, second, strict=True)],
        "largest less least of the families": [_range(rows) for rows in zip(*every, strict=True)],
    }


def _beside(cases: Sequence[Pair], limits: Sequence[Pair]) -> dict[str, list[Figure]]:
    return {"all cases": figures(cases), LIMIT: limit_figures(list(limits))}


def _families(cases: Sequence[Pair], limits: Sequence[Pair]) -> dict[str, list[Figure]]:
    columns: dict[str, list[Figure]] = {}
    for name in families_of(cases):
        columns[name] = figures(of_family(cases, name))
        columns[f"{LIMIT}, {slug(name)}"] = limit_figures(of_family(limits, name))
    return columns


def _reliability(cases: Sequence[Pair], limits: Sequence[Pair]) -> Mapping[str, Sequence[Figure]]:
    columns = {slug(name): errors(of_family(cases, name)) for name in families_of(cases)}
    return {**columns, "foreign families": errors(foreign(cases)), f"{LIMIT}, foreign": errors(foreign(limits))}


def _difference(own: Figure, other: Figure) -> Figure:
    """Return what the second figure has more, with the interval that two independent ones leave."""
    n = min(own.n, other.n)
    value = other.value - own.value
    down = np.hypot(other.value - other.low, own.high - own.value)
    up = np.hypot(other.high - other.value, own.value - own.low)
    return Figure(own.name, value, float(value - down), float(value + up), n)


def _range(rows: Sequence[Figure]) -> Figure:
    """Return the largest less the least of the families' figures, its interval that of these two."""
    told = sorted((row for row in rows if row.n), key=lambda row: row.value)
    if len(told) < 2:
        return Figure(rows[0].name, np.nan, np.nan, np.nan, 0)
    return _difference(told[0], told[-1])
