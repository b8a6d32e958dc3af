"""Every printed rule against `predict` on its own training rows: `python -m benchmarks.run printed_rules`, 5 minutes.

Random tables of numbers (seconds since 1970, latitudes, 1e-300 to 1e300, subnormals, integers, float32, values that
differ in their last bit), dates from days to nanoseconds with and without a time zone, durations, text and missing
cells; trees of every method, of classes and of numbers, with one feature in a split and with several. The words of the
tree, its drawing and its Solution are read back by `tests.oracles.printed_rules` and applied to the training rows
and to rows a last bit (or a microsecond) beside them.
"""

import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.tables import Line
from octmip import Problem, Solution, solve
from octmip.formats.columns import Columns
from octmip.formats.table.preparation import with_written_cuts
from octmip.interfaces.estimator.drawing import notebook_picture, words_of
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.nodes.tree import Node, predict, predict_values
from octmip.trees.question.losses import SquaredError
from tests.oracles.printed_rules import Row, answers, holds, number

CATEGORIES = ("yes-no", "subsets", "order")
TREES, CHUNK, STREAM = 10_000, 250, 20260305
TEXTS = ("red", "green", "blue", "dark red")


def _beside_bits(values: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    return np.concatenate([values, np.nextafter(values, -np.inf), np.nextafter(values, np.inf)])


NUMBERS: dict[str, Callable[[np.random.Generator, int], Any]] = {
    "epoch": lambda rng, n: 1.7e9 + 60 * rng.integers(0, 40, n),
    "milliseconds": lambda rng, n: 1.7e12 + rng.integers(0, 40, n),
    "latitude": lambda rng, n: np.round(48.1234 + 1e-7 * rng.integers(0, 30, n), 7),
    "wide": lambda rng, n: rng.choice((-1, 1), n) * 10.0 ** rng.integers(-300, 300, n) * rng.random(n),
    "subnormal": lambda rng, n: 5e-324 * rng.integers(-6, 6, n),
    "integer": lambda rng, n: rng.integers(-5, 12, n),
    "float32": lambda rng, n: rng.normal(size=n).astype(np.float32),
    "last bit": lambda rng, n: rng.choice(_beside_bits(_beside_bits(rng.normal(size=2))), n),
    "cents": lambda rng, n: np.round(rng.normal(1e6, 1e5, n), 2),
    "million": lambda rng, n: 1e6 + rng.integers(0, 9, n) / 8,
}
STEPS = {
    "day": pd.Timedelta(days=1),
    "minute": pd.Timedelta(minutes=1),
    "second": pd.Timedelta(seconds=1),
    "millisecond": pd.Timedelta(milliseconds=1),
    "microsecond": pd.Timedelta(microseconds=1),
    "nanosecond": pd.Timedelta(1, "ns"),
}
ZONES = (None, None, "UTC", "Europe/Berlin", "America/St_Johns", "+05:30")
Drawn = tuple["pd.Series[Any]", str, pd.Timedelta | None]


def drawn_column(rng: np.random.Generator, n: int) -> Drawn:
    """Return a random column, its kind, and the step to a value beside one of its own where it holds times."""
    kind = rng.choice(["number"] * 5 + ["date"] * 3 + ["duration", "text"])
    if kind == "number":
        kind = rng.choice(list(NUMBERS))
        return pd.Series(NUMBERS[kind](rng, n)), kind, None
    if kind == "text":
        return pd.Series(rng.choice(TEXTS[: rng.integers(2, 5)], n)), kind, None
    name = str(rng.choice(list(STEPS)))
    step = STEPS[name] * (1000 if name == "nanosecond" else 1)
    offsets = pd.to_timedelta(step * rng.integers(0, 60, n) * int(rng.choice([1, 7, 20])))
    unit: Literal["us", "ns"] = "ns" if name == "nanosecond" or rng.random() < 0.5 else "us"
    if kind == "duration":
        return pd.Series((offsets - step * 30).as_unit(unit)), f"{kind} in {name}s", step
    seconds = (0.0, float(rng.integers(-(10**9), 10**8)), rng.random() * 1e8)[rng.integers(3)]
    start = pd.Timestamp("2024-03-30") + pd.Timedelta(seconds, "s")
    if name == "nanosecond":
        start += pd.Timedelta(int(rng.integers(1, 1000)), "ns")
    start = start if name in ("millisecond", "microsecond", "nanosecond") else start.floor(step)
    zone = ZONES[rng.integers(len(ZONES))]
    stamps = pd.Series((start + offsets).as_unit(unit))
    return stamps if zone is None else stamps.dt.tz_localize("UTC").dt.tz_convert(zone), f"date to {name}s", step


def _beside(column: "pd.Series[Any]", step: pd.Timedelta | None) -> list["pd.Series[Any]"]:
    """Return the values beside those of a column: a last bit or a microsecond away, or the same."""
    if column.dtype.kind == "f":
        values = column.to_numpy()
        return [pd.Series(np.nextafter(values, column.dtype.type(end))) for end in (-np.inf, np.inf)]
    return [column if step is None else column + sign * pd.Timedelta(1, "us") for sign in (-1, 1)]


@dataclass(frozen=True, slots=True)
class Printed:
    """A tree over a random table: what it was found for, and the rows that it is asked about, the training's first."""

    kind: str
    problem: Problem
    solution: Solution
    columns: Columns
    frame: pd.DataFrame

    @property
    def tree(self) -> Node:
        """The tree."""
        return self.solution.tree


def drawn_tree(seed: int) -> Printed:
    """Return a random tree."""
    rng = np.random.default_rng([STREAM, seed])
    n = int(rng.integers(8, 40))
    drawn = [drawn_column(rng, n) for _ in range(rng.integers(1, 4))]
    frame = pd.DataFrame({f"c{k}": column for k, (column, _, _) in enumerate(drawn)})
    kind = drawn[0][1]
    is_number = all(column.dtype.kind in "iuf" and float(column.abs().max()) < 1e30 for column, _, _ in drawn)
    is_weighted = is_number and len(drawn) > 1 and rng.random() < 0.4
    predicts_numbers = not is_weighted and rng.random() < 0.3
    if not is_weighted and rng.random() < 0.3:
        frame = frame.mask(rng.random(frame.shape) < 0.15)
        frame = frame.loc[:, frame.notna().any().to_numpy()]
    late = (frame.iloc[:, 0].rank(na_option="top") > rng.integers(1, n)).to_numpy() ^ (rng.random(n) < 0.15)
    late[:2] = True, False
    columns = Columns.learn(frame, categories=str(rng.choice(CATEGORIES)), doubled=predicts_numbers)  # type: ignore[arg-type]
    asked: dict[str, Any] = {"depth": int(rng.integers(1, 4)), "feature_names": columns.feature_names}
    if predicts_numbers:
        target, asked["loss"] = np.round(late * 1234567.25 + rng.normal(size=n), 2), SquaredError()
    else:
        target, asked["takes_missing"] = np.where(late, "late", "early"), columns.lack_numbers
    if is_weighted:
        asked |= {"split": "hyperplane", "split_size": 2}
    problem = Problem(columns.encode(frame), target, **asked)
    method = str(rng.choice(["search"] if is_weighted or predicts_numbers else ["exact", "cart", "search"]))
    solution = with_written_cuts(problem, solve(problem, method), columns)  # type: ignore[arg-type]
    steps = {f"c{k}": step for k, (_, _, step) in enumerate(drawn)}
    table = pd.DataFrame({name: pd.concat(_beside(frame[name], steps[name])) for name in frame.columns})
    kind = f"several features, {kind}" if is_weighted else kind
    return Printed(kind, problem, solution, columns, pd.concat([frame, table], ignore_index=True))


def cells(frame: pd.DataFrame) -> list[Row]:
    """Return the rows of a table as what a person compares: numbers, instants, fractions of seconds, texts, None."""

    def plain(value: Any) -> Any:
        if value is None or value is pd.NaT or value != value:
            return None
        return Fraction(value.value, 10**9) if isinstance(value, pd.Timedelta) else value

    lists = {name: [plain(value) for value in frame[name].tolist()] for name in frame.columns}
    return [dict(zip(lists, row, strict=True)) for row in zip(*lists.values(), strict=True)]


def wrong_rows(seed: int) -> tuple[str, dict[str, int], int]:
    """Return the kind of a random tree, how many rows each of its printed forms answers wrongly, and all rows."""
    drawn = drawn_tree(seed)
    problem, tree, rows = drawn.problem, drawn.tree, cells(drawn.frame)
    features = drawn.columns.encode(drawn.frame, takes_missing=True)
    is_number = not problem.samples.n_classes
    told: list[Any] = predict_values(tree, features).tolist() if is_number else predict(tree, features).tolist()
    names = {name: label for label, name in enumerate(problem.samples.class_names)}
    said = {"words": answers(words_of(problem, tree, drawn.columns), rows), "drawing": _by_drawing(drawn, rows)}
    found = {
        form: sum(
            (number(text) if is_number else names[text]) != label for text, label in zip(texts, told, strict=True)
        )
        for form, texts in said.items()
    }
    indexed = [{f"x{j}": None if value != value else value for j, value in enumerate(row)} for row in features.tolist()]
    solution = answers(str(drawn.solution).split("\n\n", 1)[1], indexed)
    labels = [number(text) if is_number else int(text.removeprefix("class ")) for text in solution]
    found["solution"] = sum(a != b for a, b in zip(labels, told, strict=True))
    return drawn.kind, found, len(rows)


def _by_drawing(drawn: Printed, rows: Sequence[Row]) -> list[str]:
    """Return what the drawing answers: its nodes in preorder, each by its title; yes is the side that its edge says."""
    picture = notebook_picture(drawn.problem, drawn.solution, drawn.columns)
    svg = ET.fromstring(re.sub(r' xmlns="[^"]*"', "", re.search(r"<svg.*</svg>", picture, re.S)[0]))  # type: ignore[index]
    nodes = [group for group in svg if "node" in group.attrib["class"].split()]
    words = {int(edge.attrib["data-to"]): edge.findtext("text") for edge in svg if "data-to" in edge.attrib}
    titles = [group.findtext("title") or "" for group in nodes]
    ends = _ends(drawn.tree)

    def answer(index: int, row: Row) -> str:
        found = re.match(r"Answer: (.*?)\. \d", titles[index])
        if found:
            return found[1].translate({0x2212: "-"})
        question = titles[index].partition("? ")[0]
        goes_missing = "A missing value goes to no" in titles[index]
        asked = question.split(" ≤ ")[0] if " ≤ " in question else None
        yes = (
            False
            if goes_missing and asked is not None and asked in row and row[asked] is None
            else holds(question, row)
        )
        left, right = index + 1, ends[index + 1]
        return answer(left if words[left] == ("yes" if yes else "no") else right, row)

    return [answer(0, row) for row in rows]


def _ends(tree: Any) -> list[int]:
    """Return for every node in preorder the index behind its last descendant."""
    ends: list[int] = []

    def count(node: Any) -> None:
        own = len(ends)
        ends.append(0)
        for side in (getattr(node, "left", None), getattr(node, "right", None)):
            if side is not None:
                count(side)
        ends[own] = len(ends)

    count(tree)
    return ends


def results(limit: float, threads: Sequence[int], seeds: int = TREES) -> Iterator[Line]:
    """Yield a line for each chunk of random trees; it has no limit, and one thread."""
    for first in range(0, seeds, CHUNK):
        yield line_of(range(first, min(first + CHUNK, seeds)))


def line_of(seeds: range) -> Line:
    """Return what the trees of some seeds printed."""
    trees, rows = Counter[str](), 0
    wrong: dict[str, int] = {}
    for seed in seeds:
        kind, by_form, n_rows = wrong_rows(seed)
        trees[kind] += 1
        rows += n_rows * len(by_form)
        wrong |= {f"{seed} {kind}, {form}": n for form, n in by_form.items() if n}
    return {
        "size": f"seeds {seeds.start} to {seeds.stop - 1}",
        "seed": STREAM,
        "trees": dict(trees),
        "rows": rows,
        "wrong": wrong,
    }


def summary(lines: Sequence[Line]) -> str:
    """Return trees by the kind of their first column, and every rule that errs."""
    trees = sum((Counter(line["trees"]) for line in lines), Counter[str]())
    wrong = {key: n for line in lines for key, n in line["wrong"].items()}
    table = markdown_table([{"first column": kind, "trees": n} for kind, n in sorted(trees.items())])
    total = f"{trees.total()} trees, {sum(line['rows'] for line in lines)} rows asked, {len(wrong)} printed rules err"
    return "\n".join([table, total, *(f"{key}: {n} rows" for key, n in list(wrong.items())[:40])])
