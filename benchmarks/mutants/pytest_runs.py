"""A process that has imported what tests need of others, and forks for every run of pytest: two seconds less for each.

`python -m benchmarks.mutants.pytest_runs` reads lines of JSON, [arguments, CPU seconds, file for what is said], and
answers each with [exit code, CPU seconds].
"""

import importlib
import json
import math
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Self

import pytest

IMPORTED = (
    *("scipy.optimize", "scipy.sparse.linalg", "scipy.stats", "pandas", "pyarrow", "sklearn.tree", "libcst"),
    *("sklearn.model_selection", "sklearn.utils.estimator_checks", "xml.dom.minidom", "concurrent.futures"),
)
WAIT = 8  # wall seconds for each CPU second: a test may wait for what never comes


class PytestRuns:
    """Runs of pytest in a folder whose Python sources are its own."""

    def __init__(self, tree: Path) -> None:
        self.said = tree / "said.txt"
        alone = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        environment = os.environ | alone | {"PYTHONPATH": str(tree)}
        self.server = subprocess.Popen(
            [sys.executable, __file__, *IMPORTED],
            cwd=tree,
            env=environment,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )

    def run(self, tests: Sequence[str], limit: float) -> tuple[int, str, float]:
        """Return exit code, negative past a limit of CPU seconds, what pytest said, and CPU seconds."""
        assert self.server.stdin is not None
        assert self.server.stdout is not None
        arguments = ["-x", "-vv", "-p", "no:cacheprovider", "--no-header", *tests]
        print(json.dumps([arguments, limit, str(self.said)]), file=self.server.stdin, flush=True)
        code, seconds = json.loads(self.server.stdout.readline())
        return code, self.said.read_text(encoding="utf-8", errors="replace"), seconds

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self.server:  # which closes its pipes, so that it ends
            pass


def _serve() -> None:
    sys.path[0] = os.getcwd()
    for name in sys.argv[1:]:
        importlib.import_module(name)
    for line in sys.stdin:
        arguments, limit, said = json.loads(line)
        before = _cpu()
        if (child := os.fork()) == 0:
            _be_pytest(arguments, limit, said)
        print(json.dumps([_code(child, limit), _cpu() - before]), flush=True)


def _be_pytest(arguments: list[str], limit: float, said: str) -> None:
    """Run pytest in this process, which then ends."""
    os.setsid()
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(limit), math.ceil(limit) + 1))
    signal.alarm(math.ceil(WAIT * limit))
    out = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for standard, file in ((0, os.open(os.devnull, os.O_RDONLY)), (1, out), (2, out)):
        os.dup2(file, standard)
    code = pytest.main(arguments)
    sys.stdout.flush()
    os._exit(int(code))


def _code(child: int, limit: float) -> int:
    status = os.waitpid(child, 0)[1]
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)  # with all that it started
    return os.waitstatus_to_exitcode(status)


def _cpu() -> float:
    return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


if __name__ == "__main__":
    _serve()
