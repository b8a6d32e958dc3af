"""What every test may rely on."""

import signal

import pytest


@pytest.fixture(autouse=True, scope="session")
def _ctrl_c_is_heard() -> None:
    """A shell starts background jobs with SIGINT ignored; Python then raises no KeyboardInterrupt, nor do children."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
