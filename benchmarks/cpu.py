"""CPU seconds of this process, and a limit in them: on a busy machine the clock says little of the work done."""

import resource
from typing import Any

from octmip.solution import Limits, Progress


def cpu_limit(seconds: float) -> dict[str, Any]:
    """Return the arguments that stop a form after so many CPU seconds of this process, and at last by the clock."""
    before = cpu_seconds()

    def watch(_: Progress) -> None:
        if cpu_seconds() - before > seconds:
            raise KeyboardInterrupt

    return {"limits": Limits(seconds=50 * seconds), "progress": watch}


def cpu_seconds() -> float:
    """Return user and system seconds of this process, all threads."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime
