"""Count all trees near the optimum: `octmip.interfaces.cli.options.near_optimal` says how the command is called."""

import argparse
from typing import Any

from octmip.errors import DataError
from octmip.formats.columns import Columns
from octmip.input.names import shown
from octmip.interfaces.cli.answer import ProgressLine, print_json, print_notes, printable
from octmip.interfaces.cli.arguments import limits_of
from octmip.interfaces.cli.samples.table_problem import TableProblem, read_problem
from octmip.interfaces.cli.sets.amount import amount_of
from octmip.interfaces.report.markdown import markdown_table
from octmip.interfaces.report.text import number, percent, tree_text
from octmip.trees.answer.interruption import held_back, is_heard
from octmip.trees.near_sets import NearOptimalSet, NearTree, RootInterval, near_optimal
from octmip.trees.nodes.tree_nodes import encode_tree

FORMAT = "octmip near-optimal set"
VERSION = 1
MOST_SHOWN = 20  # sets of sensors on the screen
MOST_TREES = 1000  # of --best and --sample


def run(arguments: argparse.Namespace) -> int:
    """Count and show."""
    limits, amount = limits_of(arguments), amount_of(arguments.within)
    for name in ("best", "sample"):
        if not 0 <= getattr(arguments, name) <= MOST_TREES:
            raise DataError(f"--{name} is {getattr(arguments, name)}; expected 0 to {MOST_TREES} trees")
    asked = read_problem(arguments)
    with ProgressLine() as progress:
        found = near_optimal(
            asked.problem,
            amount.within,
            amount.relative,
            limits,
            by_sets=arguments.sets,
            seed=arguments.seed,
            n_jobs=arguments.threads,
            progress=progress,
        )
    best, samples = _chosen(found, arguments)
    with held_back():
        if arguments.json:
            print_json(as_json(found, best, samples) | {"threads": arguments.threads, "notes": list(asked.notes)})
        else:
            _show(asked, found, best, samples, arguments.sample > 0)
    return 0


def _chosen(found: NearOptimalSet, arguments: argparse.Namespace) -> tuple[list[NearTree], list[NearTree]]:
    """Return the best trees and those drawn, as many as were asked for; none that a signal did not leave time for."""
    best: list[NearTree] = []
    try:
        if is_heard():
            return [], []
        best = found.best(arguments.best)
        return best, found.sample(arguments.sample, arguments.seed) if found.is_complete else []
    except KeyboardInterrupt:
        return best, []


def as_json(found: NearOptimalSet, best: list[NearTree], samples: list[NearTree]) -> dict[str, Any]:
    """Return the JSON object of a set; its schema is octmip/interfaces/schemas/near_optimal.schema.json."""
    names = found.problem.samples.feature_names
    by_sets = found.by_sensors
    return {
        "format": FORMAT,
        "format_version": VERSION,
        "optimum": None if found.optimum is None else float(found.optimum),
        "limit": None if found.limit is None else float(found.limit),
        "is_complete": found.is_complete,
        "trees": found.trees,
        "trees_at_least": found.trees_at_least,
        "predictions": found.predictions,
        "predictions_note": found.predictions_note,
        "spectrum": [{"objective": float(cost), "trees": n} for cost, n in found.spectrum],
        "by_root": [{"feature": name or None, "trees": n} for name, n in found.by_root.items()],
        "by_sensors": None if by_sets is None else [{"sensors": list(read), "trees": n} for read, n in by_sets.items()],
        "roots": [_interval_json(interval, names) for interval in found.roots],
        "open": [_interval_json(interval, names) for interval in found.open],
        "best": [_tree_json(found, entry) for entry in best],
        "samples": [_tree_json(found, entry) for entry in samples],
        "stop": str(found.stop),
        "seconds": found.seconds,
        "n_nodes": found.n_nodes,
    }


def _interval_json(interval: RootInterval, names: tuple[str, ...]) -> dict[str, Any]:
    ends = {"first": interval.first, "last": interval.last, "missing": interval.missing}
    return {"feature": names[interval.feature], **ends, "n_cuts": interval.n_cuts, "trees": interval.trees}


