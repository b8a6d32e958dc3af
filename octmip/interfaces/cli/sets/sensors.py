"""Show what each sensor is worth: `octmip.interfaces.cli.options.sensors` says how the command is called."""

import argparse
import math
from functools import partial
from typing import Any

from octmip.formats.tree_file import finite_or_none
from octmip.input.names import shown
from octmip.interfaces.cli.answer import print_json, print_notes, printable, then_written
from octmip.interfaces.cli.arguments import limits_of
from octmip.interfaces.cli.picture import check_picture, write_picture
from octmip.interfaces.cli.samples.table_problem import TableProblem, read_problem
from octmip.interfaces.cli.sets.amount import Amount, amount_of
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.report.markdown import markdown_table
from octmip.interfaces.report.text import number
from octmip.trees.near_sets import Role, SensorRole, SensorRoles, Without, sensor_roles
from octmip.trees.nodes.tree_nodes import encode_tree
from octmip.trees.solver import solve

FORMAT = "octmip sensor roles"
VERSION = 1
MOST_PAIRS = 20  # on the screen, the most expensive ones
MOST_NAMED = 8  # sensors of one role in the last line


def run(arguments: argparse.Namespace) -> int:
    """Weigh, show, draw."""
    limits, amount = limits_of(arguments), amount_of(arguments.within)
    check_picture(arguments.out)
    asked = read_problem(arguments)
    with StageLine("weighing sensors"):
        found = sensor_roles(
            asked.problem,
            _within(asked, amount, arguments),
            limits,
            pairs=arguments.pairs,
            seed=arguments.seed,
            n_jobs=arguments.threads,
        )
    with then_written(arguments.out, partial(_draw, found=found), is_quiet=True):
        if arguments.json:
            print_json(as_json(found) | {"threads": arguments.threads, "notes": list(asked.notes)})
        else:
            print_notes(asked.notes)
            print(printable(_text(found)))
    return 0


def _within(asked: TableProblem, amount: Amount, arguments: argparse.Namespace) -> float:
    if amount.relative is None or amount.relative == 0:
        return amount.within or 0.0
    best = solve(asked.problem, "exact", limits_of(arguments), seed=arguments.seed, n_jobs=arguments.threads)
    return amount.above(best.objective)


def as_json(found: SensorRoles) -> dict[str, Any]:
    """Return the JSON object of all sensors; its schema is octmip/interfaces/schemas/sensors.schema.json."""
    return {
        "format": FORMAT,
        "format_version": VERSION,
        "objective": found.solution.objective,
        "bound": finite_or_none(found.solution.bound),
        "limit": float(found.limit),
        "is_proven": found.is_proven,
        "sensors": [_role_json(found, role) for role in found.roles],
        "pairs": [_loss_json(found, loss) for loss in found.pairs],
        "stop": str(found.stop),
        "seconds": found.seconds,
    }


def _role_json(found: SensorRoles, role: SensorRole) -> dict[str, Any]:
    return {
        "sensor": role.sensor,
        "role": str(role.role),
        "without": _loss_json(found, role.without),
        "forced": finite_or_none(role.forced),
        "forced_is_proven": role.forced_is_proven,
        "instead": list(role.instead),
    }


def _loss_json(found: SensorRoles, loss: Without) -> dict[str, Any]:
    problem = found.problem
    return {
        "sensors": list(loss.sensors),
        "objective": loss.objective,
        "bound": finite_or_none(loss.bound),
        "is_proven": loss.is_proven,
        "reads": list(loss.read),
        "tree": encode_tree(loss.tree, problem.samples.feature_names, problem.samples.class_names),
    }


def _text(found: SensorRoles) -> str:
    best = found.solution.objective
    rows = [
        {
            "sensor": shown(role.sensor),
            "role": str(role.role),
            "without": _figure(role.without.objective, role.without.is_proven),
            "price": number(role.without.objective - best),
            "forced": _figure(role.forced, role.forced_is_proven),
            "instead": ", ".join(map(shown, role.instead)),
        }
        for role in found.roles
    ]
    parts = [
        f"{_best(found)}, near-optimal up to {number(float(found.limit))}",
        markdown_table(rows, ("sensor", "role", "without", "price", "forced", "instead")),
    ]
    if found.pairs:
        parts.append(_pairs(found))
    return "\n\n".join([*parts, _verdict(found)])


def _best(found: SensorRoles) -> str:
    best = number(found.solution.objective)
    if found.solution.is_optimal:
        return f"optimum {best}"
    return f"optimum not proven: best tree {best}, bound {number(found.solution.bound)}"


def _pairs(found: SensorRoles) -> str:
    best = found.solution.objective
    expensive = sorted(found.pairs, key=lambda loss: -loss.objective)[:MOST_PAIRS]
    rows = [
        {
            "without both": ", ".join(map(shown, loss.sensors)),
            "objective": _figure(loss.objective, loss.is_proven),
            "price": number(loss.objective - best),
        }
        for loss in expensive
    ]
    more = len(found.pairs) - len(rows)
    return markdown_table(rows) + (f"\nand {more} pairs that cost no more" if more > 0 else "")


def _figure(value: float, is_proven: bool) -> str:
    if math.isinf(value):
        return "no tree" if is_proven else "?"
    return number(value) + ("" if is_proven else "?")


def _verdict(found: SensorRoles) -> str:
    if not found.is_proven:
        return f"Not all proven (stop: {found.stop}): figures with a question mark are of the best trees found."
    named = {role: [shown(r.sensor) for r in found.roles if r.role is role] for role in Role}
    return "Proven: " + "; ".join(_counted(role, names) for role, names in named.items() if names) + "."


def _counted(role: Role, names: list[str]) -> str:
    return f"{len(names)} {role}" + (f" ({', '.join(names)})" if len(names) <= MOST_NAMED else "")


def _draw(path: str, found: SensorRoles) -> None:
    from octmip.interfaces.plot import sensors_figure

    write_picture(path, sensors_figure(found))
