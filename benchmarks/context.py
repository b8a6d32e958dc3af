"""Where a figure was made: the commit, and the machine with its Python."""

import os
import platform
import subprocess
from pathlib import Path


def context() -> dict[str, str]:
    """Return the commit, "" outside of a clone, and the machine."""
    here = Path(__file__).parent
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True, cwd=here)
    return {"commit": commit.stdout.strip(), "machine": _machine()}


def _machine() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor()}, {os.cpu_count()} CPUs, Python {platform.python_version()}"
