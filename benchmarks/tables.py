"""Markdown tables of benchmark lines: one row per case, one column per solver; ratios and their geometric mean."""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

Line = dict[str, Any]
"""One result: a JSON object, printed as one line. Its keys are the family's own, whose summary reads them back."""
OURS, PEER = "octmip", "pycontree"
ROUNDING = 1e-6
"""Share of an objective by which sums of float64 and printed digits may differ."""


def markdown(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table in Markdown, its cells as they are."""
    return "\n".join(f"| {' | '.join(map(str, cells))} |" for cells in (head, ["---"] * len(head), *rows))


def race_table(lines: Iterable[Line], ours: str = OURS, peer: str = PEER) -> str:
    """Return the table of a race with the CPU seconds of each solver, and the ratios to the peer below it.

    Raises
    ------
    ValueError
        the objectives that are proven of one case differ: somebody's proof is false, or they answer two questions.
    """
    rows: dict[tuple[str, int], dict[str, Line]] = {}
    columns: list[str] = []
    for line in lines:
        column = _column(line)
        rows.setdefault((line["size"], line["seed"]), {})[column] = line
        columns += [column] if column not in columns else []
    head = ["case", "seed", "optimum", *columns, "ratio"]
    cells = [
        [size, seed, _optimum(row), *(_cell(row.get(column)) for column in columns), _ratio_cell(row, ours, peer)]
        for (size, seed), row in rows.items()
    ]
    return "\n".join([markdown(head, cells), "", *_verdicts(list(rows.values()), ours, peer)])


def _column(line: Line) -> str:
    return line["solver"] if line["threads"] == 1 else f"{line['solver']}, {line['threads']} threads (wall)"


def _cell(line: Line | None) -> str:
    if line is None:
        return ""
    if "cpu_seconds" not in line:
        return str(line["outcome"])
    seconds = line["cpu_seconds"] if line["threads"] == 1 else line["wall_seconds"]
    mark = "" if line["outcome"] == "proven" else f" ({line['objective']:g}, not proven)"
    return f"{seconds:.3g}{mark}"


def _optimum(row: dict[str, Line]) -> str:
    proven = {line["solver"]: float(line["objective"]) for line in row.values() if line.get("outcome") == "proven"}
    if proven and max(proven.values()) - min(proven.values()) > ROUNDING * max(1.0, *proven.values()):
        said = ", ".join(f"{value:g} by {solver}" for solver, value in proven.items())
        raise ValueError(f"the proven objectives of {next(iter(row.values()))['size']} differ: {said}")
    return f"{min(proven.values()):g}" if proven else "?"


def peer_seconds(row: dict[str, Line], peer: str = PEER) -> float:
    """Return the peer's CPU seconds, those it had used when its limit came, nan where it did not run."""
    return float(row.get(peer, {}).get("cpu_seconds", math.nan))


def ratio(row: dict[str, Line], ours: str = OURS, peer: str = PEER) -> float:
    """Return how many times faster ours is on one thread, in CPU; nan where either has no figure."""
    own = row.get(ours, {})
    if {own.get("outcome"), row.get(peer, {}).get("outcome")} == {"not proven"}:
        return math.nan  # both ran into the limit: neither is faster
    return peer_seconds(row, peer) / max(float(own.get("cpu_seconds", math.nan)), 1e-6)


def _ratio_cell(row: dict[str, Line], ours: str, peer: str) -> str:
    value = ratio(row, ours, peer)
    if math.isnan(value):
        return ""
    at_least = ">" if row[peer]["outcome"] != "proven" and row.get(ours, {}).get("outcome") == "proven" else ""
    return f"{at_least}{value:.3g}"


def _verdicts(rows: list[dict[str, Line]], ours: str, peer: str) -> list[str]:
    compared = [(row, peer_seconds(row, peer), ratio(row, ours, peer)) for row in rows]
    slow = [value for _, seconds, value in compared if seconds > 0.1 and not math.isnan(value)]
    slower = [row for row, seconds, value in compared if seconds > 0.02 and value < 1]
    lines = []
    if slow:
        mean = math.exp(sum(math.log(value) for value in slow) / len(slow))
        lines.append(
            f"Geometric mean of the ratios over the {len(slow)} cases where {peer} needs more than 0.1 s: {mean:.3g}."
        )
    names = [next(iter(row.values()))["size"] for row in slower]
    lines.append(f"Slower than {peer} where it needs more than 0.02 s: {', '.join(names) or 'nowhere'}.")
    return lines


def whole_lines(path: Path) -> list[str]:
    """Return the lines of a file that a run adds to, none where it is missing; one that was cut off is removed."""
    text = path.read_text() if path.exists() else ""
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        path.write_text(whole)
    return whole.splitlines()
