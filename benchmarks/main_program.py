"""Main programs that hear SIGTERM as Ctrl-C: one sentence, the exit code of the signal, no process left behind."""

import multiprocessing
import sys
from collections.abc import Callable
from typing import NoReturn

from octmip.interfaces.cli.stages import term_as_interrupt


def run_main(main: Callable[[], int | None]) -> NoReturn:
    """Run a main program to its end, or to SIGINT or SIGTERM: what it has written by then stands."""
    with term_as_interrupt() as heard:
        try:
            sys.exit(main())
        except KeyboardInterrupt:
            _end_children()
            print(f"{sys.argv[0]}: stopped; what was written stands", file=sys.stderr)
            sys.exit(heard.exit_code)


def _end_children() -> None:
    """End processes that still work: nobody will take their results."""
    for process in multiprocessing.active_children():
        process.terminate()
    if "joblib.externals.loky" in sys.modules:
        from joblib.externals.loky import get_reusable_executor

        get_reusable_executor().shutdown(wait=False, kill_workers=True)
