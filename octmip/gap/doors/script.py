"""A program as a twin: parameters and loads go in as JSON, readings come out as JSON, one run for each question.

The program reads one object from its standard input, {"parameters": {...}, "loads": {...}}, and writes one to its
standard output, {"f1": 2.01, ...}; the last line of the output counts, so that a solver may talk before it. So an
OpenSees script (openseespy), a MATLAB function or a vendor's solver with a licence of its own becomes a twin without
being linked to this package.

What it lacks: every question starts the program again, so a program that takes a minute to start costs a minute for
each parameter, state and load. Keep such a model running and ask it by a function (docs/howto/doors.md).
"""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from octmip.errors import DataError, TwinError
from octmip.gap.doors.card import Card, card_beside
from octmip.gap.doors.function import FunctionTwin

LONGEST = 600.0
"""Seconds after which a program that does not answer is ended."""


def script_twin(
    path: str | Path,
    card: str | Path | Card | None = None,
    command: Sequence[str] = (),
    seconds: float = LONGEST,
    linear: bool = False,
) -> FunctionTwin:
    """Return the twin of a program.

    Parameters
    ----------
    path
        the program: a Python script, run by this interpreter, or any executable file.
    card
        its card or the file of it; by default the file beside it, its name with .json added.
    command
        what runs it, the path as one of its words; by default this interpreter for .py, the file itself for others.
    seconds
        after which a run is ended.
    linear
        whether readings are proportional to the loads, where the card does not say so.

    Raises
    ------
    DataError
        no such file or card.
    """
    program = Path(path)
    if not program.is_file():
        raise DataError(f"script {program} is not there; expected a program; check the path")
    known = card_beside(path, card, linear)
    words = list(command) or ([sys.executable, str(program)] if program.suffix == ".py" else [str(program.resolve())])

    def function(parameters: Mapping[str, float], loads: Mapping[str, float]) -> Any:
        asked = json.dumps({"parameters": dict(parameters), "loads": dict(loads)})
        lines = _said(words, f"script {program}", seconds, asked).strip().splitlines() or [""]
        try:
            return {str(name): float(value) for name, value in json.loads(lines[-1]).items()}
        except (ValueError, AttributeError, TypeError) as error:
            raise TwinError(
                f"script {program} prints {lines[-1][:60]!r} last; expected one JSON object of readings, a number each "
                f"({error})"
            ) from error

    return FunctionTwin(function, known)


def _said(words: Sequence[str], called: str, seconds: float, asked: str) -> str:
    """Return what a program prints.

    Raises
    ------
    TwinError
        it cannot be started, does not end in time, or ends with an error.
    """
    try:
        done = subprocess.run(list(words), input=asked, capture_output=True, text=True, timeout=seconds, check=False)
    except OSError as error:
        raise TwinError(
            f"{called} cannot be run by {words[0]!r} ({error.strerror}); expected a program that may be run; install "
            "it, correct its name, or allow it (chmod +x)"
        ) from error
    except subprocess.TimeoutExpired as error:
        raise TwinError(f"{called} did not end within {seconds:g} s; expected an answer; allow more") from error
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise TwinError(
            f"{called} ended with code {done.returncode} ({said[-1] if said else 'and said nothing'}); expected 0"
        )
    return done.stdout
