"""CalculiX's program `ccx` (Debian package calculix-ccx): whether it is there, and a deck run by it."""

import os
import shutil
import subprocess
from pathlib import Path


def has_ccx() -> bool:
    """Return whether the program can be run."""
    return shutil.which("ccx") is not None


def run_deck(deck: Path) -> None:
    """Solve a deck (.inp) on one thread; the results (.dat, .frd) lie beside it.

    Raises
    ------
    RuntimeError
        If CalculiX stops.
    """
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1"}
    command = ["ccx", deck.stem]
    done = subprocess.run(command, cwd=deck.parent, check=False, capture_output=True, env=one_thread, text=True)
    if done.returncode:
        reason = [line.strip() for line in done.stdout.splitlines() if "*ERROR" in line] or [f"{done.returncode}"]
        raise RuntimeError(f"CalculiX stopped: {reason[0]}")
