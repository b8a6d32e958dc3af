"""Explain an asset by its twin: `octmip.interfaces.cli.options.diagnose` says how the command is called."""

import argparse
import hashlib
import importlib
import sys
from pathlib import Path
from typing import Any

from octmip.errors import DataError
from octmip.input.files import read_bytes, write_bytes
from octmip.input.names import visible
from octmip.interfaces.cli.answer import print_json, then_written
from octmip.interfaces.cli.options.page import masthead_of, units_of_options
from octmip.interfaces.cli.recorded import table_of
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.cli.streams import prints_aside

EXPECTED = (
    "octmip diagnose: a twin of finite elements takes about a minute, one of formulas a few seconds; Ctrl-C ends it."
)


def run(arguments: argparse.Namespace) -> int:
    """Diagnose and show."""
    if arguments.out:
        importlib.import_module(
            "octmip.interfaces.report.diagnosis.page"
        )  # a missing extra is said before the work, not after it
    masthead = masthead_of(arguments, is_page=bool(arguments.out))
    with StageLine("starting", EXPECTED) as line, prints_aside():
        diagnosis = _diagnosed(arguments, line)
    _show(arguments, diagnosis, masthead)
    return 0


def _diagnosed(arguments: argparse.Namespace, line: StageLine) -> Any:
    from octmip.formats.tree_file import read_tree_file
    from octmip.gap import (  # scikit-learn's covariance behind it takes half a second
        Budget,
        Differences,
        FunctionTwin,
        Odds,
        diagnose,
        read_campaign,
    )
    from octmip.gap.doors import open_twin
    from octmip.gap.odds import MOST_OFF
    from octmip.gap.twins import CachedTwin

    _check(arguments, MOST_OFF)
    line(f"building the twin {arguments.twin}")
    twin = CachedTwin(open_twin(arguments.twin, arguments.card))
    if arguments.unit:
        twin = twin.in_units(units_of_options(arguments.unit, twin.gauges, "no reading of the twin"))
    line(f"reading {arguments.campaign}")
    campaign = read_campaign(table_of(arguments, arguments.campaign, twin), twin)
    run = arguments.commissioning
    commissioning = read_campaign(table_of(arguments, run, twin, is_commissioning=True), twin) if run else None
    file = read_tree_file(arguments.tree, "class") if arguments.tree else None
    settings: dict[str, Any] = {} if file is None else {"tree": file.tree, "feature_names": file.feature_names}
    if arguments.load_limits:
        settings["load_limits"] = tuple(arguments.load_limits)
    if arguments.constants is not None:
        settings["odds"] = Odds(differences=Differences(constants=arguments.constants / 100.0))
    if arguments.calls is not None:
        settings["budget"] = Budget(
            arguments.calls,
            arguments.jobs,
            arguments.answers,
            lambda done, total: line(f"asking the model: {done} of at most {total} answers"),
        )
    line("diagnosing")
    if isinstance(twin.twin, FunctionTwin):
        twin.twin.watch = lambda n: line(f"diagnosing: {n} answers of the model")
    return diagnose(campaign, twin, commissioning=commissioning, noise_sd=arguments.noise, **settings)


def _check(arguments: argparse.Namespace, most_off: float) -> None:
    """Refuse what the options of a model behind a door do not take."""
    given = "--jobs" if arguments.jobs != 1 else "--answers" if arguments.answers else ""
    if given and arguments.calls is None:
        raise DataError(f"{given} is for a budget of calls; expected --calls N beside it; add it, or drop {given}")
    if arguments.constants is not None and not 0.0 < arguments.constants <= 100.0 * most_off:
        raise DataError(
            f"--constants is {arguments.constants:g}; expected per cent above 0, up to {100 * most_off:g}, such as 5"
        )


def _show(arguments: argparse.Namespace, diagnosis: Any, masthead: Any) -> None:
    from octmip.interfaces.report.diagnosis.as_json import as_object
    from octmip.interfaces.report.diagnosis.page import report_page
    from octmip.interfaces.report.diagnosis.words import page_of_words

    def write(path: str) -> None:
        page = report_page(
            diagnosis,
            data=Path(arguments.campaign).name,
            sha256=hashlib.sha256(read_bytes(arguments.campaign)).hexdigest(),
            commissioning=Path(arguments.commissioning).name if arguments.commissioning else "",
            twin=arguments.twin,
            masthead=masthead,
        )
        write_bytes(path, page.encode())
        print(f"wrote {visible(path)}", file=sys.stderr)

    with then_written(arguments.out, write, is_quiet=True):
        if arguments.json:
            print_json(as_object(diagnosis))
        else:
            print(page_of_words(diagnosis))
