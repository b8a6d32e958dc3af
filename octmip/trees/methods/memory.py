"""The memory that a process may still take: a native table that cannot be had would end it, with all that it found."""

import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from octmip.trees.answer.solution import Limits

SHARE = 0.5
"""Of what is left for the tables of a solver; the rest is for its threads and for Python."""

BLAS_BYTES = 2**27
"""Address space that the linear algebra of scipy takes, with the buffers of both libraries."""


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


def open_blas() -> None:
    """Load linear algebra now, with its buffers: OpenBLAS that gets none later waits without end, or ends the process.

    Raises
    ------
    MemoryError
        the process has its own limit, and no room for it.
    """
    left = address_space_left()
    if left == math.inf:
        return
    if left < BLAS_BYTES:
        raise MemoryError(f"{left:g} bytes are left for linear algebra; expected {BLAS_BYTES}")
    from scipy.linalg.blas import dgemm  # for limited processes alone: it takes a tenth of a second

    square = np.ones((300, 300))  # of a size that is not multiplied in registers alone
    dgemm(1.0, square @ square, square)  # numpy has a library of its own
