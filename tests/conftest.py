"""What every test may rely on."""

import shutil
import signal
from collections.abc import Iterator
from typing import Any

import pytest

from tests.installed import Installed, installed, shared_folder

LONG = (
    *("test_installed", "test_site", "test_blind", "test_examples", "test_tutorial", "test_uav_study"),
    *("test_fuzz_everything", "test_cli_signals", "test_doors", "test_cluster"),
)
"""The longest files: begun first, so that no process is left alone with one at the end."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the long files before all others."""
    items.sort(key=lambda item: LONG.index(item.path.stem) if item.path.stem in LONG else len(LONG))


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