def _tree_json(found: NearOptimalSet, entry: NearTree) -> dict[str, Any]:
    problem = found.problem
    tree = encode_tree(entry.tree, problem.samples.feature_names, problem.samples.class_names)
    return {"objective": entry.objective, "sensors": list(problem.shape.sensors_used(entry.tree)), "tree": tree}


def _show(
    asked: TableProblem, found: NearOptimalSet, best: list[NearTree], samples: list[NearTree], wants_samples: bool
) -> None:
    print_notes(asked.notes)
    print(_summary(found))
    print(f"predictions: {_predictions(found)}\n")
    print(printable(_roots(found, asked.preparation.columns)))
    if found.by_sensors is not None:
        print(printable(f"\n{_sets(found)}"))
    for title, trees in (("best", best), ("sample", samples)):
        for k, entry in enumerate(trees, 1):
            problem, columns = asked.problem, asked.preparation.columns
            words = tree_text(entry.tree, problem.samples.feature_names, problem.samples.class_names, None, columns)
            print(printable(f"\n{title} {k}, objective {number(entry.objective)}\n{words}"))
    print(f"\n{_verdict(found, wants_samples)}")


def _predictions(found: NearOptimalSet) -> str:
    return found.predictions_note if found.predictions is None else f"{found.predictions:,}, {found.predictions_note}"


def _summary(found: NearOptimalSet) -> str:
    if found.optimum is None or found.limit is None:
        return f"optimum not proven; trees counted for certain: {found.trees_at_least:,}"
    of_it = f"optimum {number(float(found.optimum))}, trees up to {number(float(found.limit))}"
    return f"{of_it}: {found.trees:,}" if found.trees is not None else f"{of_it}: at least {found.trees_at_least:,}"


def _roots(found: NearOptimalSet, columns: Columns) -> str:
    rows: list[dict[str, Any]] = []
    names = found.problem.samples.feature_names
    total = max(1, found.trees_at_least)
    if "" in found.by_root:
        rows.append(
            {"root": "(a leaf)", "trees": f"{found.by_root['']:,}", "share": percent(found.by_root[""] / total)}
        )
    order = {name: k for k, name in enumerate(found.by_root)}
    for interval in sorted(
        (*found.roots, *found.open),
        key=lambda i: (order.get(names[i.feature], len(order)), i.missing or "", i.first or 0),
    ):
        rows.append(
            {
                "root": shown(names[interval.feature]),
                "thresholds": _thresholds(interval, columns),
                "cuts": interval.n_cuts,
                "trees": "not counted" if interval.trees is None else f"{interval.trees:,}",
                "share": None if interval.trees is None else percent(interval.trees / total),
            }
        )
    return markdown_table(rows, ("root", "thresholds", "cuts", "trees", "share"))


def _thresholds(interval: RootInterval, columns: Columns) -> str:
    if interval.first is None or interval.last is None:
        return "missing?"
    column = columns.column_of(columns.features[interval.feature])
    first, last = column.number_text(interval.first), column.number_text(interval.last)
    span = first if interval.n_cuts == 1 else f"{first} to {last}"
    return span if interval.missing is None else f"{span}, missing {interval.missing}"


def _sets(found: NearOptimalSet) -> str:
    sets = found.by_sensors or {}
    total = max(1, found.trees_at_least)
    rows = [
        {"sensors": ", ".join(map(shown, read)) or "(none)", "trees": f"{n:,}", "share": percent(n / total)}
        for read, n in list(sets.items())[:MOST_SHOWN]
    ]
    more = len(sets) - len(rows)
    return markdown_table(rows, ("sensors", "trees", "share")) + (f"\nand {more} more sets" if more > 0 else "")


def _verdict(found: NearOptimalSet, wants_samples: bool) -> str:
    if found.trees is None:
        n_open = sum(interval.n_cuts for interval in found.open)
        no_sample = " No sample is drawn from it: it would not be uniform." if wants_samples else ""
        cuts = f"{n_open} cuts of the root are open, their trees not counted"
        return f"Not complete (stop: {found.stop}): {cuts}.{no_sample}"
    least, depth = sum(n for cost, n in found.spectrum if cost == found.optimum), found.problem.shape.depth
    trees = "1 tree" if found.trees == 1 else f"{found.trees:,} trees"
    return f"Proven: exactly {trees} of depth {depth} or less within the limit, {least:,} of them optimal."
