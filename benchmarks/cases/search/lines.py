"""Searches that meet the proven optimum of two-feature trees of depth 2 within so many CPU seconds.

`python -m benchmarks.run search_lines --limit 0.4`: the limit is that of one search, in CPU seconds of one thread; six
seeds of the search, or `SEARCH_SEEDS`. The optimum is the two-feature solver's, proven in the same run.
"""

import os
from collections.abc import Iterator, Sequence

from benchmarks.cpu import cpu_limit
from benchmarks.tables import Line, markdown
from benchmarks.two_feature import CASES
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.problem import Problem

N_SEEDS = int(os.environ.get("SEARCH_SEEDS", "6"))
LEFT_OUT = ("breast-cancer-wisconsin-diagnostic", "published mu1, 1750 x 20")  # no proof, or a long one
ENDLESS = 10**6


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each case with what every seed found."""
    for name, table in CASES:
        if name in LEFT_OUT:
            continue
        data = table()
        problem = Problem(data.features, data.labels, depth=2, split="hyperplane", split_size=2)
        best = two_feature_branch_and_bound(problem, n_jobs=max(threads)).objective
        searches = (
            local_search(problem, seed=s, options=SearchOptions(restarts=ENDLESS), **cpu_limit(limit))
            for s in range(N_SEEDS)
        )
        yield {"size": name, "seed": 0, "limit": limit, "optimum": best, "found": [s.objective for s in searches]}


def summary(lines: Sequence[Line]) -> str:
    """Return the table of hits, and their sum with the mean excess over the optimum."""
    rows = []
    n_hits = n_searches = 0
    excess = 0.0
    for line in lines:
        found, best = line["found"], line["optimum"]
        hits = sum(objective <= best for objective in found)
        rows.append([line["size"], f"{best:g}", ", ".join(f"{o:g}" for o in found), f"{hits} / {len(found)}"])
        n_hits, n_searches = n_hits + hits, n_searches + len(found)
        excess += sum((objective - best) / max(best, 1.0) for objective in found)
    share = (
        f"{n_hits} of {n_searches} searches at the optimum, {100 * excess / max(n_searches, 1):.1f} % above it in mean."
    )
    return "\n".join([markdown(["case", "optimum", "found", "hits"], rows), "", share])
