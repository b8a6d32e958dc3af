"""A mutation run: which wrong changes of the sources the tests notice.

`python -m benchmarks.run mutants [--threads 2] [--only PATTERN] [--csv FILE]`: each mutant of `benchmarks.mutants.rows`
is made alone in a copy of the tree (the files that git knows, and the native core as it is built), never in the tree
itself, and its tests are run there until the first one fails.

    killed      a test failed
    time        the tests did not end within three times what they take without a change, `--limit` at least
    survived    all tests passed: they cannot tell the wrong program from the right one
    equivalent  all tests passed, as they must: no input tells the two apart, and the row says why

First the same tests are run without any change: where one fails then, nothing would be learnt, and the run ends.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.mutants.mutant import Mutant
from benchmarks.mutants.rows import MUTANTS
from benchmarks.tables import Line, markdown

ROOT = Path(__file__).parents[2]
NATIVE = "octmip/trees/_native*.so"
PACKAGES = ("octmip", "femlib", "benchmarks")
MOST_PROCESSES = 2
SLOWER = 3.0
"""Times what its tests take without a change that a mutant may take."""
NOTICED = ("killed", "time")


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield a line for each mutant whose name fits a regular expression."""
    chosen = [mutant for mutant in MUTANTS if re.search(only, mutant.name)]
    texts = changed_texts(chosen)
    with (
        tempfile.TemporaryDirectory() as folder,
        ThreadPoolExecutor(min(MOST_PROCESSES, max(threads))) as pool,
        _Runs(Path(folder), copied(ROOT, Path(folder) / "sound")) as runs,
    ):
        seconds = runs.sound(pool, sorted({name for mutant in chosen for name in mutant.tests}), limit)

        def outcome(mutant: Mutant, text: str) -> Line:
            usual = sum(seconds[name] for name in mutant.tests)
            return runs.outcome(mutant, text, max(limit, SLOWER * usual))

        yield from pool.map(outcome, chosen, texts)


def changed_texts(mutants: Sequence[Mutant]) -> list[str]:
    """Return the text of each mutant's file with its change made.

    Raises
    ------
    SystemExit
        one of them does not apply; all that do not are named.
    """
    texts, wrong = [], []
    for mutant in mutants:
        try:
            texts.append(mutant.changed(ROOT))
        except (OSError, ValueError) as error:
            wrong.append(str(error))
    if wrong:
        raise SystemExit("\n".join([f"{len(wrong)} mutants do not apply:", *wrong]))
    return texts


def copied(root: Path, target: Path) -> Path:
    """Return a copy of the files of a tree that git knows, and of its native core, compiled to bytecode.

    Raises
    ------
    SystemExit
        Python does not import the packages from the copy.
    """
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=root, capture_output=True, text=True, check=True).stdout
    names = [name for name in listed.split("\0") if name and (root / name).is_file()]
    for name in [*names, *(str(file.relative_to(root)) for file in root.glob(NATIVE))]:
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(root / name, target / name)
    subprocess.run([sys.executable, "-m", "compileall", "-q", *PACKAGES], cwd=target, check=True)
    asked = (
        f"import {', '.join(PACKAGES)}; print(*({', '.join(f'{name}.__path__[0]' for name in PACKAGES)},), sep='\\n')"
    )
    found = subprocess.run([sys.executable, "-c", asked], cwd=target, env=_environment(target), capture_output=True)
    places = [Path(line).parent.resolve() for line in found.stdout.decode().splitlines()]
    if set(places) != {target.resolve()}:
        raise SystemExit(f"the copy {target} is not what Python imports, but {places}: {found.stderr.decode()}")
    return target


def _environment(tree: Path) -> dict[str, str]:
    alone = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    return os.environ | alone | {"PYTHONPATH": str(tree)}


@dataclass(slots=True)
class _Runs:
    """Runs of tests, each in a copy of a sound tree; leaving the context ends those that still go on."""

    folder: Path
    tree: Path
    running: set[subprocess.Popen[str]] = field(default_factory=set)

    def __enter__(self) -> "_Runs":
        return self

    def __exit__(self, *_: object) -> None:
        for process in list(self.running):
            _end(process)

    def sound(self, pool: ThreadPoolExecutor, tests: Sequence[str], limit: float) -> dict[str, float]:
        """Return the seconds that each test file takes without a change; end where one fails."""
        found = dict(zip(tests, pool.map(lambda name: self._run((name,), {}, 10 * limit), tests), strict=True))
        failed = [f"{name}: {outcome} {said}" for name, (outcome, said, _) in found.items() if outcome != "survived"]
        if failed:
            raise SystemExit("\n".join(["tests fail without a mutant:", *failed]))
        return {name: seconds for name, (_, _, seconds) in found.items()}

    def outcome(self, mutant: Mutant, text: str, limit: float) -> Line:
        """Return the line of a mutant."""
        outcome, said, seconds = self._run(mutant.tests, {mutant.file: text}, limit)
        if mutant.equivalent and outcome == "survived":
            outcome, said = "equivalent", mutant.equivalent
        line = {"size": mutant.name, "seed": 0, "file": mutant.file, "outcome": outcome}
        return line | {"by": said, "seconds": round(seconds, 1), "tests": " ".join(mutant.tests)}

    def _run(self, tests: Sequence[str], texts: dict[str, str], limit: float) -> tuple[str, str, float]:
        """Return the outcome of tests in a copy with other texts, the first test that failed, and seconds."""
        with tempfile.TemporaryDirectory(dir=self.folder) as place:
            tree = shutil.copytree(self.tree, Path(place) / "tree")
            for name, text in texts.items():
                (tree / name).write_text(text, encoding="utf-8")
            began = time.perf_counter()
            code, said = self._pytest(tree, [f"tests/{name}" for name in tests], limit)
            seconds = time.perf_counter() - began
        if code is None:
            return "time", f"no end after {limit:.0f} s", seconds
        if code not in (0, 1):
            raise SystemExit(f"the tests {' '.join(tests)} ended with code {code}: no verdict\n{said[-3000:]}")
        failed = re.search(r"^(?:FAILED|ERROR) tests/(.+?)(?: - |$)", said, re.MULTILINE)
        return ("killed" if code else "survived"), failed.group(1) if failed else "", seconds

    def _pytest(self, tree: Path, tests: Sequence[str], limit: float) -> tuple[int | None, str]:
        command = ["nice", "-n", "10", sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
        process = subprocess.Popen(
            command,
            cwd=tree,
            env=_environment(tree),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        self.running.add(process)
        try:
            said, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            return None, ""
        finally:
            _end(process)
            self.running.discard(process)
        return process.returncode, said


def _end(process: "subprocess.Popen[str]") -> None:
    """End a run with all that it started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def summary(lines: Sequence[Line]) -> str:
    """Return the outcomes by part of the sources, and those that no test noticed."""
    counts = Counter((_part(line["file"]), line["outcome"]) for line in lines)
    outcomes = ("killed", "time", "survived", "equivalent")
    parts = sorted({part for part, _ in counts})
    table = markdown(["part", *outcomes], ([part, *(counts[part, one] for one in outcomes)] for part in parts))
    n_noticed = sum(line["outcome"] in NOTICED for line in lines)
    unseen = [f"{line['outcome']}: {line['size']} {line['by']}" for line in lines if line["outcome"] not in NOTICED]
    return "\n".join([f"{n_noticed} of {len(lines)} mutants killed.", "", table, "", *unseen])


def _part(file: str) -> str:
    """Return the package and its part: octmip.gap, octmip.trees.certificate."""
    return ".".join(Path(file).with_suffix("").parts[:2])
