"""A model that takes seconds to answer, asked a stated number of times: what stands for it in a diagnosis.

About every load m of run and campaign, with x the parameters and the loads, h their steps and d = x - x_m,

    f(x) = f(x_m) + sum_k (b_mk d_k + c_mk d_k^2),

b and c by f at x_m + h_k and, as far as the budget reaches, at x_m - h_k (else c = 0). Loads for which it does not
reach have the b and c that a plane over states and loads, fitted to those of the others, has there. Each answer is
kept on disk as it comes, where a file is given.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, OctmipError, TwinError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.doors.function import Function, FunctionTwin
from octmip.input.named_arrays import by_name
from octmip.twin import amounts_of

Floats = NDArray[np.float64]
Numbers = dict[str, float]
Point = tuple[float, ...]
"""Values of all parameters, states and loads, in the order of the card."""

OF_RANGE, OF_LOAD = 0.15, 0.05
"""Step of a parameter over the width of its range, and of a load over its greatest amount."""
SAME = 1e-6
"""Relative difference up to which two answers to one question are the same."""
BEYOND = 0.5
"""How far a load may lie from the nearest that was asked, over the range of all."""


@dataclass(frozen=True, slots=True)
class Budget:
    """How often a model may be asked, and how.

    Attributes
    ----------
    calls
        questions; answers on disk do not count.
    jobs
        questions at the same time, as joblib counts them: threads, or what `joblib.parallel_config` says.
    answers
        file to which each answer is added and from which earlier ones are taken; None: none.
    progress
        called with the number of answers and of all that are wanted.

    Raises
    ------
    DataError
        no positive number of calls, or no job.

    Examples
    --------
    >>> Budget(calls=60, answers="answers.jsonl").calls
    60
    """

    calls: int
    jobs: int = 1
    answers: str | Path | None = None
    progress: Callable[[int, int], None] | None = None

    def __post_init__(self) -> None:
        if self.calls < 1:
            raise DataError(f"the budget is {self.calls} calls of the model; expected 1 or more; give some")
        if self.jobs == 0:
            raise DataError("the budget has 0 jobs; expected 1 or more, or -1 for every core; give some")


def within(twin: FunctionTwin, campaigns: Sequence[Campaign], budget: Budget) -> tuple[FunctionTwin, list[str]]:
    """Return a twin made of a budget of answers of another, and notes for the reader.

    A parameter to whose steps the model has no answer is left out, and named.

    Raises
    ------
    DataError
        a budget that does not reach, a state that is not known, a file of another model's answers.
    TwinError
        the model fails at its nominal parameters.
    """
    asked = _Questions(twin, budget)
    bases = list(dict.fromkeys(point for campaign in campaigns for point in asked.of_cells(campaign)))
    steps = _steps(twin, np.array(bases))
    settings = _settings(np.array(bases)[:, len(twin.card.ranges) :])
    asked.n_new = sum(point in twin.answers for point in bases)  # asked for a moment ago, when the files were read
    least = min(len(bases), settings.shape[1] + 1)
    asked.check(bases, [_moved(bases[k], c, h) for k in _spread(len(bases), least) for c, h in steps.items()])
    asked.compare(bases[0])
    here = np.array([_answered(answer) for answer in asked.answers(bases, len(bases) * (1 + 2 * len(steps)))])
    n_sloped = max(least, min(len(bases), asked.n_left // max(1, len(steps))))
    at = _spread(len(bases), n_sloped)
    total = len(asked.known) + 2 * len(steps) * len(at)
    ends = {c: [(h, asked.answers([_moved(bases[k], c, h) for k in at], total))] for c, h in steps.items()}
    for column, size in sorted(steps.items(), key=lambda step: not _has_failed(ends[step[0]][0][1])):
        if asked.n_left >= len(at):
            ends[column].append((-size, asked.answers([_moved(bases[k], column, -size) for k in at], total)))
    of_all = settings @ np.linalg.pinv(settings[at])
    of_all[at] = np.eye(len(at))
    columns, notes = [], []
    for column, size in steps.items():
        good = [(h, np.array(rows) - here[at]) for h, rows in ends[column] if not _has_failed(rows)]
        if good:
            slope = sum(rise / h for h, rise in good) / len(good)
            bend = sum(rise for _, rise in good) / (2.0 * size**2) if len(good) == 2 else np.zeros_like(slope)
            columns.append((column, of_all @ slope, of_all @ bend))
        else:
            error = next(r for _, rows in ends[column] for r in rows if isinstance(r, TwinError))
            notes.append(f"The parameter {asked.names[column]} is left out: {error}.")
    stand_in = _stand_in(asked, np.array(bases), here, columns)
    left = {name: own for name, own in twin.card.ranges.items() if asked.names.index(name) in [c for c, *_ in columns]}
    kept = [effect for name, effect in twin.effects.items() if name not in twin.card.ranges]
    told = f"The model answered {asked.n_new} questions (budget {budget.calls}); all else follows from these answers."
    return FunctionTwin(stand_in, replace(twin.card, parameters=left), kept), [told, *notes]


def _steps(twin: FunctionTwin, bases: Floats) -> dict[int, float]:
    """Return the step of each parameter and load by its column; one that keeps inside the range of a parameter."""
    card, found = twin.card, {}
    for k, own in enumerate(card.ranges.values()):
        size = OF_RANGE * (own.high - own.low)
        found[k] = size if own.nominal + size <= own.high else -size
    first = len(card.ranges) + len(card.states)
    for k in range(first, first + len(card.loads)):
        found[k] = OF_LOAD * (float(np.abs(bases[:, k]).max()) or 1.0)
    return found


def _settings(inputs: Floats) -> Floats:
    """Return states and loads (m, n) that vary, over their ranges, beside a column of ones."""
    varied = inputs[:, np.ptp(inputs, axis=0) > 0.0]
    return np.column_stack([np.ones(len(inputs)), varied / np.maximum(np.ptp(varied, axis=0), 1e-300)])


def _spread(n: int, n_chosen: int) -> NDArray[np.int64]:
    """Return the numbers (n_chosen,) of some of n, the first and the last among them."""
    return np.unique(np.linspace(0, n - 1, n_chosen).round().astype(np.int64))


def _moved(point: Point, column: int, size: float) -> Point:
    return (*point[:column], point[column] + size, *point[column + 1 :])


def _has_failed(rows: Sequence[Floats | TwinError]) -> bool:
    return any(isinstance(row, TwinError) for row in rows)


def _answered(answer: Floats | TwinError) -> Floats:
    if isinstance(answer, TwinError):
        raise answer
    return answer


class _Questions:
    """The questions to a model, and its answers."""

    def __init__(self, twin: FunctionTwin, budget: Budget) -> None:
        card = twin.card
        self.twin, self.budget, self.n_new = twin, budget, 0
        self.names = [*card.ranges, *card.states, *card.loads]
        self.on_disk: dict[Point, Floats] = _read(budget.answers, self.names, twin.gauges) if budget.answers else {}
        self.known = {**self.on_disk, **twin.answers}

    @property
    def n_left(self) -> int:
        """Questions that the budget still allows."""
        return self.budget.calls - self.n_new

    def of_cells(self, campaign: Campaign) -> list[Point]:
        """Return the points at which a campaign reads, the parameters nominal."""
        nominal, found = [own.nominal for own in self.twin.card.ranges.values()], []
        for cell in campaign.cells:
            state = dict(zip(campaign.parameters, cell.state.tolist(), strict=True))
            if not cell.is_known:
                raise DataError(
                    f"a state of test {cell.test!r} is unknown; expected a known one beside a budget; fill it in"
                )
            states = [state.get(name, 0.0) for name in self.twin.card.states]
            found.append((*nominal, *states, *amounts_of(cell.load)))
        return found

    def check(self, bases: Sequence[Point], moved: Sequence[Point]) -> None:
        """Refuse a budget that does not reach for one step of each parameter and load at the fewest loads."""
        least = self.n_new + sum(point not in self.known for point in dict.fromkeys([*bases, *moved]))
        if self.budget.calls < least:
            raise DataError(
                f"the budget is {self.budget.calls} calls of the model; expected {least} or more: one for each of "
                f"{len(bases)} loads and states, and {len(moved)} for a step of each parameter and load at the fewest "
                "that tell their slopes; allow them"
            )

    def compare(self, point: Point) -> None:
        """Refuse answers on disk of a model that has changed since, by asking one of them again.

        Raises
        ------
        DataError
            the model answers something else now.
        """
        if point not in self.on_disk:
            return
        before = self.on_disk[point]
        now = self.twin.answers.get(point)
        if now is None:
            del self.known[point]
            now = _answered(self.answers([point], len(self.known) + 1)[0])
        if not np.allclose(now, before, rtol=SAME, atol=SAME * float(np.abs(before).max())):
            raise DataError(
                f"{self.budget.answers} holds answers of another model: {before.tolist()} where it answers "
                f"{now.tolist()} now; expected the same; give another file"
            )

    def answers(self, points: Sequence[Point], total: int) -> list[Floats | TwinError]:
        """Return the answers (n_readings,) at points, or why there is none; `total` is all that may be wanted."""
        from joblib import Parallel, delayed  # only here: every command would wait for it

        new = [point for point in dict.fromkeys(points) if point not in self.known]
        ask = delayed(_ask)
        card = self.twin.card
        jobs = Parallel(n_jobs=self.budget.jobs, return_as="generator", prefer="threads")
        found: dict[Point, Floats | TwinError] = {}
        asked = (ask(self.twin.function, card.readings, *self._split(point)) for point in new)
        for point, answer in zip(new, jobs(asked), strict=True):
            self.n_new += 1
            found[point] = answer
            if not isinstance(answer, TwinError):
                self.known[point] = answer
                self._keep(point, answer)
            if self.budget.progress is not None:
                self.budget.progress(len(self.known), max(total, len(self.known)))
        return [found[point] if point in found else self.known[point] for point in points]

    def _split(self, point: Point) -> tuple[Numbers, Numbers]:
        named = dict(zip(self.names, point, strict=True))
        loads = {name: named.pop(name) for name in self.twin.card.loads}
        return named, loads

    def _keep(self, point: Point, answer: Floats) -> None:
        if self.budget.answers is not None:
            with Path(self.budget.answers).open("a") as file:
                file.write(json.dumps({"asked": point, "answer": answer.tolist()}) + "\n")


def _ask(function: Function, readings: Sequence[str], parameters: Numbers, loads: Numbers) -> Floats | TwinError:
    """Return a model's answer, or what it raised."""
    at = ", ".join(f"{name} {value:g}" for name, value in {**parameters, **loads}.items())
    try:
        rows, _ = by_name(function(parameters, loads), tuple(readings), "the model's answer")
    except OctmipError as error:
        return TwinError(f"{error} (at {at})")
    except Exception as error:
        return TwinError(f"the model raised {type(error).__name__} at {at}: {error}")
    if rows.shape != (1, len(readings)) or not np.isfinite(rows).all():
        return TwinError(f"the model answered {rows.tolist()} at {at}; expected {len(readings)} finite numbers")
    return np.asarray(rows[0])


