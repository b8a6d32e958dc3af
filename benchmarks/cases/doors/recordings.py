"""A recording of ten million samples to its diagnosis: `python -m benchmarks.run recordings`, about a minute.

Processor seconds and peak memory of one command, its start among them: five channels of a beam at 1 kHz.
"""

import json
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.recordings import BEAM, CARD, UNITS, WRITERS, series
from benchmarks.tables import Line

N_SAMPLES = 10_000_000
"""Of all channels together."""


def results(limit: float, threads: Sequence[int], n: int = N_SAMPLES) -> Iterator[Line]:
    """Yield seconds, memory and the cause found of each format."""
    for form in WRITERS:
        yield {"size": form, "seed": 0, "samples": n, **measured(form, n)}


def measured(form: str, n: int) -> Line:
    """Return what the command used on a recording of n samples in all."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "beam_of_recordings.py").write_text(BEAM)
        (folder / "card.json").write_text(json.dumps(CARD))
        WRITERS[form](folder / f"run.{form}", series(n // len(UNITS)))
        words = [sys.executable, "-m", "octmip.interfaces.cli", "diagnose", f"run.{form}", "--steady", "--json"]
        words += ["--twin", "python:beam_of_recordings:beam", "--card", "card.json"]
        with (folder / "out.json").open("wb") as out:
            environment = os.environ | {"PYTHONPATH": os.pathsep.join([name, *sys.path])}
            actions = [(os.POSIX_SPAWN_DUP2, out.fileno(), 1)]
            # posix_spawn has no folder: the command gets whole paths
            words = [str(folder / word) if (folder / word).is_file() else word for word in words]
            number = os.posix_spawn(sys.executable, words, environment, file_actions=actions)
            _, status, used = os.wait4(number, 0)
        found = json.loads((folder / "out.json").read_text()) if status == 0 else {}
    return {
        "cpu_seconds": round(used.ru_utime + used.ru_stime, 1),
        "megabytes": round(used.ru_maxrss / 1024),
        "verdict": found.get("verdict", f"status {status}"),
    }
