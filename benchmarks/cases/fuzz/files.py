"""Mangled files: whatever a stranger's file holds, a reader takes it or refuses it with the project's own error.

For every reader, valid files of the project's own writers are mangled: by value, cell, token, column or member; byte by
byte; or replaced by what is no file to read at all (folder, pipe, device, nothing, another form). A reader may accept,
and then what it read must be harmless in use, or refuse with an `OctmipError` or `FemlibError`. Everything else is
counted as "other" and listed with its seed: another exception, a warning, more than `SLOWEST` seconds of processor
time, `LARGEST` bytes of memory, anything executed, a command with another exit code or a second line.

All readers of the two packages, each a line of the table:

    octmip.formats.tree_file.read_tree_file     tree file; with certify, predict, report, solve --incumbent
    octmip.formats.table.read_table             tables, .csv, .csv.gz, .tsv, .parquet; with solve, certify, predict
    octmip.formats.table.read_costs, .read_sensors  solve --costs, solve --sensor-cost
    octmip.trees.evidence.proof.check_proof                    proof logs, both kinds; with certify --proof
    octmip.monitor.ModelSelector.read           selector
    octmip.gap.read_campaign                    campaign, commissioning run; with diagnose
    femlib.dataset.open_dataset                 streamed dataset, and its side file
    femlib.dataset.published_strains            published table
    femlib.rom.ReducedModel.load_file           reduced model; ReducedWing.load_file reads by it
    femlib.wing.export.calculix.read_gauges     result of CalculiX
    octmip.trees.methods.checkpoint                     checkpoints of both kinds, the sum corrected after most changes
    octmip.trees.evidence.proof.check_proof                    proof log of regression trees; with certify --proof
    octmip.gap.doors.opening.table_twin           table of a twin, .csv and .parquet, and its card
    femlib.read                                 meshes: Abaqus, gmsh (text, binary), Nastran, I-DEAS, MED, VTK
    femlib.structure.calculix.read_gauges       results of CalculiX: strains,
    femlib.export.calculix_results              frequencies, displacements

Left out: what reads its own working copies under benchmarks/, /proc/self/statm, and files that ship with the package.
"""

import contextlib
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed

from benchmarks.readers.femlib import FEMLIB
from benchmarks.readers.file_reader import Reader
from benchmarks.readers.kept_states import KEPT
from benchmarks.readers.mangled_arrays import CANARY
from benchmarks.readers.mangling import mangled_bytes, pick
from benchmarks.readers.octmip import OCTMIP
from benchmarks.readers.structures import STRUCTURES
from benchmarks.readers.twins import TWINS
from benchmarks.tables import Line, markdown
from femlib.errors import FemlibError
from octmip.errors import OctmipError

