"""A mutation run: which wrong changes of the sources, drawn at random, the tests notice.

`python -m benchmarks.run mutants --seed N --draws M [--only octmip/gap] [--limit 60] [--csv FILE]`. Without a seed the
clock gives one. `--only` is a folder or file of Python, or the native core (with cargo-mutants).

Each mutant is made alone in a copy of the tree. There the tests that are nearest to its module run, then the common
check of all defaults, until the first one fails, for `--limit` CPU seconds at most, and mypy last.

    killed    a test failed, or the types do not fit
    time      a test did not end, which takes a third of that time at most without the mutant
    survived  the tests passed, as far as they came: they cannot tell the wrong program from the right one
    unviable  the compiler refused it
"""

import math
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.mutants.draws import NATIVE, Mutant, python_mutant, rust_mutant
from benchmarks.mutants.nearest import NearestTests
from benchmarks.mutants.pytest_runs import PytestRuns
from benchmarks.tables import Line, markdown

ROOT = Path(__file__).parents[2]
PYTHON = ("octmip/trees", "octmip/gap", "octmip/formats", "octmip/recordings", "femlib/strength.py", "femlib/rom")
CORE = "octmip/trees/_native*.so"
NOT_COPIED = shutil.ignore_patterns(".*", "target", "results", "site", "dist")
STREAM = 97
BATCHES = (0, 1, 3, 7, 19)  # ends of tests' files: most mutants are killed by the first
COMMON = "tests/test_octmip/test_defaults.py"
TYPES = (sys.executable, "-m", "mypy")  # of `make test`, too
SLOWER = 3.0
BUILD = 600.0  # CPU seconds
PROFILE = ("--profile", "checks", "--config", "profile.checks.opt-level=1")  # its tests of Python take half the time
Outcome = tuple[str, str, float]  # the word, the first test that failed or did not end, CPU seconds


def results(limit: float, threads: Sequence[int], only: str = "", seed: int = 0, draws: int = 20) -> Iterator[Line]:
    """Yield a line for each mutant."""
    rng = np.random.default_rng([STREAM, seed := seed or int(time.time())])
    with tempfile.TemporaryDirectory() as folder:
        tree = shutil.copytree(ROOT, Path(folder) / "tree", ignore=NOT_COPIED)
        with PytestRuns(tree) as asked:
            runs, parts = _Runs(tree, limit, asked), (only,) if only else PYTHON
            if only == NATIVE:
                runs.build()
            for _ in range(draws):
                mutant = rust_mutant(rng, ROOT) if only == NATIVE else python_mutant(rng, ROOT, parts)
                yield {"size": str(mutant), "seed": seed, "file": mutant.file} | runs.line(mutant)


