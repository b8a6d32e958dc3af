"""The shells against the standard problems: ratio to the published answer, by elements a side."""

from collections.abc import Iterator, Sequence

from benchmarks.oracles.shell_problems import BEAM_SHAPES, CONVERGING, curved_beam, straight_beam
from benchmarks.tables import Line

SIZES = (4, 8, 16, 32)
DIRECTIONS = {"u": "extension", "v": "in plane", "w": "out of plane", "x": "twist"}


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each problem and size, and for each beam of MacNeal and Harder."""
    yield from plates_and_shells(SIZES)
    yield from beams()


def plates_and_shells(sizes: Sequence[int]) -> Iterator[Line]:
    """Yield the ratio to the published answer of each problem with so many elements a side."""
    for name, problem in CONVERGING.items():
        for n in sizes:
            yield {"size": f"{name}, {n} a side", "seed": 0, "problem": name, "n": n, "ratio": problem(n)}


def beams() -> Iterator[Line]:
    """Yield the ratio to beam theory of each beam of six elements, by the direction of its load."""
    for shape in BEAM_SHAPES:
        ratios = {DIRECTIONS[d]: straight_beam(shape, d) for d in DIRECTIONS}
        yield {"size": f"straight beam, {shape}", "seed": 0, "beam": f"straight, {shape}", "ratios": ratios}
    ring = {"in plane": curved_beam("u"), "out of plane": curved_beam("w")}
    yield {"size": "curved beam", "seed": 0, "beam": "curved", "ratios": ring}


def summary(lines: Sequence[Line]) -> str:
    """Return the two tables of docs/wing.md."""
    sizes = sorted({line["n"] for line in lines if "n" in line})
    table = ["| problem | " + " | ".join(map(str, sizes)) + " |", "|" + "---|" * (1 + len(sizes))]
    for name in dict.fromkeys(line["problem"] for line in lines if "n" in line):
        ratios = [line["ratio"] for line in lines if line.get("problem") == name]
        table.append(f"| {name} | " + " | ".join(f"{ratio:.4f}" for ratio in ratios) + " |")
    words = list(DIRECTIONS.values())
    table += ["", "| beam, 6 elements | " + " | ".join(words) + " |", "|" + "---|" * (1 + len(words))]
    for line in lines:
        if "beam" in line:
            cells = [f"{line['ratios'][word]:.3f}" if word in line["ratios"] else "-" for word in words]
            table.append(f"| {line['beam']} | " + " | ".join(cells) + " |")
    return "\n".join(table)
