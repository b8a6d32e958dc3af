"""Optimal two-feature trees of depth 2, proven: published strains and UCI sets, objective = misclassified samples.

`python -m benchmarks.run oblique_trees --limit 300 --threads 2`. A sample of n published rows (seed 0) is
that of `default_rng(n).permutation(1750)[:n]`. Beside each result stands what a one-thread prototype of the same idea
needed on its own rows of the same sets, so optima may differ by a few.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from benchmarks.data import Table, uci
from benchmarks.two_feature import measure, strains
from octmip.problem import Problem


def _strains(target: str, n_samples: int, n_gauges: int) -> tuple[str, Callable[[], Table]]:
    name = f"published {target}, {n_samples} x {n_gauges}"
    return name, partial(strains, target, n_samples, n_gauges)


# Name, table, the prototype's axis-aligned optimum -> two-feature optimum, its CPU seconds.
CASES: tuple[tuple[tuple[str, Callable[[], Table]], str, str], ...] = (
    (_strains("mu1", 175, 2), "34 -> 27", ".01"),
    (_strains("mu1", 350, 2), "62", ".00"),
    (_strains("mu1", 1750, 2), "354 -> 352", "5.8"),
    (_strains("mu1", 175, 20), "27", ".35"),
    (_strains("mu1", 350, 20), "62", ".32"),
    (_strains("mu2", 175, 2), "111 -> 105", "1.1"),
    (_strains("mu2", 350, 2), "243 -> 236", "2.9"),
    (_strains("mu2", 875, 2), "650 -> 626", "25"),
    (_strains("mu2", 1750, 2), "1340 -> 1307", "89-125"),
    (_strains("mu2", 175, 5), "109 -> 100", "16"),
    (("iris", partial(uci, "iris")), "6 -> 2", ".02"),
    (("wine", partial(uci, "wine")), "6 -> 1", ".26"),
    (("seeds", partial(uci, "seeds")), "11 -> 3", ".19"),
    (("vertebral-column-3c", partial(uci, "vertebral-column-3c")), "50 -> 32", "5.4"),
    (("banknote-authentication", partial(uci, "banknote-authentication")), "100 -> 9", ".54"),
    (_strains("mu1", 1750, 5), "340..352", "open at 60"),
    (_strains("mu1", 1750, 20), "340..352", "open at 60"),
    (
        ("breast-cancer-wisconsin-diagnostic", partial(uci, "breast-cancer-wisconsin-diagnostic")),
        "<= 13",
        "open at 60",
    ),
)


def results(limit: float, threads: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Yield a line for each case and number of threads."""
    for (name, table), prototype, seconds in CASES:
        data = table()
        problem = Problem(data.features, data.labels, depth=2, split="hyperplane", split_size=2)
        for count in threads:
            yield (
                {"size": name, "seed": 0, "threads": count, "limit": limit}
                | measure(problem, limit, count)
                | {
                    "prototype": prototype,
                    "prototype_cpu_seconds": seconds,
                }
            )


def summary(lines: Sequence[dict[str, Any]]) -> str:
    """Return the table: optimum, boxes and CPU seconds beside the prototype's."""
    head = "| case | threads | objective | bound | boxes | CPU s | prototype | prototype, CPU s |"
    rows = [
        f"| {line['size']} | {line['threads']} | {line['objective']:g} | {line['bound']:g} | {line['n_nodes']} "
        f"| {line['cpu_seconds']:.2f} | {line['prototype']} | {line['prototype_cpu_seconds']} |"
        for line in lines
    ]
    return "\n".join([head, "|" + "---|" * 8, *rows])
