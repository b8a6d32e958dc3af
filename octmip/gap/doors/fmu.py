"""An FMU (Functional Mock-up Unit, 2.0 or 3.0) as a twin: set what the card names, run, read what it names.

Parameters, states and loads of the card are variables of the FMU and are set before it starts; a reading is the value
of a variable at the end of the run, which for a model that has settled is its steady answer. A reading named
"variable@1.5" is the value at 1.5 s: so a cycle is read at its phases. The run ends at the last of these times, or at
"stop_time" of the FMU's default experiment.

What it lacks: signals over time as loads; FMUs for another platform than this one (they hold machine code).
"""

import tempfile
import weakref
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError, TwinError, needed_by
from octmip.gap.doors.card import Card, card_beside
from octmip.gap.doors.function import FunctionTwin


def fmu_twin(path: str | Path, card: str | Path | Card | None = None) -> FunctionTwin:
    """Return the twin of an FMU.

    Parameters
    ----------
    path
        the FMU.
    card
        its card or the file of it; by default the file beside it, its name with .json added.

    Raises
    ------
    MissingExtraError
        the package fmpy is missing.
    DataError
        no such file, no FMU, a name of the card that is no variable of it.
    """
    with needed_by("a twin from an FMU"):
        import fmpy
    if not Path(path).is_file():
        raise DataError(f"FMU {path} is not there; expected a file; check the path")
    known = card if isinstance(card, Card) else card_beside(path, card)
    description = _of_fmu(path, lambda: fmpy.read_model_description(str(path)))
    names = {variable.name for variable in description.modelVariables}
    outputs = {name: _split(name, names) for name in known.readings}
    wanted = [*known.parameters, *known.states, *known.loads, *(variable for variable, _ in outputs.values())]
    missing = [name for name in wanted if name not in names]
    if missing:
        raise DataError(
            f"FMU {path} has no variable {missing[0]!r}; expected among {sorted(names)[:6]}...; correct the card"
        )
    experiment = description.defaultExperiment
    stop = float(getattr(experiment, "stopTime", None) or 1.0)
    times = [time for _, time in outputs.values() if time is not None]
    end = max(times) if times else stop
    folder = tempfile.TemporaryDirectory(prefix="octmip-fmu-")  # removed with the function that holds it
    unpacked = _of_fmu(path, lambda: fmpy.extract(str(path), unzipdir=folder.name))

    def function(parameters: Mapping[str, float], loads: Mapping[str, float]) -> dict[str, float]:
        try:
            result: Any = fmpy.simulate_fmu(
                unpacked,
                start_values={**parameters, **loads},
                stop_time=end,
                output=[variable for variable, _ in outputs.values()],
                model_description=description,
            )
        except Exception as error:
            raise TwinError(
                f"FMU {path}: {error}; expected a run to {end:g} s; try it in the tool that made it"
            ) from error
        at = {name: end if time is None else time for name, (_, time) in outputs.items()}
        return {name: float(np.interp(at[name], result["time"], result[outputs[name][0]])) for name in outputs}

    weakref.finalize(function, folder.cleanup)
    return FunctionTwin(function, known)


def _of_fmu(path: str | Path, read: Callable[[], Any]) -> Any:
    try:
        return read()
    except Exception as error:
        raise DataError(
            f"FMU {path} cannot be read ({error}); expected a Functional Mock-up Unit 2.0 or 3.0; write it again"
        ) from error


def _split(name: str, variables: set[str]) -> tuple[str, float | None]:
    """Return variable and time of a reading; no time where it is read at the end."""
    variable, at, time = name.rpartition("@")
    if name in variables or not at:
        return name, None
    try:
        return variable, float(time)
    except ValueError as error:
        raise DataError(
            f"reading {name!r} has no time after its @; expected one in seconds, such as force@1.5"
        ) from error
