"""`python -m benchmarks.real.damper --data FOLDER --out answers.json [--picture FILE.png]`."""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from benchmarks.main_program import run_main
from benchmarks.real.damper.answers import ACCUSED, WORTH, SeriesVerdict, answers, diagnose_tests
from benchmarks.real.damper.picture import picture
from benchmarks.real.damper.series import read_folder
from octmip.errors import OctmipError
from octmip.formats.files import check_writable, write_bytes


def show(verdict: SeriesVerdict) -> None:
    """Print one series' verdict in words."""
    bad = [(test.name, p) for test, p in zip(verdict.tests, verdict.wrong, strict=True) if p > ACCUSED]
    print(f"series {verdict.name}: {len(verdict.tests)} tests")
    names = ", ".join(f"{name} ({p:.2f})" for name, p in bad)
    print(f"  tension readings that cannot be right: {names or 'none'}; of the others at most", end=" ")
    print(f"{max((p for p in verdict.wrong if p <= ACCUSED), default=0.0):.2f}")
    for size in verdict.lacking.sizes:
        lacks = "the twin lacks" if size.worth >= WORTH else "minor:"
        print(
            f"  {lacks} {size.name.replace('_', ' ')}: {size.size:.3g} {size.unit} "
            f"({size.low:.3g} to {size.high:.3g}), probability {size.probability:.2f}"
        )
    told = verdict.closed
    print(f"  force on held-out tests: {told.share:.1%} of the square closed (a free regression: {told.limit:.1%})")


def main(words: Sequence[str] | None = None) -> None:
    """Diagnose a folder, write the answers, print them in words, draw; `words` are the command line's by default."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real.damper", description=__doc__)
    parser.add_argument("--data", type=Path, required=True, metavar="FOLDER", help="tests.csv and one CSV a test")
    parser.add_argument("--out", type=Path, metavar="FILE.json")
    parser.add_argument("--picture", metavar="FILE.png")
    asked = parser.parse_args(words)
    try:
        for path in filter(None, (asked.out, asked.picture)):
            check_writable(path)
        verdicts = diagnose_tests(read_folder(asked.data))
    except OctmipError as error:
        parser.error(str(error))
    for verdict in verdicts:
        show(verdict)
    if asked.out:
        write_bytes(asked.out, (json.dumps(answers(verdicts), indent=1) + "\n").encode())
    if asked.picture:
        picture(verdicts, asked.picture)


if __name__ == "__main__":
    run_main(main)
