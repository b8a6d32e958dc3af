"""The memory that a process may still take: a native table that cannot be had would end it, with all that it found."""

import math
import os
from dataclasses import replace
from pathlib import Path

from octmip.trees.solution import Limits

SHARE = 0.5
"""Of what is left for the tables of a solver; the rest is for its threads and for Python."""


def address_space_left() -> float:
    """Return the bytes that the process may still map before its own limit (`ulimit -v`); +inf without one."""
    try:
        import resource  # of Unix alone

        most = resource.getrlimit(resource.RLIMIT_AS)[0]
        if most == resource.RLIM_INFINITY:
            return math.inf
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        return max(0.0, float(most - pages * os.sysconf("SC_PAGE_SIZE")))
    except (ImportError, OSError, ValueError):
        return math.inf


def within_process(limits: Limits) -> Limits:
    """Return limits whose memory the process may have."""
    return replace(limits, memory=min(limits.memory, SHARE * address_space_left()))
