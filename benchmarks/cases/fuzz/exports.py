"""Hostile names through every export and report: `python -m benchmarks.run exports`, about three minutes.

Every name is once the name of a feature and once that of a class. What each target makes of it is parsed, and run,
by the machine that it is for: SQLite, a C compiler, onnxruntime, Chromium.
"""

import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from benchmarks.tables import Line
from octmip.interfaces.report.markdown import markdown_table
from tests.oracles.export_runs import EXACT, EXPORTS, REFUSED
from tests.oracles.hostile_names import hostile_names
from tests.oracles.report_runs import REPORTS, run_page

COUNT = 500
BATCH = 25
"""Names in one tree of a report."""

Run = Callable[[Sequence[str]], list[str]]


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each kind of name and target; it has no limit, and one thread."""
    pairs = hostile_names(COUNT)
    for target, run in _targets():
        outcomes: list[str] = []
        for first in range(0, COUNT, BATCH):
            outcomes += run([name for _, name in pairs[first : first + BATCH]])
        for kind in dict.fromkeys(kind for kind, _ in pairs):
            got = Counter(outcome for (k, _), outcome in zip(pairs, outcomes, strict=True) if k == kind)
            faults = {what: n for what, n in got.items() if what not in (EXACT, REFUSED)}
            line = {"size": f"{kind}, {target}", "kind": kind, "target": target, "names": got.total()}
            yield line | {"exact": got[EXACT], "refused": got[REFUSED], "faults": faults}


def _targets() -> Iterator[tuple[str, Run]]:
    yield from EXPORTS.items()
    yield from REPORTS.items()
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        raise SystemExit("no Chromium on this machine; apt-get install chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield "HTML", lambda names: run_page(names, browser, Path(folder))
        browser.close()


def summary(lines: Sequence[Line]) -> str:
    """Return kinds by targets: names that came out exact, and in brackets those refused or wrong, if any."""
    rows = []
    for kind in dict.fromkeys(line["kind"] for line in lines):
        of_kind = [line for line in lines if line["kind"] == kind]
        rows.append({"names": kind, "number": of_kind[0]["names"]} | {line["target"]: _cell(line) for line in of_kind})
    rows.append({"names": "all", "number": sum(row["number"] for row in rows)} | _totals(lines))
    return markdown_table(rows)


def _totals(lines: Sequence[Line]) -> dict[str, str]:
    totals = {}
    for target in dict.fromkeys(line["target"] for line in lines):
        of_target = [line for line in lines if line["target"] == target]
        faults = sum((Counter(line["faults"]) for line in of_target), Counter[str]())
        sums = {what: sum(line[what] for line in of_target) for what in ("exact", "refused")}
        totals[target] = _cell(sums | {"faults": faults})
    return totals


def _cell(line: Line) -> str:
    notes = [f"{line['refused']} refused"] if line["refused"] else []
    notes += [f"{sum(line['faults'].values())} WRONG"] if line["faults"] else []
    return f"{line['exact']}" + (f" ({', '.join(notes)})" if notes else "")