READERS = OCTMIP | FEMLIB | KEPT | TWINS | STRUCTURES
STREAM = 50  # of seeds: file i of a reader is drawn from default_rng([STREAM, number of the reader, i])
N_FILES, CHUNK = 10_000, 50
SLOWEST, HANGING = 2.0, 60  # seconds: of the processor, and of the clock before it counts as hanging
LARGEST = 400 * 2**20
EXECUTED = {"os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "pickle.find_class", "socket.connect"}
OTHER_FORMS = (b"", b"\n", b"\0" * 50, b"PK\x03\x04", b"PAR1", b"\x1f\x8b\x08\x00aaaa", b"[]", b"{}", b"1,2\n")
_events: list[str] = []
_is_armed = False


class Hanging(BaseException):
    """A reader that does not come back."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each reader, after so many files or `limit` seconds: what was taken, refused, or neither."""
    for name in READERS:
        start, counts, others, done = time.monotonic(), Counter[str](), [], 0
        step = CHUNK * max(threads)
        while done < N_FILES and time.monotonic() - start < limit:
            firsts = range(done, done + step, CHUNK)
            for chunk in Parallel(n_jobs=max(threads))(delayed(outcomes)(name, first, CHUNK) for first in firsts):
                counts.update(outcome.partition(":")[0] for _, outcome in chunk)
                others += [[seed, outcome] for seed, outcome in chunk if outcome.startswith("other")]
            done += step
        yield {"size": name, "seed": STREAM, "files": done, "counts": counts, "others": others}


def outcomes(name: str, first: int, count: int) -> list[tuple[int, str]]:
    """Return the seed of each file and what became of it: "accepted", "refused", or "other: " and why."""
    return [(seed, outcome(name, seed)) for seed in range(first, first + count)]


def outcome(name: str, seed: int) -> str:
    """Mangle a file, read it and return "accepted", "refused", or "other: " and why."""
    reader = READERS[name]
    rng = np.random.default_rng([STREAM, list(READERS).index(name), seed])
    with tempfile.TemporaryDirectory() as folder:
        is_valid = place(reader, rng, Path(folder))
        found = watched(reader, rng, Path(folder))
        return "other: a valid file is refused" if is_valid and found == "refused" else found


def place(reader: Reader, rng: np.random.Generator, folder: Path) -> bool:
    """Put a reader's files into a folder, one of them mangled; or return that all are valid."""
    files = reader.files(int(rng.integers(reader.n_made)))
    for name, content in files.items():
        (folder / name).write_bytes(content)
    target, content, way = folder / reader.target, files[reader.target], rng.random()
    if way < 0.02:
        return True
    if way < 0.7:
        target.write_bytes(reader.mangle(rng, content))
    elif way < 0.95:
        target.write_bytes(mangled_bytes(rng, content))
    else:
        target.unlink()
        _other_form(rng, target)
    return False


def _other_form(rng: np.random.Generator, target: Path) -> None:
    forms: tuple[Callable[[], object], ...] = (
        lambda: os.mkfifo(target),
        lambda: target.mkdir(),
        lambda: target.symlink_to("/dev/zero"),
        lambda: target.symlink_to(target),
        lambda: None,
        lambda: target.write_bytes(pick(rng, OTHER_FORMS)),
        lambda: target.write_bytes(rng.bytes(200)),
    )
    pick(rng, forms)()


def watched(reader: Reader, rng: np.random.Generator, folder: Path) -> str:
    """Read the files of a folder under watch."""
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    with _armed(), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            reader.read(rng, folder)
            found = "accepted"
        except (OctmipError, FemlibError):
            found = "refused"
        except (Exception, Hanging) as error:  # whatever it is, it is what the fuzz looks for
            found = f"other: {_where(error)}"
    seconds = time.process_time() - start
    grown = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    if _events or CANARY in os.environ:
        found = f"other: executed {_events}"
    elif seconds > SLOWEST:
        found = f"other: {seconds:.1f} s of processor time ({found})"
    elif grown > LARGEST:
        found = f"other: memory grew by {grown / 2**20:.0f} MB ({found})"
    _events.clear()
    return found


def _where(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "site-packages" not in frame.filename and "lib/python" not in frame.filename]
    place = f"{Path(own[-1].filename).name}:{own[-1].lineno}" if own else "?"
    return f"{type(error).__name__} at {place}: {' '.join(str(error).split())[:200]}"


@contextlib.contextmanager
def _armed() -> Iterator[None]:
    """Listen to what the interpreter executes, and end what hangs."""
    global _is_armed
    if not hasattr(sys, "_octmip_fuzz_listens"):
        sys.addaudithook(_listen)  # there is no way to take a hook away: it sleeps while it is not armed
        sys._octmip_fuzz_listens = True  # type: ignore[attr-defined]
    known = signal.signal(signal.SIGALRM, _hangs)
    signal.alarm(HANGING)
    _is_armed = True
    try:
        yield
    finally:
        _is_armed = False
        signal.alarm(0)
        signal.signal(signal.SIGALRM, known)


def _listen(event: str, arguments: object) -> None:
    if _is_armed and event in EXECUTED:
        _events.append(event)


def _hangs(*_: object) -> None:
    raise Hanging(f"no end after {HANGING} s")


def summary(lines: Sequence[Line]) -> str:
    """Return what became of the files, a row a reader."""
    kinds = ("accepted", "refused", "other")
    counts = [[line["counts"].get(kind, 0) for kind in kinds] for line in lines]
    rows = [[line["size"], line["files"], *row] for line, row in zip(lines, counts, strict=True)]
    total = [sum(column) for column in zip(*counts, strict=True)]
    table = markdown(["reader", "files", "accepted", "refused", "others"], [*rows, ["all", sum(total), *total]])
    found = [f"{line['size']}, file {seed}: {why}" for line in lines for seed, why in line["others"]]
    return "\n".join([table, "", *found])
