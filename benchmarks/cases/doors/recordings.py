"""A recording of ten million samples to its diagnosis: `python -m benchmarks.run recordings`, about ten minutes.

Processor seconds and peak memory of one command, its start among them: five channels of a beam at 1 kHz. In DataFlash,
MCAP and the bag of ROS these are two million messages, or four times as many; a message has its price, not a sample.
"""

import json
import multiprocessing
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.recordings import BEAM, CARD, CHANNELS, FORMATS, UNITS, series
from benchmarks.tables import Line

N_SAMPLES = 10_000_000
"""Of all channels together."""


def results(limit: float, threads: Sequence[int], n: int = N_SAMPLES) -> Iterator[Line]:
    """Yield seconds, memory and the cause found of each format."""
    for form in FORMATS:
        yield {"size": form, "seed": 0, "samples": n, **measured(form, n)}


def measured(form: str, n: int) -> Line:
    """Return what the command used on a recording of n samples in all."""
    file, write, places = FORMATS[form]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "beam_of_recordings.py").write_text(BEAM)
        (folder / "card.json").write_text(json.dumps(CARD))
        own = multiprocessing.get_context("fork").Process(target=lambda: write(folder / file, series(n // len(UNITS))))
        own.start()  # Linux counts the most memory that a parent ever had as its child's too
        own.join()
        # posix_spawn has no folder: the command gets whole paths
        words = [sys.executable, "-m", "octmip.interfaces.cli", "diagnose", str(folder / file), "--steady", "--json"]
        words += ["--twin", "python:beam_of_recordings:beam", "--card", str(folder / "card.json")]
        words += ["--load-units", "force=N", "moment=N m", "--loads", *(f"{key}={places[key]}" for key in CHANNELS[:2])]
        words += ["--readings", *(f"{key}={places[key]}" for key in CHANNELS[2:])]
        with (folder / "out.json").open("wb") as out:
            environment = os.environ | {"PYTHONPATH": os.pathsep.join([name, *sys.path])}
            actions = [(os.POSIX_SPAWN_DUP2, out.fileno(), 1)]
            number = os.posix_spawn(sys.executable, words, environment, file_actions=actions)
            _, status, used = os.wait4(number, 0)
        found = json.loads((folder / "out.json").read_text()) if status == 0 else {}
    return {
        "cpu_seconds": round(used.ru_utime + used.ru_stime, 1),
        "megabytes": round(used.ru_maxrss / 1024),
        "verdict": found.get("verdict", f"status {status}"),
    }
