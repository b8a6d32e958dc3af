"""SIGINT and SIGTERM at random moments of every command: each ends, with what it knows, within a second.

A moment is drawn in seconds of processor time that the command has used, so that a busy machine draws the same ones,
up to what the command used when nobody disturbed it, the early ones more often: modules are imported and files read
then, while a search is the same from second to second. `--only COMMAND` draws those of one. What is asked of its end:

exit code   0 with the whole result on standard output; 130 or 143, by the signal, with one last word on standard error;
            or death by the signal itself in the first moments, while Python loads the package
seconds     from the signal to the end, of wall time and of processor time
"""

import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from benchmarks.campaign_files import write_campaign
from benchmarks.tables import Line
from octmip.interfaces.cli.program import COMMANDS
from octmip.interfaces.report.markdown import markdown_table

N_MOMENTS = 300
"""Of each command; every other one is SIGTERM."""
LATEST = 2.0
"""Seconds of processor time after which a signal comes at the latest."""
STREAM = 91
GIVEN_UP = 60.0
"""Seconds after the signal in which a command is killed: it does not end."""
TICKS = os.sysconf("SC_CLK_TCK")
ANSWERS: Mapping[str, tuple[str, ...]] = {
    "solve": ("hard.csv", "--label", "y", "--depth", "5", "--holdout", "0.2", "--json"),
    "certify": ("tree.json", "small.csv", "--proof", "proof.log", "--json"),
    "predict": ("tree.json", "long.csv", "--json"),
    "compare": ("hard.csv", "--label", "y", "--depth", "4", "--json"),
    "near-optimal": ("hard.csv", "--label", "y", "--depth", "3", "--json"),
    "sensors": ("hard.csv", "--label", "y", "--depth", "3", "--json"),
    "frontier": ("hard.csv", "--label", "y", "--over", "depth", "--depth", "5", "--folds", "3", "--json"),
    "diagnose": ("campaign.csv", "--twin", "asset:Asset", "--json"),
    "monitor": ("--twin", "asset:Cracked", "--noise", "2", "--depth", "4", "--out", "cracked", "--json"),
    "report": ("tree.json", "small.csv", "--out", "page.html"),
    "doctor": ("--json",),
}
"""The words behind each command."""


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield a line for each signal; neither limit nor threads mean anything here."""
    with TemporaryDirectory() as folder:
        prepare(Path(folder))
        for command in [only] if only else COMMANDS:
            yield from signalled(command, Path(folder), N_MOMENTS, own_seconds(command, Path(folder)))


def prepare(folder: Path, n_long: int = 200_000) -> None:
    """Write the tables, the tree, the proof and the twin that the commands work on; `predict` reads the long table."""
    rng = np.random.default_rng(STREAM)
    for name, n_rows in (("hard", 2000), ("small", 250), ("long", n_long)):
        frame = pd.DataFrame(rng.normal(size=(n_rows, 8)).round(3), columns=[f"x{k}" for k in range(8)])
        frame.assign(y=rng.integers(0, 3, n_rows)).to_csv(folder / f"{name}.csv", index=False)
    (folder / "tables").mkdir()
    shutil.copy(folder / "hard.csv", folder / "tables")
    words = ["solve", str(folder / "small.csv"), "--label", "y", "--depth", "2", "--json"]
    with (folder / "solved.json").open("w") as out:
        command = [sys.executable, "-m", "octmip.interfaces.cli", *words, "--proof", "proof.log", "--out", "tree.json"]
        subprocess.run(command, cwd=folder, stdout=out, check=True)
    write_campaign(folder, rng)


def own_seconds(command: str, folder: Path) -> float:
    """Return the seconds of processor time that a command uses when nobody disturbs it, `LATEST` at most."""
    before = _children_seconds()
    outcome(command, folder, signal.SIGTERM, LATEST)
    return min(_children_seconds() - before, LATEST)


def signalled(
    command: str, folder: Path, n_moments: int, latest: float = LATEST, earliest: float = 0.0
) -> Iterator[Line]:
    """Yield what became of a command at each of its random moments, in seconds of processor time."""
    rng = np.random.default_rng([STREAM, list(COMMANDS).index(command)])
    for k in range(n_moments):
        number = (signal.SIGINT, signal.SIGTERM)[k % 2]
        moment = earliest + (latest - earliest) * float(rng.random()) ** 2
        yield {"size": command, "seed": k, "signal": number.name, "moment": round(moment, 3)} | outcome(
            command, folder, number, moment
        )


def outcome(command: str, folder: Path, number: signal.Signals, moment: float) -> Line:
    """Run a command, send it a signal once it has used so much processor time, and return how it ended."""
    words = [sys.executable, "-m", "octmip.interfaces.cli", command, *ANSWERS[command]]
    before = _children_seconds()
    # Into files: a pipe that nobody reads before the moment would hold the command up.
    with (folder / "out").open("w+") as shown, (folder / "err").open("w+") as said:
        running = subprocess.Popen(words, cwd=folder, stdout=shown, stderr=said, preexec_fn=_hear)
        used = _used(running, moment)
        if used is not None:
            running.send_signal(number)
        sent = time.perf_counter()
        try:
            running.wait(GIVEN_UP)
        except subprocess.TimeoutExpired:
            running.kill()
            running.wait()
        wall = time.perf_counter() - sent
    out, err = ((folder / name).read_text() for name in ("out", "err"))
    line: Line = {"code": running.returncode, "outcome": judged(command, number, running.returncode, out, err)}
    if used is None:
        return line | {"outcome": "ended before" if line["outcome"] == "result" else line["outcome"]}
    return line | {"wall_seconds": round(wall, 3), "cpu_seconds": round(_children_seconds() - before - used, 3)}


def judged(command: str, number: signal.Signals, code: int, out: str, err: str) -> str:
    """Return "result", "interrupted" or "loading"; else what is wrong."""
    is_raised = code == -number or (code == 1 and "KeyboardInterrupt" in err)
    if not out and is_raised and not re.search(r"cli.__init__\.py.*, in main", err):
        return "loading"  # Python itself has not come to the command
    if "Traceback" in err:
        return f"traceback: {err.strip().splitlines()[-1]}"
    if code == 128 + number:
        word = "interrupted" if number is signal.SIGINT else "terminated"
        return "interrupted" if err.endswith(f"octmip: {word}\n") else f"says {err!r}"
    if code != 0:
        return f"exit code {code}: {err.strip()[-200:]}"
    if "--json" in ANSWERS[command]:
        try:
            json.loads(out)
        except ValueError:
            return f"half a result of {len(out)} characters"
    return "result"


def _hear() -> None:
    """Let the process hear SIGINT, which a shell lets its background jobs ignore."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def _used(running: "subprocess.Popen[bytes]", moment: float) -> float | None:
    """Wait until a process has used so many seconds of processor time; return them, None once it has ended."""
    while running.poll() is None:
        try:
            fields = Path(f"/proc/{running.pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            return None
        used = (int(fields[11]) + int(fields[12])) / TICKS
        if used >= moment:
            return used
        time.sleep(0.005)
    return None


def _children_seconds() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def summary(lines: Sequence[Line]) -> str:
    """Return the table: a row for each command."""
    rows = []
    for command in COMMANDS:
        own = [line for line in lines if line["size"] == command]
        ends = [line["outcome"] for line in own]
        late = [line for line in own if "wall_seconds" in line]
        rows.append(
            {
                "command": command,
                "signals": len(late),
                "result": ends.count("result"),
                "interrupted": ends.count("interrupted"),
                "loading": ends.count("loading"),
                "wrong": sum(end not in ("result", "interrupted", "loading", "ended before") for end in ends),
                "worst wall s": max((line["wall_seconds"] for line in late), default=None),
                "worst CPU s": max((line["cpu_seconds"] for line in late), default=None),
            }
        )
    return markdown_table(rows)
