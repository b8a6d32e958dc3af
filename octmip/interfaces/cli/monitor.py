"""From a twin to a folder of trees, pages and C: `octmip.interfaces.cli.options.monitor` says how it is called."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from octmip.errors import DataError
from octmip.gap.doors import open_twin
from octmip.gap.twins import CachedTwin
from octmip.input.files import whole_folder
from octmip.interfaces.cli.answer import print_json
from octmip.interfaces.cli.monitor_folder import summary_of, words_of, write_monitor
from octmip.interfaces.cli.monitor_loop import run_loop
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.cli.streams import prints_aside
from octmip.sensing.enrichment import PartOf
from octmip.sensing.monitor_design import design_monitor
from octmip.trees.answer.solution import Limits
from octmip.twin import Twin, load_of, load_words, loads_of, units_of


def run(arguments: argparse.Namespace) -> int:
    """Make the folder and show what the trees are worth."""
    with prints_aside():
        twin = CachedTwin(open_twin(arguments.twin, arguments.card, arguments.linear))
    settings: dict[str, Any] = {
        "costs": {name: cost for words in arguments.cost for name, cost in _numbers(words, "--cost").items()},
        "depth": arguments.depth,
        "budget": arguments.budget,
        "n_draws": arguments.draws,
        "seed": arguments.seed,
        "limits": Limits(seconds=arguments.seconds),
    }
    _refuse_mixed(arguments)
    if arguments.readings:
        return run_loop(arguments, twin, settings)
    settings["noise_sd"] = _noise(twin, arguments.noise)
    settings["levels"] = {name: levels for words in arguments.states for name, levels in _levels(words).items()}
    loads = [_numbers(words, "--load") for words in arguments.load] or [dict.fromkeys(loads_of(twin), 1.0)]
    told = PartOf(twin, tuple(arguments.only.split(","))) if arguments.only else twin
    found, words = [], []
    with whole_folder(arguments.out) as passing:
        for k, load in enumerate(loads, start=1):
            part = f"load-{k}" if len(loads) > 1 else ""
            with StageLine(f"monitoring at {_at(twin, load)}"), prints_aside():
                design = design_monitor(told, load, **settings)
                write_monitor(passing / part, design, twin)
            found.append(summary_of(design, load, Path(arguments.out) / part))
            words.append(words_of(design, found[-1]))
    if arguments.json:
        print_json({"monitors": found})
    else:
        print("\n".join(words))
    return 0


LOOP = ("readings", "deployed")
"""Options of the loop that need each other."""
FROM_NOTHING = ("load", "noise", "states", "only")
"""Options that a deployed monitor answers itself."""


def _refuse_mixed(arguments: argparse.Namespace) -> None:
    """Refuse readings without a deployed monitor, and beside one the options that it answers.

    Raises
    ------
    DataError
        see above.
    """
    given = [name for name in LOOP if getattr(arguments, name)]
    if given and len(given) < len(LOOP):
        missing = next(name for name in LOOP if name not in given)
        raise DataError(f"--{given[0]} is given without --{missing}; expected both or neither; give --{missing}")
    beside = [name for name in FROM_NOTHING if getattr(arguments, name)]
    if given and beside:
        raise DataError(f"--{beside[0]} stands beside --deployed, whose monitor.json says it; leave it out")
    if arguments.inspected and not given:
        raise DataError("--inspected is given without --readings and --deployed; give these, or leave it out")
    if not given and not arguments.noise:
        raise DataError("--noise is missing; give the standard deviation of one reading")


def _at(twin: Twin, load: Mapping[str, float]) -> str:
    names = loads_of(twin)
    return load_words(names, load_of(names, tuple(load.values()))) if len(load) == len(names) > 0 else "its readings"


def _noise(twin: Twin, given: Sequence[str]) -> dict[str, float]:
    """Return the noise of each reading: of all, then of units, then of single readings.

    Raises
    ------
    DataError
        a name is neither a unit nor a reading, or a reading has none.
    """
    units = dict(zip(twin.gauges, units_of(twin), strict=True))
    every = [words for words in given if "=" not in words]
    found = {name: _number(words, "--noise") for words in every for name in units}
    named = {name: sd for words in given if "=" in words for name, sd in _numbers(words, "--noise").items()}
    unknown = [name for name in named if name not in units and name not in units.values()]
    if unknown:
        raise DataError(
            f"--noise names {unknown[0]!r}; expected a unit among {sorted(set(units.values()))} or a reading among "
            f"{list(units)}; correct the name"
        )
    found |= {name: named[unit] for name, unit in units.items() if unit in named}
    found |= {name: sd for name, sd in named.items() if name in units}
    missing = [name for name in units if name not in found]
    if missing:
        raise DataError(f"--noise says nothing of {missing[0]!r} [{units[missing[0]]}]; give {units[missing[0]]}=SD")
    return found


def _levels(words: str) -> dict[str, list[float]]:
    """Return the levels of one state, as NAME=LEVEL,... says them."""
    name, sign, levels = words.partition("=")
    if not sign:
        raise DataError(f"--states is {words!r}; expected NAME=LEVEL,... such as crack=0,0.2,0.4; give these")
    return {name: [_number(level, "--states") for level in levels.split(",")]}


def _numbers(words: str, option: str) -> dict[str, float]:
    """Return the numbers that NAME=VALUE,... says."""
    pairs = [part.rpartition("=") for part in words.split(",")]
    if not all(sign for _, sign, _ in pairs):
        raise DataError(f"{option} is {words!r}; expected NAME=VALUE, several with a comma between; give these")
    return {name: _number(value, option) for name, _, value in pairs}


def _number(word: str, option: str) -> float:
    try:
        return float(word)
    except ValueError as error:
        raise DataError(f"{option} holds {word!r}; expected a number; correct it") from error