def _read(path: str | Path, names: Sequence[str], readings: Sequence[str]) -> dict[Point, Floats]:
    """Return the answers in a file, which is begun where it is not there; a line that was cut off is none."""
    file, head = Path(path), {"inputs": list(names), "readings": list(readings)}
    if not file.exists():
        file.write_text(json.dumps(head) + "\n")
        return {}
    text = file.read_text(errors="replace")
    lines = text.splitlines()
    try:
        is_alike = json.loads(lines[0]) == head
    except (IndexError, ValueError):
        is_alike = False
    if not is_alike:
        raise DataError(
            f"{path} holds no answers of this model; expected those for {list(names)} and {list(readings)}; give "
            "another file"
        )
    if not text.endswith("\n"):  # what was cut off stays a line of its own
        with file.open("a") as more:
            more.write("\n")
    found = {}
    for line in lines[1:]:
        try:
            content = json.loads(line)
            asked, answer = tuple(map(float, content["asked"])), np.array(content["answer"], dtype=np.float64)
        except (ValueError, KeyError, TypeError):
            continue
        if len(asked) == len(names) and answer.shape == (len(readings),):
            found[asked] = answer
    return found


def _stand_in(asked: _Questions, bases: Floats, here: Floats, moved: Sequence[tuple[int, Floats, Floats]]) -> Function:
    """Return the function that stands for a model.

    Parameters
    ----------
    asked
        the questions.
    bases, here
        (m, n_inputs) and (m, n_readings) where the model was asked, and its answers there.
    moved
        columns that were moved, with their slopes and bends (m, n_readings).
    """
    ranges, extent = asked.twin.card.ranges, np.ptp(bases, axis=0)
    extent = np.where(extent > 0.0, extent, np.maximum(np.abs(bases).max(axis=0), 1.0))
    columns = [column for column, *_ in moved]
    slopes, bends = (np.array([one[k] for one in moved]).reshape(len(moved), *here.shape) for k in (1, 2))
    fixed = {name: own.nominal for k, (name, own) in enumerate(ranges.items()) if k not in columns}
    settings = slice(len(ranges), None)

    def function(parameters: Mapping[str, float], loads: Mapping[str, float]) -> Floats:
        given = {**fixed, **parameters, **loads}
        point = np.array([given[name] for name in asked.names])
        apart = np.linalg.norm(((point - bases) / extent)[:, settings], axis=1)
        base = int(np.argmin(apart))
        if apart[base] > BEYOND:
            named = ", ".join(f"{name} {given[name]:g}" for name in asked.names[settings])
            raise TwinError(f"the model was not asked near {named}: its budget went to the loads of run and campaign")
        step = (point - bases[base])[columns]
        return np.asarray(here[base] + step @ slopes[:, base] + step**2 @ bends[:, base])

    return function