class _Runs:
    """Runs of tests in a copy of the tree."""

    def __init__(self, tree: Path, limit: float, asked: PytestRuns) -> None:
        self.tree, self.limit, self.pytest = tree, limit, asked
        self.nearest, self.n_kills = NearestTests(tree), Counter[tuple[str, str]]()
        target = os.environ.get("CARGO_TARGET_DIR", tree / NATIVE / "target")
        self.core, self.made = next(tree.glob(CORE), tree), Path(target, "checks/lib_native.so")

    def build(self) -> None:
        """Build the core as those of its mutants are built, so that their tests take as long without a mutant."""
        code, said, _ = self._cargo("build")
        if code != 0:
            raise SystemExit(f"the native core does not build: {said}")
        shutil.copy2(self.made, self.core)

    def line(self, mutant: Mutant) -> Line:
        """Return the outcome of a mutant; the copy is then as it was."""
        nearest = self.nearest.of(mutant.file, mutant.line)[: BATCHES[-1] - 1]
        tests = sorted(nearest, key=lambda test: -self.n_kills[mutant.file, test])
        tests += [COMMON] * (self.tree / COMMON).exists()
        with _replaced(self.tree / mutant.file, mutant.after.encode()), ExitStack() as built:
            found = self._refused(built) if mutant.file.endswith(".rs") else None
            outcome, said, seconds = found or self._tested(tests)
        if outcome == "time":
            without, _, usual = self._pytest([said])
            outcome = "time" if without == "survived" and usual < self.limit / SLOWER else "survived"
        self.n_kills[mutant.file, f"tests/{said.partition('::')[0]}"] += outcome == "killed"
        line = {"operator": mutant.operator, "outcome": outcome, "by": said, "seconds": round(seconds, 1)}
        return line | {"tests": " ".join(tests)}

    def _tested(self, tests: Sequence[str]) -> Outcome:
        found: Outcome = ("survived", "", 0.0)
        for some in (tests[a:b] for a, b in pairwise(BATCHES)):
            if some and found[0] == "survived":
                found = self._pytest(some)
                if found[0] == "time":  # by one test, or by all of them
                    found = self._pytest([found[1]])
        if found[0] == "survived" and self._run(TYPES, self.tree, BUILD)[0] == 1:
            return "killed", "mypy", found[2]
        return found

    def _refused(self, built: ExitStack) -> Outcome | None:
        """Return the outcome by compiler and tests of the crates; None where these pass: the core is then built."""
        for words in ("build", "test"):
            code, said, seconds = self._cargo(words)
            if code != 0:
                failed = re.search(r"^test (\S+) \.\.\. FAILED", said, re.MULTILINE)
                return "killed" if words == "test" else "unviable", failed.group(1) if failed else "", seconds
            if words != "test":
                built.enter_context(_replaced(self.core, self.made.read_bytes()))
        return None

    def _cargo(self, words: str) -> tuple[int, str, float]:
        command = ["cargo", words, *PROFILE, "--workspace"]
        return self._run(command, self.tree / NATIVE, BUILD)

    def _pytest(self, tests: Sequence[str]) -> Outcome:
        code, said, seconds = self.pytest.run(tests, self.limit)
        if code < 0:
            return "time", said.splitlines()[-1].strip(), seconds
        failed = re.search(r"^(?:FAILED|ERROR) tests/(.+?)(?: - |$)", said, re.MULTILINE)
        return ("killed" if code else "survived"), failed.group(1) if failed else "", seconds

    def _run(self, command: Sequence[str], place: Path, limit: float) -> tuple[int, str, float]:
        """Return the code of a command, negative past a limit of CPU seconds, its words and CPU seconds."""
        alone = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "CARGO_INCREMENTAL"), "1")
        environment = os.environ | alone | {"PYTHONPATH": str(self.tree)}
        before = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
        with tempfile.TemporaryFile("w+") as said:
            process = subprocess.Popen(
                ["prlimit", f"--cpu={math.ceil(limit)}", *command],
                cwd=place,
                env=environment,
                stdout=said,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            with suppress(subprocess.TimeoutExpired):  # it waits for what never comes
                process.wait(10 * limit)
            with suppress(ProcessLookupError):  # with all that it started
                os.killpg(process.pid, signal.SIGKILL)
            code = process.wait()
            said.seek(0)
            return code, said.read(), sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) - before


@contextmanager
def _replaced(file: Path, content: bytes) -> Iterator[None]:
    sound = file.with_suffix(".sound")
    shutil.copy2(file, sound)
    file.write_bytes(content)
    try:
        yield
    finally:
        os.replace(sound, file)


def summary(lines: Sequence[Line]) -> str:
    """Return the outcomes by part of the sources, and those that no test noticed."""
    outcomes = ("killed", "time", "survived", "unviable")
    counts = Counter(("/".join(Path(line["file"]).parts[:2]), line["outcome"]) for line in lines)
    parts = sorted({part for part, _ in counts})
    table = markdown(["part", *outcomes], ([part, *(counts[part, one] for one in outcomes)] for part in parts))
    unseen = [f"survived: {line['size']}" for line in lines if line["outcome"] == "survived"]
    tried = sum(line["outcome"] != "unviable" for line in lines)
    return "\n".join([f"{tried - len(unseen)} of {tried} mutants killed.", "", table, "", *unseen])
