"""What every test may rely on."""

import gc
import os
import shutil
import signal
from collections.abc import Iterator
from typing import Any

import pytest

from tests.installed import Installed, installed, shared_folder

FIRST = (
    *("test_installed", "test_site", "test_blind", "test_examples", "test_tutorial", "test_uav_study"),
    *("test_fuzz_everything", "test_cli_signals", "test_doors", "test_cluster"),
)
"""The files that take longest: begun first, so that no process is left alone with one at the end."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the switch of the long tests."""
    parser.addoption("--long", action="store_true", help="run the tests marked long instead of all others")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Return one more than there are processors: many tests wait for the processes that they have started."""
    own = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return (own or 1) + 1


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave the long tests out, or all others with --long, and put the files that take longest first."""
    if not config.option.keyword and not any("::" in argument for argument in config.args):
        _check_marks(items)
    asked = config.getoption("--long")
    config.hook.pytest_deselected(items=[item for item in items if is_long(item) != asked])
    items[:] = [item for item in items if is_long(item) == asked]
    items.sort(key=lambda item: FIRST.index(item.path.stem) if item.path.stem in FIRST else len(FIRST))


def pytest_collection_finish() -> None:
    """Take what all imports have made from the garbage collector, which would pass over it in every test."""
    gc.collect()
    gc.freeze()


def is_long(item: pytest.Item) -> bool:
    """Return whether a test is marked long: the mark names the cases of a table that are, or none where all are."""
    mark = item.get_closest_marker("long")
    if mark is None or not mark.args:
        return mark is not None
    return isinstance(item, pytest.Function) and item.callspec.id in mark.args


def _check_marks(items: list[pytest.Item]) -> None:
    """Refuse a mark that names a case which its table has not."""
    tables = [item for item in items if isinstance(item, pytest.Function) and hasattr(item, "callspec")]
    cases = {(item.path, item.originalname, item.callspec.id) for item in tables}
    for item in tables:
        mark = item.get_closest_marker("long")
        for case in mark.args if mark else ():
            if (item.path, item.originalname, case) not in cases:
                raise pytest.UsageError(f"{item.nodeid}: long names {case!r}; expected a case of its table")


@pytest.fixture(autouse=True, scope="session")
def _ctrl_c_is_heard() -> None:
    """A shell starts background jobs with SIGINT ignored; Python then raises no KeyboardInterrupt, nor do children."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A headless Chromium; the test is skipped where there is none."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no Chromium on this machine: apt-get install chromium")
    with playwright.sync_playwright() as running:
        opened = running.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def installed_octmip(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Return an empty environment with the built wheel and its own dependencies alone: no extra, no checkout."""
    return installed(shared_folder(tmp_path_factory))


@pytest.fixture(scope="session")
def installed_octmip_plot(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Return an empty environment with the built wheel and the extra "plot"."""
    return installed(shared_folder(tmp_path_factory), "plot")
