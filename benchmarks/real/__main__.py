"""Answer every blind case of a set: ``python -m benchmarks.real SET --data FOLDER --out FILE.json``."""

import argparse
from pathlib import Path

from benchmarks.real import beam
from benchmarks.real.answer import write_answers
from benchmarks.real.quadrotor import diagnosis as quadrotor

SETS = {"beam": beam.answers, "quadrotor": quadrotor.answers}


def main() -> None:
    """Read the arguments, diagnose, write the answers and say the first cause of each case."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real", description=__doc__)
    parser.add_argument("set", choices=sorted(SETS))
    parser.add_argument("--data", type=Path, required=True, help="folder of the set")
    parser.add_argument("--out", type=Path, required=True, help="where the answers go")
    given = parser.parse_args()
    if not (given.data / "tests.csv").is_file():
        parser.error(f"--data {given.data} holds no tests.csv; expected the folder of the set {given.set}; name that")
    answers = SETS[given.set](given.data)
    write_answers(given.out, answers)
    for one in answers:
        row = one.row()
        said = ", ".join(f"{c['kind']} {c['place']} {c['size']:g} ({c['probability']:.2f})" for c in row["causes"])
        print(f"{one.case}: sound {one.sound_probability:.2f}; {said or 'no cause'}; closed {row.get('closed', '-')}")


if __name__ == "__main__":
    main()
