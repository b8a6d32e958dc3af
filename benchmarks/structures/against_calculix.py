"""The worked structures of the documentation beside CalculiX: gauge strains under damage, natural frequencies.

    python -m benchmarks.structures.against_calculix

runs the code of docs/examples/structures/*.md, writes their structures as decks of S8R shells and B32 beams, runs
`ccx` (Debian package calculix-ccx), and prints a table for each page.
"""

import contextlib
import io
import re
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.ccx import need_ccx, run_deck
from benchmarks.main_program import run_main
from femlib.export.calculix_results import read_frequencies
from femlib.structure import Structure
from femlib.structure.calculix import read_gauges, write_deck

PAGES = Path(__file__).parents[2] / "docs" / "examples" / "structures"
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
N_MODES = 3


def main() -> None:
    """Print a table for each page."""
    need_ccx()
    for page in sorted(PAGES.glob("*.md")):
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            print_page(page, Path(folder))


def print_page(page: Path, folder: Path) -> None:
    """Print how far the structure of a page is from CalculiX's, state by state."""
    names = page_names(page)
    structure, load, gauges = names["structure"], names["load"], names["gauges"]
    states = [{}, *({name: 0.6} for name in structure.parameters), dict.fromkeys(structure.parameters, 0.8)]
    print(
        f"\n{page.stem}\n\n| state | {' | '.join(g.name for g in gauges)} | worst |\n|---|{'---|' * (len(gauges) + 1)}"
    )
    for state in states:
        ours = structure.strain_microstrain(state, load, gauges)
        write_deck(structure, folder / "own.inp", state, load, gauges)
        run_deck(folder / "own.inp")
        theirs = read_gauges(structure, folder / "own.dat", gauges)
        pairs = " | ".join(f"{a:.1f} ({b:.1f})" for a, b in zip(ours, theirs, strict=True))
        worst = np.abs(ours - theirs).max() / np.abs(theirs).max()
        print(f"| {words(state)} | {pairs} | {100 * worst:.1f} % |")
    print("\n| state | frequencies [Hz] | worst |\n|---|---|---|")
    for state in states:
        own, others = frequencies(structure, state, load, folder)
        pairs = ", ".join(f"{a:.2f} ({b:.2f})" for a, b in zip(own, others, strict=True))
        print(f"| {words(state)} | {pairs} | {100 * np.abs(own / others - 1).max():.1f} % |")


def page_names(page: Path) -> dict[str, Any]:
    """Return the names that a page's code defines, run in the current folder."""
    names: dict[str, Any] = {}
    with contextlib.redirect_stdout(io.StringIO()):
        for code in BLOCK.findall(page.read_text(encoding="utf-8")):
            exec(code, names)
    return names


def frequencies(
    structure: Structure, state: Mapping[str, float], load: NDArray[np.float64], folder: Path
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the lowest frequencies of both programs [Hz]."""
    write_deck(structure, folder / "own.inp", state, load, analysis="frequencies", n_modes=N_MODES)
    run_deck(folder / "own.inp")
    ours = np.array([mode.frequency for mode in structure.natural_modes(N_MODES, state)])
    return ours, read_frequencies(folder / "own.dat")[:N_MODES]


def words(state: Mapping[str, float]) -> str:
    """Return a state in words."""
    return ", ".join(f"{name} {100 * mu:.0f} %" for name, mu in state.items()) or "undamaged"


if __name__ == "__main__":
    run_main(main)
