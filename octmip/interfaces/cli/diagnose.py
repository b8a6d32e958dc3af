"""Explain an asset by its twin: `octmip.interfaces.cli.options.diagnose` says how the command is called."""

import argparse
import hashlib
import importlib
import sys
from pathlib import Path
from typing import Any

from octmip.errors import DataError
from octmip.formats.files import read_bytes, write_bytes
from octmip.formats.names import visible
from octmip.interfaces.cli.answer import print_json, then_written
from octmip.interfaces.cli.stages import StageLine
from octmip.twin import Twin

PYTHON = "python:"
"""The door of a Python object; it may be left out."""
EXPECTED = (
    "octmip diagnose: a twin of finite elements takes about a minute, one of formulas a few seconds; Ctrl-C ends it."
)


def run(arguments: argparse.Namespace) -> int:
    """Diagnose and show."""
    if arguments.out:
        importlib.import_module(
            "octmip.interfaces.report.diagnosis.page"
        )  # a missing extra is said before the work, not after it
    with StageLine(EXPECTED) as line:
        diagnosis = _diagnosed(arguments, line)
    _show(arguments, diagnosis)
    return 0


def _diagnosed(arguments: argparse.Namespace, line: StageLine) -> Any:
    line("starting")
    from octmip.formats.tree_file import read_tree_file
    from octmip.gap import diagnose, read_campaign  # scikit-learn's covariance behind it takes half a second
    from octmip.gap.twins.cached import CachedTwin

    line(f"building the twin {arguments.twin}")
    twin = CachedTwin(load_twin(arguments.twin, arguments.card))
    line(f"reading {arguments.campaign}")
    campaign = read_campaign(arguments.campaign, twin)
    commissioning = read_campaign(arguments.commissioning, twin) if arguments.commissioning else None
    file = read_tree_file(arguments.tree, "class") if arguments.tree else None
    settings: dict[str, Any] = {} if file is None else {"tree": file.tree, "feature_names": file.feature_names}
    if arguments.load_limits:
        settings["load_limits"] = tuple(arguments.load_limits)
    return diagnose(campaign, twin, commissioning=commissioning, noise_sd=arguments.noise, progress=line, **settings)


def _show(arguments: argparse.Namespace, diagnosis: Any) -> None:
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
        )
        write_bytes(path, page.encode())
        print(f"wrote {visible(path)}", file=sys.stderr)

    with then_written(arguments.out, write, is_quiet=True):
        if arguments.json:
            print_json(as_object(diagnosis))
        else:
            print(page_of_words(diagnosis))


def _made(name: str, maker: Any) -> Any:
    """Return what a twin's class or function makes, called without arguments."""
    try:
        return maker()
    except TypeError as error:
        raise DataError(
            f"--twin {name!r} cannot be called without arguments ({error}); expected a twin, its class, a function "
            "that makes one, or a model f(parameters, loads) beside its card; write such a function, or give the card "
            "(--card CARD.json)"
        ) from error


def load_twin(name: str, card: str | None = None) -> Twin:
    """Return the twin that a name says: a Python object, or a model behind a door.

    Raises
    ------
    DataError
        there is no such object, model or card, or it gives no twin.
    """
    from octmip.gap.doors import FunctionTwin, read_card
    from octmip.gap.doors.opening import door_of, open_twin

    if door_of(name):
        return open_twin(name, card)
    if card is not None:
        return FunctionTwin(_attribute(name.removeprefix(PYTHON)), read_card(card))
    return _object_twin(name.removeprefix(PYTHON))


def _attribute(name: str) -> Any:
    """Return what ``module:attribute`` names."""
    module, colon, attribute = name.partition(":")
    if not (module and colon and attribute):
        raise DataError(f"--twin is {name!r}; expected MODULE:NAME, such as femlib.wing:uav_twin")
    if "" not in sys.path:
        sys.path.insert(0, "")  # a twin beside the campaign, in the working directory
    try:
        return getattr(importlib.import_module(module), attribute)
    except ImportError as error:
        raise DataError(
            f"--twin {name!r}: module {module!r} cannot be imported ({error}); expected MODULE:NAME, or a door such as "
            "table:FILE.csv; check the name"
        ) from error
    except AttributeError as error:
        raise DataError(f"--twin {name!r}: {module!r} has no {attribute!r}; check the name") from error


def _object_twin(name: str) -> Twin:
    """Return the twin that ``module:attribute`` names, called first when it is no twin itself."""
    found = _attribute(name)
    twin = found if hasattr(found, "predict") and not isinstance(found, type) else _made(name, found)
    if not all(hasattr(twin, part) for part in ("gauges", "predict", "effects")):
        raise DataError(
            f"--twin {name!r} gives a {type(twin).__name__}; expected gauges, effects and predict(state, load)"
        )
    checked: Twin = twin
    return checked
