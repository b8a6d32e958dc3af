"""One sealed set from its plan to its tables; what is done is kept, so that a set which was stopped goes on."""

import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from benchmarks.blind.answers import Found, Task, code
from benchmarks.blind.assets.families import available, made
from benchmarks.blind.sealing import Key, seal
from benchmarks.blind.selectors import answer
from benchmarks.blind.sound import sound_tables
from benchmarks.blind.tables import all_tables
from benchmarks.seals import open_keys
from benchmarks.tables import whole_lines


@dataclass(frozen=True)
class Plan:
    """A set of cases.

    Attributes
    ----------
    seed, count, jobs
        of the set; processes.
    without
        share of the cases diagnosed without commissioning run too.
    families
        of assets, each with its share of the cases.
    twin_mesh
        refinement of the twin.
    strata
        of `cases.SETS`: "main", or "sound" for assets with which nothing is wrong.
    selectors
        of `selectors.SELECTORS`; the first has all tables, the others a column in each.
    """

    seed: int
    count: int = 600
    jobs: int = 2
    without: float = 1.0
    families: tuple[str, ...] = available()
    twin_mesh: float = 1.0
    strata: str = "main"
    selectors: tuple[str, ...] = ("diagnosis", "plain")


def run(folder: Path, plan: Plan) -> str:
    """Seal, diagnose, open, score; return the tables in Markdown, which also stand in `folder/tables.md`."""
    folder.mkdir(parents=True, exist_ok=True)
    keys = _keys(folder)
    plan = _settled(folder, plan)
    clock = [time.time()]
    if not (folder / "seals.json").exists():
        _seal(folder, keys, plan)
    clock.append(time.time())
    found = {selector: _answered(folder, plan, selector) for selector in plan.selectors}
    clock.append(time.time())
    answers: dict[str, Key] = open_keys(folder, keys)
    tables = _tables(found, answers, plan)
    clock.append(time.time())
    text = "\n\n".join([_heading(plan, len(answers), clock), *tables])
    (folder / "tables.md").write_text(text + "\n")
    return text


def _keys(folder: Path) -> Path:
    """Return the file of the answers of a set."""
    return folder.resolve().parent / f"{folder.name}.keys.json"


def _settled(folder: Path, plan: Plan) -> Plan:
    """Return the plan of a set that was begun, otherwise write this one down; only the number of processes may differ.

    Raises
    ------
    SystemExit
        the set that was begun has another plan.
    """
    path = folder / "plan.json"
    if not path.exists():
        path.write_text(json.dumps(asdict(plan)))
        return plan
    begun = plan_of(json.loads(path.read_text()), plan.jobs)
    other = [name for name, value in asdict(begun).items() if value != asdict(plan)[name]]
    if other:
        raise SystemExit(
            f"{folder} holds a set that was begun with {other[0]} {asdict(begun)[other[0]]!r}; got "
            f"{asdict(plan)[other[0]]!r}; give the same plan, or another folder (--out)"
        )
    return begun


def plan_of(held: Mapping[str, Any], jobs: int) -> Plan:
    """Return the plan that a file holds, with another number of processes."""
    lists = {name: tuple(held[name]) for name in ("families", "selectors")}
    return Plan(**{**held, **lists, "jobs": jobs})


def begun_seed(folder: Path) -> int | None:
    """Return the seed of the set that was begun in a folder, None where there is none."""
    path = folder / "plan.json"
    return int(json.loads(path.read_text())["seed"]) if path.exists() else None


def _seal(folder: Path, keys: Path, plan: Plan) -> None:
    assets = [made(name, plan.seed, keys) for name in plan.families]
    seal(folder, keys, plan.seed, plan.count, assets, plan.strata)


def _answered(folder: Path, plan: Plan, selector: str) -> list[Found]:
    """Return all answers of a selector; each case is one line, written when it is done, and is not asked again."""
    path = folder / f"{selector}.jsonl"
    cases = _written(path)
    done = {lines[0]["name"] for lines in cases}
    tasks = [replace(task, selector=selector) for task in _tasks(folder, plan) if task.name not in done]
    with path.open("a") as file:
        for found in _answers(tasks, plan.jobs):
            file.write(json.dumps(found) + "\n")
            file.flush()
            cases.append(found)
            if len(cases) % 50 == 0:
                print(f"{len(cases)} cases asked of {selector}", file=sys.stderr)
    return [line for found in sorted(cases, key=lambda found: found[0]["name"]) for line in found]


def _written(path: Path) -> list[list[Found]]:
    """Return the cases that an earlier run finished; a last line that was cut off is taken out of the file."""
    return [json.loads(line) for line in whole_lines(path)]


def _answers(tasks: Sequence[Task], jobs: int) -> Iterator[list[Found]]:
    if jobs == 1:
        yield from map(answer, tasks)
        return
    with ProcessPoolExecutor(jobs) as pool:
        for future in as_completed([pool.submit(answer, task) for task in tasks]):
            yield future.result()


def _tasks(folder: Path, plan: Plan) -> list[Task]:
    """Return one task per case; unknown to it are seed, truths and keys."""
    paths = sorted(folder.glob("*/campaigns/*.csv"), key=lambda path: path.stem)
    asked_bare = round(plan.without * len(paths))
    return [
        Task(path.parents[1].resolve(), path.stem, plan.twin_mesh, without=k < asked_bare)
        for k, path in enumerate(paths)
    ]


def _tables(found: Mapping[str, Sequence[Found]], answers: Mapping[str, Key], plan: Plan) -> list[str]:
    """Return all tables."""
    told = {_called(selector): [(f, answers[f["name"]]) for f in part] for selector, part in found.items()}
    return sound_tables(told) if plan.strata == "sound" else all_tables(told)


def _called(selector: str) -> str:
    """Return the heading of a selector's column."""
    return "plain selector" if selector == "plain" else selector


def _heading(plan: Plan, count: int, clock: Sequence[float]) -> str:
    seconds = [f"{what} in {b - a:.0f} s" for what, a, b in zip(_STEPS, clock, clock[1:], strict=False)]
    return (
        f"Seed {plan.seed}, {count} cases, code {code()}, {plan.jobs} processes; twin's mesh "
        f"{plan.twin_mesh:g}; {', '.join(seconds)}."
    )


_STEPS = ("sealed", "diagnosed", "scored")
