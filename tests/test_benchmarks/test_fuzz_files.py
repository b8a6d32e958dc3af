"""Some seconds of the fuzz of files, over every reader: nothing but acceptance and the project's own refusals."""

import os
import warnings

import pytest

from benchmarks.cases.fuzz import files as fuzz_files
from benchmarks.cases.fuzz.files import READERS, outcome, summary
from benchmarks.readers.file_reader import Reader
from octmip.errors import DataError

N_FILES = 4


@pytest.mark.parametrize("name", READERS)
def test_mangled_files_are_taken_or_refused_and_nothing_else(name):
    others = {seed: found for seed in range(N_FILES) if (found := outcome(name, seed)).startswith("other")}
    assert not others


def test_the_fuzz_sees_what_it_looks_for(monkeypatch):
    """A reader that raises, warns, executes or hangs is reported, as is one that refuses a valid file."""

    def reads(rng, folder):
        deeds = [lambda: 1 / 0, lambda: warnings.warn("w", stacklevel=1), lambda: os.system("true")]
        deeds[reads.number]()

    def refuses(rng, folder):
        raise DataError("no")

    for number, word in enumerate(("ZeroDivisionError", "UserWarning", "executed")):
        reads.number = number
        reader = Reader(lambda n, folder: (folder / "a").write_bytes(b"a"), "a", lambda rng, content: content, reads)
        monkeypatch.setitem(fuzz_files.READERS, "bad", reader)
        assert word in outcome("bad", 0)
    reader = Reader(lambda n, folder: (folder / "a").write_bytes(b"a"), "a", lambda rng, content: content, refuses)
    monkeypatch.setitem(fuzz_files.READERS, "bad", reader)
    found = [outcome("bad", seed) for seed in range(300)]
    assert "other: a valid file is refused" in found
    assert "refused" in found


def test_the_table_has_a_row_for_every_reader():
    lines = [{"size": "a", "files": 3, "counts": {"accepted": 1, "other": 2}, "others": [[7, "other: why"]]}]
    assert "| a | 3 | 1 | 0 | 2 |" in summary(lines)
    assert "a, file 7: other: why" in summary(lines)
